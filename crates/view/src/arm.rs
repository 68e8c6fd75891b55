//! The arm of a record's settings, and its way over the cycle of a decision.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use nalgebra::Point3;
use ppnpack_packing::checks::motion::{self, Cycle, JointPoint, LegKind, MAX_POINTS};
use ppnpack_robot::arm::Arm;
use ppnpack_robot::arms;
use ppnpack_robot::error::ParameterError;
use ppnpack_robot::joints::JointAngles;
use ppnpack_robot::station::StationSettings;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::{convert, v1};
use serde::Deserialize;

/// Maximum of settings whose arms are kept before all are forgotten and made anew.
const MOST_KEPT: usize = 64;

/// Maximum turn of a joint between two drawn points, in radians: a metre away, the arc is 0.3 mm
/// from its chord.
const STEP_RAD: f64 = 0.05;

/// An arm and its way over a cycle, as lines. In the container frame, in metres.
pub(crate) struct ArmLines {
    /// The origins of the arm's base and links, the flange and the cup's tip, in this order, as the
    /// arm lets go of the item; empty where the cycle does not say when it does.
    pub(crate) links: Vec<Point3<f64>>,
    pub(crate) legs: Vec<Leg>,
    pub(crate) cycle_s: f64,
}

/// The way of the cup's tip over a leg of a cycle.
pub(crate) struct Leg {
    pub(crate) kind: LegKind,
    pub(crate) points: Vec<Point3<f64>>,
}

/// The arms of cells, by the settings that records have.
#[derive(Default)]
pub(crate) struct Arms {
    kept: HashMap<String, CellArms>,
}

impl Arms {
    /// Gives the arm that carries out a decision, and its way. `None` where the decision has no
    /// cycle, or an impossible one, and where its arm is not known here.
    pub(crate) fn lines(
        &mut self,
        cell: &Cell,
        settings: &str,
        decision: &v1::Decision,
    ) -> Option<ArmLines> {
        let cycle = convert::cycle::read(decision.cycle.as_deref()?);
        let cycle = cycle
            .inspect_err(|error| tracing::warn!(%cell, %error, "a cycle is not drawn"))
            .ok()?;
        let arm = self
            .of_cell(cell, settings)
            .of_container(&decision.container)?;
        // A file of the same path may be of another arm here.
        (arm.name() == cycle.arm).then(|| lines(arm, &cycle))
    }

    fn of_cell(&mut self, cell: &Cell, settings: &str) -> &CellArms {
        if self.kept.len() >= MOST_KEPT && !self.kept.contains_key(settings) {
            self.kept.clear();
        }
        self.kept
            .entry(settings.to_owned())
            .or_insert_with(|| CellArms::read(cell, settings))
    }
}

/// The part of a cell's settings, or of a container's, that is about arms.
#[derive(Deserialize)]
struct CellSettings {
    arm: Option<StationSettings>,
    #[serde(default)]
    containers: BTreeMap<String, CellSettings>,
}

/// The arms of a cell; `None` stands for one that is not known here.
#[derive(Default)]
struct CellArms {
    own: Option<Arm>,
    /// The arm as it stands to each container whose settings say so.
    containers: BTreeMap<String, Option<Arm>>,
}

impl CellArms {
    /// Reads the settings. Logs once what cannot be read or made; then it is `None`.
    fn read(cell: &Cell, settings: &str) -> Self {
        let settings: CellSettings = match serde_json::from_str(settings) {
            Ok(settings) => settings,
            Err(error) => {
                tracing::warn!(%cell, %error, "settings cannot be read: no arm is drawn");
                return Self::default();
            }
        };
        let known = |station: &StationSettings| {
            arm(station)
                .inspect_err(|error| tracing::warn!(%cell, %error, "an arm is not drawn"))
                .ok()
        };
        let containers = settings.containers.into_iter();
        let containers = containers.filter_map(|(name, own)| Some((name, known(&own.arm?))));
        Self {
            containers: containers.collect(),
            own: settings.arm.as_ref().and_then(known),
        }
    }

    /// Gives the arm as it stands to a container.
    fn of_container(&self, name: &str) -> Option<&Arm> {
        let own = self.containers.get(name).unwrap_or(&self.own);
        own.as_ref()
    }
}

fn arm(station: &StationSettings) -> Result<Arm, ParameterError> {
    let path = Path::new(&station.arm);
    let is_file = arms::text(&station.arm).is_none() && path.exists();
    // The path is one of the planner's machine: here it may be a pipe that nothing ever comes out
    // of.
    if is_file && !path.is_file() {
        return Err(ParameterError::File {
            path: station.arm.clone(),
            reason: "it is no file".to_owned(),
        });
    }
    Arm::new(&station.parameters()?)
}

fn lines(arm: &Arm, cycle: &Cycle) -> ArmLines {
    let insert = cycle.legs.iter().find(|leg| leg.kind == LegKind::Insert);
    let release = insert.and_then(|leg| leg.points.last());
    let legs = cycle.legs.iter().map(|leg| Leg {
        kind: leg.kind,
        points: tip_path(arm, leg),
    });
    ArmLines {
        links: release.map_or_else(Vec::new, |at| links(arm, at)),
        legs: legs.collect(),
        cycle_s: cycle.cycle_s,
    }
}

/// Gives the origins of the links and the cup's tip, in the container frame.
fn links(arm: &Arm, at: &JointPoint) -> Vec<Point3<f64>> {
    let joints = JointAngles::new(at.position_rad);
    let links = arm.container_from_links(&joints);
    let origins = links.map(|link| Point3::from(link.translation.vector));
    origins.into_iter().chain([arm.lip(&joints)]).collect()
}

/// Gives the way of the cup's tip over a leg, in the container frame: at its points, and between
/// them where they are far apart.
fn tip_path(arm: &Arm, leg: &motion::Leg) -> Vec<Point3<f64>> {
    // Points are from the wire: however far apart, a leg has no more points than one may have.
    let most = (MAX_POINTS / leg.points.len().max(1)).max(1);
    let pairs = leg.points.iter().zip(leg.points.iter().skip(1));
    let times_s = pairs.flat_map(|(from, to)| {
        let steps = ((turn_rad(from, to) / STEP_RAD).ceil() as usize).clamp(1, most);
        let step_s = (to.time_s - from.time_s) / steps as f64;
        (0..steps).map(move |step| from.time_s + step as f64 * step_s)
    });
    let times_s = times_s.chain([leg.duration_s()]);
    let joints = times_s.filter_map(|time_s| leg.joints_rad(time_s));
    joints
        .map(|joints_rad| arm.lip(&JointAngles::new(joints_rad)))
        .collect()
}

/// Gives the greatest turn of a joint between two points, in radians.
fn turn_rad(from: &JointPoint, to: &JointPoint) -> f64 {
    let turns = from.position_rad.iter().zip(&to.position_rad);
    let turns = turns.map(|(from, to)| (to - from).abs());
    turns.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    fn point(time_s: f64, turn_rad: f64) -> JointPoint {
        JointPoint {
            time_s,
            position_rad: [turn_rad, 0.4, 0.3, 0.2, 0.1, 0.0],
        }
    }

    fn leg(points: Vec<JointPoint>) -> motion::Leg {
        motion::Leg {
            kind: LegKind::Transfer,
            points,
        }
    }

    #[test]
    fn the_way_between_two_points_is_that_of_the_joints() {
        let arm = arms::arm("nachi-mz07l").unwrap();
        let ends = leg(vec![point(0.0, 0.0), point(1.5, FRAC_PI_2)]);
        let way = tip_path(&arm, &ends);
        assert!((32..40).contains(&way.len()), "{}", way.len());
        // J1 alone turns: an arc about the vertical through the base. A straight line between the
        // ends would cut off a third of it.
        let base = arm.container_from_links(&JointAngles::new([0.0; 6]))[0];
        let from_axis = |at: &Point3<f64>| (at - Point3::from(base.translation.vector)).xy().norm();
        let (radius_m, height_m) = (from_axis(&way[0]), way[0].z);
        assert!(radius_m > 0.1, "{radius_m}");
        for pair in way.windows(2) {
            let step_m = (pair[1] - pair[0]).norm();
            assert!(step_m > 0.0 && step_m < 1.1 * STEP_RAD * radius_m);
            assert!((from_axis(&pair[1]) - radius_m).abs() < 1e-9);
            assert!((pair[1].z - height_m).abs() < 1e-9);
        }
        let last = arm.lip(&JointAngles::new(point(0.0, FRAC_PI_2).position_rad));
        assert!((way[way.len() - 1] - last).norm() < 1e-9);
    }

    #[test]
    fn a_leg_is_drawn_with_no_more_points_than_one_may_have() {
        let arm = arms::arm("nachi-mz07l").unwrap();
        let turns = |count: u32| {
            let back_and_forth = (0..count).map(|at| {
                let turn_rad = if at % 2 == 0 { -12.0 } else { 12.0 };
                point(f64::from(at), turn_rad)
            });
            tip_path(&arm, &leg(back_and_forth.collect())).len()
        };
        assert_eq!(turns(0), 0);
        assert_eq!(turns(1), 1);
        for count in [2, 3, 1_001, 2_000] {
            let points = turns(count);
            assert!(points >= count as usize, "{count}: {points}");
            assert!(points <= MAX_POINTS, "{count}: {points}");
        }
    }

    #[test]
    fn an_arm_is_made_once_and_so_is_what_is_said_of_one_that_is_not_there() {
        let cell = Cell::new("cell-1").unwrap();
        let mut arms = Arms::default();
        for _ in 0..3 {
            let known = arms.of_cell(&cell, r#"{"arm": {}, "containers": {"left": {}}}"#);
            assert!(known.of_container("").is_some());
            assert!(known.of_container("left").is_some());
            let text = r#"{"arm": {}, "containers": {"left": {"arm": {"arm": "r2d2"}}}}"#;
            let other = arms.of_cell(&cell, text);
            assert!(other.of_container("right").is_some());
            assert!(other.of_container("left").is_none());
            assert!(arms.of_cell(&cell, "{}").of_container("").is_none());
        }
        assert_eq!(arms.kept.len(), 3);
        for number in 0..200 {
            arms.of_cell(&cell, &format!("{{\"yaws\": {number}}}"));
            assert!(arms.kept.len() <= MOST_KEPT);
        }
    }
}
