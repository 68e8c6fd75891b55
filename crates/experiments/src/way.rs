//! The ways to fill containers that are compared, of a file such as `experiments/filling.json`.

use std::path::Path;

use ppnpack_cli::failure::{Failure, Outcome};
use ppnpack_packing::kernel::grid::GridSettings;
use ppnpack_packing::planning::method::{Method, SET_ASIDE};
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
    pub(crate) set_aside: usize,
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
    /// The only one of a file; without a file the default.
    pub(crate) fn read_one(path: Option<&Path>) -> Outcome<Self> {
        let Some(path) = path else {
            return Ok(Self::default());
        };
        let mut ways = read(path)?;
        match (ways.pop(), ways.is_empty()) {
            (Some(way), true) => Ok(way),
            _ => Err(Failure::input(format_args!(
                "{}: one method is needed, not several",
                path.display()
            ))),
        }
    }

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

fn read(path: &Path) -> Outcome<Vec<Way>> {
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

/// The ways of a file, or the first of them and those of these names, where there are any.
pub(crate) fn chosen(path: &Path, only: &[String]) -> Outcome<Vec<Way>> {
    let ways = read(path)?;
    let names: Vec<&str> = ways.iter().map(|way| way.name.as_str()).collect();
    if let Some(unknown) = only.iter().find(|name| !names.contains(&name.as_str())) {
        return Err(Failure::input(format_args!(
            "--only {unknown:?}: there is no such method; there are {names:?}"
        )));
    }
    let is_chosen =
        |(index, way): &(usize, Way)| *index == 0 || only.is_empty() || only.contains(&way.name);
    let ways = ways.into_iter().enumerate().filter(is_chosen);
    Ok(ways.map(|(_, way)| way).collect())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn file(name: &str) -> std::path::PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../experiments")
            .join(name)
    }

    #[test]
    fn what_is_compared_is_possible_and_no_way_is_like_another() {
        for name in ["filling.json", "effort.json", "limits.json", "views.json"] {
            let ways = chosen(&file(name), &[]).unwrap();
            let names: BTreeSet<&str> = ways.iter().map(|way| way.name.as_str()).collect();
            assert_eq!(names.len(), ways.len());
        }
    }

    #[test]
    fn methods_are_chosen_by_name_and_the_first_is_always_there() {
        let names = |only: &[&str]| {
            let only: Vec<String> = only.iter().map(ToString::to_string).collect();
            let ways = chosen(&file("filling.json"), &only);
            ways.map(|ways| ways.into_iter().map(|way| way.name).collect::<Vec<_>>())
        };
        let chosen = names(&["as ppnpack pack", "tried"]).unwrap();
        assert_eq!(chosen, ["published test", "tried", "as ppnpack pack"]);
        let refused = names(&["tried", "1 try"]).unwrap_err().to_string();
        assert!(refused.contains("1 try") && refused.contains("tried, 4 poses"));
    }
}
