//! Cells of several kinds in one stack, with the services' settings for them.

use ppnpack_wire::keys::Service;
use rand::RngExt;

use crate::stack::COARSE;

/// A kind of cell, by its sensor and robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Seen exactly, packed by a robot that makes every placement.
    Plain,
    /// Seen by a noisy camera; placed items are inspected, and now and then the gripper misses or
    /// drops one.
    Camera,
    /// Packed by an arm, which cannot hold or reach everything.
    Arm,
}

impl Kind {
    /// The kind of each of so many cells: one after the other, or all plain.
    pub(crate) fn of_cells(count: usize, are_plain: bool) -> Vec<Self> {
        let kinds = [Self::Plain, Self::Camera, Self::Arm];
        let kinds = if are_plain { &kinds[..1] } else { &kinds[..] };
        kinds.iter().copied().cycle().take(count).collect()
    }

    /// Whether an item may leave the cell, or be taken for missing: somebody has to look then.
    pub(crate) fn may_lose(self) -> bool {
        self == Self::Camera
    }
}

/// The usual time of the arm's planned cycles, in seconds.
const CYCLE_S: f64 = 2.0;

/// The maximum of items that an arm sets aside before it gives a container up.
const SET_ASIDE: usize = 40;

/// The bridge's settings of a cell with a camera.
const CAMERA: [&str; 2] = [
    "scan=\"camera\"",
    "camera={noise={sigma_m=0.001,dropout=0.05}}",
];

/// The chances of its robot to miss or drop an item.
const MISHAPS: &str = "missed_picks=0.02,drops=0.03";

/// Perception's settings for such a camera.
const MAPPER: &str =
    "mapper={noise_m=0.001,point_radius_m=0.001,largest_hole_m=0.005,wall_margin_m=0.003}";

/// Settings of planner and bridge for cells of these kinds, whose robots take so many seconds for a
/// placement.
pub(crate) fn settings(cells: &[(String, Kind)], place_duration_s: f64) -> Vec<(Service, String)> {
    let of_cells = cells.iter().flat_map(|(cell, kind)| {
        let of_cell = [
            (Service::Planner, planner(*kind)),
            (Service::Bridge, bridge(*kind, place_duration_s)),
        ];
        of_cell.into_iter().flat_map(move |(service, settings)| {
            let settings = settings.into_iter();
            settings.map(move |setting| (service, format!("service.cells.{cell}.{setting}")))
        })
    });
    of_cells.collect()
}

fn planner(kind: Kind) -> Vec<String> {
    match kind {
        Kind::Plain => Vec::new(),
        Kind::Camera => vec!["inspect=true".to_owned()],
        Kind::Arm => vec![
            "arm={arm=\"nachi-mz07l\"}".to_owned(),
            format!("set_aside={SET_ASIDE}"),
        ],
    }
}

fn bridge(kind: Kind, place_duration_s: f64) -> Vec<String> {
    let mut settings = vec![format!("place_duration_s={place_duration_s:?}")];
    if kind == Kind::Camera {
        settings.extend(CAMERA.map(str::to_owned));
        // The draws begin anew where the bridge is killed: from a seed without an early mishap
        // there would be none.
        let seed: u32 = rand::rng().random();
        settings.push(format!("faults={{{MISHAPS},seed={seed}}}"));
    }
    if kind == Kind::Arm {
        // Without any wait, that is 0.
        let speed = match place_duration_s > 0.0 {
            true => CYCLE_S / place_duration_s,
            false => 0.0,
        };
        settings.push(format!("motion_speed={speed:?}"));
    }
    settings
}

/// Settings of the perception service for cells that are seen exactly.
pub(crate) fn exact_perception(cells: &[(String, Kind)]) -> Vec<(Service, String)> {
    of_perception(vec![served(cells, |kind| kind != Kind::Camera)])
}

/// Settings of another perception service for cells with cameras, as these have noise; `None` where
/// there are none.
pub(crate) fn camera_perception(cells: &[(String, Kind)]) -> Option<Vec<(Service, String)>> {
    let has_cameras = cells.iter().any(|(_, kind)| *kind == Kind::Camera);
    has_cameras.then(|| {
        let cells = served(cells, |kind| kind == Kind::Camera);
        // What is found again in containers.
        let catalogue = format!("catalogue=\"{}\"", ppnpack_household::BUILTIN);
        of_perception(vec![cells, catalogue, MAPPER.to_owned()])
    })
}

fn of_perception(settings: Vec<String>) -> Vec<(Service, String)> {
    let listed = "has_unlisted_cells=false".to_owned();
    let settings = settings.into_iter().chain([listed]);
    settings
        .map(|setting| (Service::Perception, format!("service.{setting}")))
        .collect()
}

fn served(cells: &[(String, Kind)], is_served: impl Fn(Kind) -> bool) -> String {
    let names = cells.iter().filter(|(_, kind)| is_served(*kind));
    let cells = names.map(|(cell, _)| format!("{cell}={{{COARSE}}}"));
    format!("cells={{{}}}", cells.collect::<Vec<_>>().join(","))
}
