//! Perception's heightmap of the bridge's clouds is that of a direct scan, bit for bit.

use crate::common::catalogue;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use ppnpack_bridge::robot::{Body, Placement, Robot};
use ppnpack_bridge::simulated::{Scan, SimulatedRobot, SimulatedSettings};
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_packing::kernel::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::scene::Scene;
use ppnpack_perception::mapper::{Mapped, Mapper};
use ppnpack_perception::settings::MapperSettings;
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::view::{CameraSettings, NoiseModel};
use ppnpack_service::Shutdown;
use ppnpack_wire::convert::cloud::{self, Capture};
use ppnpack_wire::{MAX_CLOUD_BYTES, v1};
use prost::Message;

const ITEMS: [(&str, f64, f64, f64); 5] = [
    ("brick", 0.10, 0.10, 0.3),
    ("cube", 0.20, 0.08, 1.1),
    ("brick", 0.12, 0.20, 2.2),
    ("cube", 0.11, 0.11, 0.7),
    ("brick", 0.15, 0.12, 0.0),
];

fn filled(settings: &SimulatedSettings, catalogue: &Catalogue) -> SimulatedRobot {
    let mut robot = SimulatedRobot::new(settings.clone(), catalogue).unwrap();
    for (index, (object, x_m, y_m, yaw_rad)) in ITEMS.into_iter().enumerate() {
        let placement = Placement {
            placement_id: index.to_string(),
            item_id: format!("item-{index}"),
            object: object.to_owned(),
            container_from_item: Isometry3::from_parts(
                Translation3::new(x_m, y_m, 0.03 + 0.03 * index as f64),
                UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad),
            ),
            state_number: 1,
            cycle: None,
        };
        robot.place(&placement, &Shutdown::default()).unwrap();
    }
    robot
}

/// A cell with the same bodies, seen without a robot.
fn direct(settings: &SimulatedSettings, catalogue: &Catalogue, bodies: &[Body]) -> SimulatedCell {
    let mut cell = SimulatedCell::new(settings.physics.clone()).unwrap();
    let poses = bodies.iter().map(|body| {
        let (_, object) = catalogue.find(&body.object).unwrap();
        (object.model.clone(), *body.container_from_item.isometry())
    });
    cell.lay_down(&poses.collect::<Vec<_>>()).unwrap();
    cell
}

/// Sends a view over the wire and maps it.
fn perceived(robot: &mut SimulatedRobot, grid: &Grid) -> Mapped {
    let view = robot.capture().unwrap().remove(0);
    let capture = Capture {
        sequence: 1,
        captured_at_ns: 0,
        state_number: 1,
        container_from_sensor: view.container_from_sensor,
    };
    let payload = cloud::write(&capture, &view.points_m).encode_to_vec();
    let message: v1::PointCloud = ppnpack_wire::decode(&payload, MAX_CLOUD_BYTES).unwrap();
    let cloud = cloud::read(&message).unwrap();
    let mut mapper = Mapper::new(grid, MapperSettings::default()).unwrap();
    mapper
        .map(cloud.points(), cloud.container_from_sensor())
        .unwrap()
}

fn grid(container: ContainerSize, cell_m: f64, unit_m: f64) -> Grid {
    let resolution = Resolution::new(cell_m, unit_m, Yaws::half_turn(4).unwrap()).unwrap();
    Grid::new(container, resolution).unwrap()
}

#[test]
fn an_exact_scan_gives_the_heightmap_and_the_surface_of_the_cell() {
    let catalogue = catalogue();
    let reference = ContainerSize::REFERENCE;
    // No multiple of the cell along x, and none of the unit in height.
    let uneven = ContainerSize::cuboid(0.327, 0.29, 0.3013);
    for (container, cell_m, unit_m, pitch_m) in [
        (reference, 0.01, 0.002, 0.0025),
        (reference, 0.005, 0.002, 0.0025),
        (reference, 0.0025, 0.001, 0.0025),
        (reference, 0.02, 0.005, 0.0025),
        (uneven, 0.01, 0.002, 0.0025),
        (reference, 0.003, 0.0013, 0.0015),
    ] {
        let mut settings = SimulatedSettings {
            scan_pitch_m: pitch_m,
            ..SimulatedSettings::default()
        };
        settings.physics.container = container;
        let mut robot = filled(&settings, &catalogue);
        assert_eq!(robot.bodies().len(), ITEMS.len());
        let grid = grid(container, cell_m, unit_m);
        let mapped = perceived(&mut robot, &grid);
        assert_eq!(mapped.unknown_cells, 0);
        let expected = direct(&settings, &catalogue, &robot.bodies())
            .scan(&grid)
            .unwrap();
        assert!(mapped.scene == expected, "cells of {cell_m} m");
        assert!(expected.heightmap().max() > 0);
    }
}

#[test]
fn a_robot_that_goes_on_sees_what_the_one_before_saw() {
    let catalogue = catalogue();
    let settings = SimulatedSettings::default();
    let mut before = filled(&settings, &catalogue);
    let mut after = SimulatedRobot::new(settings, &catalogue).unwrap();
    assert_eq!(after.take_over(before.bodies()), before.bodies());
    assert_eq!(after.capture().unwrap(), before.capture().unwrap());

    let mut unknown = before.bodies();
    unknown[2].object = "anvil".to_owned();
    let left = after.take_over(unknown);
    assert_eq!(left.len(), ITEMS.len() - 1);
    assert_eq!(left[2].item_id, "item-3");
}

#[test]
fn a_camera_sees_the_content_within_its_pixels() {
    let catalogue = catalogue();
    let settings = SimulatedSettings {
        scan: Scan::Camera,
        camera: CameraSettings {
            height_m: 1.2,
            width_px: 300,
            height_px: 300,
            noise: NoiseModel::none(),
            ..CameraSettings::default()
        },
        ..SimulatedSettings::default()
    };
    let mut robot = filled(&settings, &catalogue);
    let grid = Grid::reference();
    let mapped = perceived(&mut robot, &grid);
    let exact = direct(&settings, &catalogue, &robot.bodies())
        .scan(&grid)
        .unwrap();
    let differs = |scene: &Scene| {
        let cells = scene.heightmap().heights().iter();
        let cells = cells.zip(exact.heightmap().heights());
        let differing = cells.filter(|(seen, exact)| seen.abs_diff(**exact) > 1);
        differing.count()
    };
    // The walls of items hide what lies behind them from a camera that is not above it.
    let (differing, unknown) = (differs(&mapped.scene), mapped.unknown_cells);
    assert!(differing < 60, "{differing} cells differ");
    assert!(unknown < 10, "{unknown} cells are unknown");
}
