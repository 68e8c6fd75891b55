//! Recorded steps as scenes: the arm that carries out what was decided, and that a step without one
//! is drawn as well.

use std::sync::Arc;

use foxglove::messages::{LinePrimitive, SceneEntity};
use nalgebra::{Point2, Point3, Vector3};
use ppnpack_packing::checks::motion::Cycle;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::kernel::item::{Item, ViewSurfaces};
use ppnpack_packing::kernel::placement::{Placement, RestingPlacement};
use ppnpack_packing::ranking::step::{Candidate, StepInput};
use ppnpack_packing::scene::Scene;
use ppnpack_robot::cycle::PickPlace;
use ppnpack_robot::station::{ArmStation, StationSettings};
use ppnpack_service::embedded::{self, Hub};
use ppnpack_view::PlannedScenes;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::{convert, v1};
use serde_json::{Value, json};

/// How far what is drawn may be from where it is, in metres.
const TOLERANCE_M: f64 = 0.002;

/// A block of 6 cells and 20 units, the same at all four yaws: 6 x 6 x 4 cm.
fn block() -> Arc<Item> {
    let middle = Point2::new(0.03, 0.03);
    let view = ViewSurfaces {
        origin_from_corner_m: Vector3::new(middle.x, middle.y, 0.01),
        centre_of_mass_m: Some(middle),
        ..ViewSurfaces::of_cells(6, 6, vec![20; 36], vec![0; 36])
    };
    Arc::new(Item::new("block", vec![view; 4], 0.0).unwrap())
}

fn station() -> StationSettings {
    StationSettings {
        pick: PickPlace {
            position_m: [0.05, -0.30, 0.02],
            yaw_deg: 30.0,
        },
        ..StationSettings::default()
    }
}

/// A cycle that the arm's own planner makes for the block in the empty container, and where the cup
/// lets go.
fn planned() -> (Cycle, Point3<f64>) {
    let grid = Grid::reference();
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let input = StepInput::new(&grid, &scene, &[]);
    let resting = RestingPlacement {
        placement: Placement {
            yaw: 2,
            x: 12,
            y: 9,
        },
        resting_height: 0,
    };
    let station = ArmStation::new(&station()).unwrap();
    let mut check = station.check();
    let candidate = Candidate::new(0, block());
    let release = check.plan(&input, &candidate, &resting).unwrap().release;
    let cycle = check.cycle(&input, &candidate, &resting).unwrap().unwrap();
    let cycle = cycle.sampled(&station.parameters().name, &candidate.lying);
    (cycle, release)
}

/// The record of a step in the empty container of this name.
fn record(settings: &Value, container: &str, cycle: v1::ArmCycle) -> v1::PlanningRecord {
    let grid = Grid::reference();
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    v1::PlanningRecord {
        cell: "cell-1".to_owned(),
        settings: settings.to_string(),
        containers: vec![v1::RecordedContainer {
            container: container.to_owned(),
            scene: Some(convert::scene::write(&grid, &scene)),
            ..v1::RecordedContainer::default()
        }],
        decision: Some(v1::Decision {
            container: container.to_owned(),
            cycle: Some(Box::new(cycle)),
            ..v1::Decision::default()
        }),
        ..v1::PlanningRecord::default()
    }
}

struct Rig {
    scenes: PlannedScenes,
    _hub: Hub,
}

impl Rig {
    fn new() -> Self {
        let hub = embedded::hub().unwrap();
        Self {
            scenes: PlannedScenes::new(&embedded::session(&hub).unwrap()),
            _hub: hub,
        }
    }

    fn drawn(&mut self, record: &v1::PlanningRecord) -> Vec<SceneEntity> {
        let cell = Cell::new("cell-1").unwrap();
        self.scenes.draw(&cell, record).unwrap().entities
    }

    fn ids(&mut self, record: &v1::PlanningRecord) -> Vec<String> {
        let entities = self.drawn(record).into_iter();
        entities.map(|entity| entity.id).collect()
    }
}

fn points(line: &LinePrimitive) -> Vec<Point3<f64>> {
    let points = line.points.iter();
    points.map(|at| Point3::new(at.x, at.y, at.z)).collect()
}

fn is_near(at: &Point3<f64>, expected: &Point3<f64>) -> bool {
    (at - expected).norm() < TOLERANCE_M
}

#[test]
fn the_arm_is_drawn_as_it_lets_go_and_its_way_over_the_cycle() {
    let mut rig = Rig::new();
    let (cycle, release) = planned();
    assert!((release.z - 0.04).abs() < TOLERANCE_M, "the block's top");
    let settings = json!({"cell_m": 0.01, "arm": station()});
    let entities = rig.drawn(&record(&settings, "", convert::cycle::write(&cycle)));
    let ids: Vec<&str> = entities.iter().map(|entity| entity.id.as_str()).collect();
    assert_eq!(ids, ["container", "arm", "trajectory"]);

    let links = points(&entities[1].lines[0]);
    let base_m = station().parameters().unwrap().base.position_m;
    assert_eq!(links.len(), 8, "base, six links, tip");
    assert!(is_near(&links[0], &Point3::from(base_m)), "{links:?}");
    assert!(is_near(&links[7], &release), "{links:?}");
    // The cup hangs down from the flange.
    assert!((links[7] - links[6]).xy().norm() < TOLERANCE_M && links[6].z > release.z);

    let legs: Vec<_> = entities[2].lines.iter().map(points).collect();
    assert_eq!(legs.len(), cycle.legs.len());
    for (leg, next) in legs.iter().zip(legs.iter().cycle().skip(1)) {
        assert!(is_near(&leg[leg.len() - 1], &next[0]), "legs join");
    }
    let ends = |leg: usize| legs[leg][legs[leg].len() - 1];
    let picked = Point3::new(0.05, -0.30, 0.02 + 0.04);
    assert!(is_near(&ends(0), &picked), "{}", ends(0));
    assert!(is_near(&ends(3), &release), "{}", ends(3));
    assert!(
        is_near(&ends(5), &legs[0][0]),
        "it ends where it begins: {}",
        ends(5)
    );
    let text = format!("cycle {:.1} s", cycle.cycle_s);
    assert_eq!(entities[2].texts[0].text, text);
}

#[test]
fn the_arm_is_drawn_as_it_stands_to_the_container_that_was_chosen() {
    let mut rig = Rig::new();
    let (cycle, release) = planned();
    let mut base = station().parameters().unwrap().base;
    base.position_m[0] -= 0.05;
    let moved = StationSettings {
        base: Some(base),
        ..station()
    };
    let settings = json!({"arm": station(), "containers": {"left": {"arm": moved}, "right": {}}});
    for (container, offset_m) in [("left", -0.05), ("right", 0.0)] {
        let record = record(&settings, container, convert::cycle::write(&cycle));
        let entities = rig.drawn(&record);
        let links = points(&entities[1].lines[0]);
        let expected = release + Vector3::new(offset_m, 0.0, 0.0);
        assert!(is_near(&links[7], &expected), "{container}: {links:?}");
    }
}

#[test]
fn a_step_whose_arm_is_not_known_is_drawn_without_it() {
    let mut rig = Rig::new();
    let (cycle, _) = planned();
    let written = convert::cycle::write(&cycle);
    for settings in [
        json!({}),
        json!("no table"),
        json!({"arm": {"arm": "r2d2"}}),
        json!({"arm": {"arm": "no/such/arm.toml"}}),
        json!({"arm": {"arm": "."}}),
        json!({"arm": {"reach_m": 1.0}}),
        json!({"arm": {"arm": "abb-irb1200-5-90"}}),
    ] {
        let record = record(&settings, "", written.clone());
        for _ in 0..2 {
            assert_eq!(rig.ids(&record), ["container"], "{settings}");
        }
    }
    let known = json!({"arm": {}});
    let mut broken = written.clone();
    broken.legs[0]
        .trajectory
        .as_mut()
        .unwrap()
        .position_rad
        .pop();
    let broken = record(&known, "", broken);
    assert_eq!(rig.ids(&broken), ["container"]);
    let mut without_insert = written;
    without_insert.legs.truncate(2);
    let without_insert = record(&known, "", without_insert);
    assert_eq!(rig.ids(&without_insert), ["container", "trajectory"]);
}
