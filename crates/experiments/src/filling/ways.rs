//! The ways to fill containers that are compared.

use std::path::Path;

use clap::ValueEnum;
use ppnpack_cli::failure::{Failure, Outcome};
use ppnpack_cli::options::ViewOptions;
use ppnpack_packing::grid::GridSettings;
use ppnpack_packing::method::{Method, SET_ASIDE, Stability};
use ppnpack_packing::objective::Weights;
use ppnpack_packing::scene_value::SceneValue;
use ppnpack_packing::trial::{TrialLimits, TrialSettings};
use ppnpack_physics::view::CameraSettings;
use serde::{Deserialize, Serialize};

/// The most poses of an object, as of `ppnpack pack`.
const MOST_POSES: usize = 6;

/// A way to fill containers. The default is what `ppnpack pack` does where nothing is said.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Way {
    pub(crate) name: String,
    pub(crate) grid: GridSettings,
    /// In how many poses an object is offered at most.
    pub(crate) poses: usize,
    /// How many items may be set aside.
    pub(crate) set_aside: usize,
    /// Threads that try placements.
    pub(crate) threads: usize,
    pub(crate) method: Method,
    /// The cameras that see the container; without, it is scanned exactly.
    pub(crate) camera: Option<CameraSettings>,
}

impl Default for Way {
    fn default() -> Self {
        Self {
            name: String::new(),
            grid: GridSettings::default(),
            poses: 1,
            set_aside: SET_ASIDE,
            threads: 1,
            method: Method::default(),
            camera: None,
        }
    }
}

impl Way {
    /// The paper's objective on 5 mm and 8 yaws, and tries within what counts as steady; changed.
    fn new(name: impl Into<String>, change: impl FnOnce(&mut Self)) -> Self {
        let mut way = Self {
            name: name.into(),
            set_aside: 0,
            ..Self::default()
        };
        way.grid.cell_m = 0.005;
        way.grid.yaws = 8;
        way.method.trial.limits = within(30.0, 20.0);
        way.method.weights = Some(Weights::default());
        way.method.scene_value = SceneValue::off();
        change(&mut way);
        way
    }

    /// The same way behind the cameras that are asked for, where it has none of its own.
    pub(crate) fn seen_by(self, view: &ViewOptions) -> Self {
        Self {
            camera: self.camera.or_else(|| view.camera(0)),
            ..self
        }
    }

    /// The only one of a file.
    pub(crate) fn read_one(path: &Path) -> Outcome<Self> {
        let mut ways = read(path)?;
        match (ways.pop(), ways.is_empty()) {
            (Some(way), true) => Ok(way),
            _ => Err(Failure::input(format_args!(
                "{}: one method is needed, not several",
                path.display()
            ))),
        }
    }

    /// No placement is tried; a geometric test decides, or none.
    fn untried(name: &str, stability: Stability) -> Self {
        Self::new(name, |way| {
            way.method.stability = stability;
            way.method.trial = TrialSettings::off();
        })
    }

    /// Placements are tried, judged by the weights that suit the number of poses.
    fn tried(name: impl Into<String>, change: impl FnOnce(&mut Self)) -> Self {
        Self::new(name, |way| {
            change(way);
            way.method.weights = Some(Weights::for_poses(way.poses));
        })
    }

    /// Checks that it is possible, before others are run for long.
    fn validate(&self) -> Result<(), String> {
        if !(1..=MOST_POSES).contains(&self.poses) {
            return Err(format!(
                "poses must be 1 to {MOST_POSES}, but is {}",
                self.poses
            ));
        }
        let grid = self.grid.build().map_err(|error| error.to_string())?;
        let camera = self.camera.map(|camera| camera.validate(grid.container()));
        camera.transpose().map_err(|error| error.to_string())?;
        let method = self.method.validate();
        method.map_err(|error| error.to_string())
    }
}

/// What is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Comparison {
    /// What each stage brings: tries, resting poses, setting aside
    Stages,
    /// How many placements of an item a step tries
    Efforts,
    /// The limits of tilt and slide that a tried placement has to keep within
    Limits,
    /// What sees the container: an exact scan, one camera, two
    Views,
}

impl Comparison {
    /// What its document and its chart are named.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Stages => "filling",
            Self::Efforts => "effort",
            Self::Limits => "limits",
            Self::Views => "views",
        }
    }

    /// The heading of its document.
    pub(super) fn title(self) -> &'static str {
        match self {
            Self::Stages => "Filling: how full, how steady",
            Self::Efforts => "Effort: what more time brings",
            Self::Limits => "Limits: volume against steadiness",
            Self::Views => "Views: what a camera costs",
        }
    }

    /// What the others are compared with.
    fn first(self) -> Way {
        match self {
            Self::Views => as_pack("exact scan", None),
            _ => Way::untried("published test", Stability::Published),
        }
    }

    /// What is compared; the others are compared with the first. Of them only those of these names, where there are any.
    pub(super) fn ways(self, only: &[String]) -> Outcome<Vec<Way>> {
        let mut compared = match self {
            Self::Stages => stages(),
            Self::Efforts => efforts(),
            Self::Limits => limits(),
            Self::Views => views(),
        };
        let names: Vec<&str> = compared.iter().map(|way| way.name.as_str()).collect();
        if let Some(unknown) = only.iter().find(|name| !names.contains(&name.as_str())) {
            return Err(Failure::input(format_args!(
                "--only {unknown:?}: there is no such method; there are {names:?}"
            )));
        }
        compared.retain(|way| only.is_empty() || only.contains(&way.name));
        compared.insert(0, self.first());
        Ok(compared)
    }
}

/// What `ppnpack pack` does where nothing is said.
fn as_pack(name: &str, camera: Option<CameraSettings>) -> Way {
    Way {
        name: name.to_owned(),
        camera,
        ..Way::default()
    }
}

fn views() -> Vec<Way> {
    let of = |cameras| CameraSettings {
        cameras,
        ..CameraSettings::default()
    };
    vec![
        as_pack("one camera", Some(of(1))),
        as_pack("two cameras", Some(of(2))),
    ]
}

fn stages() -> Vec<Way> {
    let aside = |way: &mut Way| way.set_aside = 20;
    let posed = |way: &mut Way| way.poses = 4;
    let fine = |way: &mut Way| {
        way.grid.cell_m = 0.0025;
        way.grid.yaws = 16;
    };
    vec![
        Way::tried("tried", |_| ()),
        Way::tried("tried, 4 poses", posed),
        Way::tried("tried, 20 set aside", aside),
        Way::tried("tried, 4 poses, 20 set aside", |way| {
            posed(way);
            aside(way);
        }),
        Way::tried("tried, 20 set aside, 2.5 mm and 16 yaws", |way| {
            fine(way);
            aside(way);
        }),
        as_pack("as ppnpack pack", None),
        Way::new("tried, published weights", |_| ()),
        Way::untried("no test", Stability::None),
        Way::untried("physical test", Stability::Physical),
    ]
}

fn efforts() -> Vec<Way> {
    let tried = |tries: usize| {
        let name = match tries {
            1 => "1 try".to_owned(),
            _ => format!("{tries} tries"),
        };
        Way::tried(name, |way| {
            way.method.trial.tries_per_item = tries;
        })
    };
    [0, 1, 3, 10, 40, 160].map(tried).to_vec()
}

fn limits() -> Vec<Way> {
    let way = |(tilt, slide_mm): (f64, f64)| {
        Way::tried(format!("{tilt:.0} degrees, {slide_mm:.0} mm"), |way| {
            way.method.trial.limits = within(tilt, slide_mm);
        })
    };
    let limits = [
        (8.0, 6.0),
        (15.0, 12.0),
        (20.0, 15.0),
        (25.0, 18.0),
        (30.0, 20.0),
        (35.0, 30.0),
        (60.0, 60.0),
    ];
    limits.map(way).to_vec()
}

/// The usual limits but for tilt and slide.
fn within(tilt_degrees: f64, slide_mm: f64) -> TrialLimits {
    TrialLimits {
        tilt_rad: tilt_degrees.to_radians(),
        slide_m: slide_mm * 1e-3,
        ..TrialLimits::default()
    }
}

/// The ways of a file.
pub(super) fn read(path: &Path) -> Outcome<Vec<Way>> {
    let wrong = |error: &dyn std::fmt::Display| {
        Failure::input(format_args!("--methods {}: {error}", path.display()))
    };
    let text = std::fs::read_to_string(path).map_err(|error| wrong(&error))?;
    let ways: Vec<Way> = serde_json::from_str(&text).map_err(|error| wrong(&error))?;
    if ways.is_empty() {
        return Err(wrong(&"there is no method"));
    }
    for way in &ways {
        let named = |error| wrong(&format_args!("{}: {error}", way.name));
        way.validate().map_err(named)?;
    }
    Ok(ways)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn what_is_compared_is_possible_and_no_way_is_like_another() {
        for comparison in Comparison::value_variants() {
            let ways = comparison.ways(&[]).unwrap();
            let names: BTreeSet<&str> = ways.iter().map(|way| way.name.as_str()).collect();
            assert_eq!(names.len(), ways.len());
            for way in &ways {
                way.validate().unwrap();
            }
        }
    }

    #[test]
    fn methods_are_chosen_by_name_and_the_first_is_always_there() {
        let names = |only: &[&str]| {
            let only: Vec<String> = only.iter().map(ToString::to_string).collect();
            let ways = Comparison::Stages.ways(&only);
            ways.map(|ways| ways.into_iter().map(|way| way.name).collect::<Vec<_>>())
        };
        let chosen = names(&["as ppnpack pack", "tried"]).unwrap();
        assert_eq!(chosen, ["published test", "tried", "as ppnpack pack"]);
        let refused = names(&["tried", "1 try"]).unwrap_err().to_string();
        assert!(refused.contains("1 try") && refused.contains("tried, 4 poses"));
    }
}
