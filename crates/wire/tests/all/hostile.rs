//! Every value that is not possible is refused with an error that names its field.

use std::time::Duration;

use ppnpack_packing::checks::motion::JOINTS;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::heightmap::Surface;
use ppnpack_packing::scene::Scene;
use ppnpack_wire::convert::{
    check, cloud, cycle, grid, item, objective, placement, pose, scene, solid,
};
use ppnpack_wire::header::{self, RequestHeader};
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::keys::{Cell, Instance};
use ppnpack_wire::{WireError, v1};

use crate::support::{domain, refused};

fn scene_message() -> v1::Scene {
    let grid = Grid::reference();
    let scene = Scene::from_surface(&grid, Surface::empty(&grid)).unwrap();
    scene::write(&grid, &scene)
}

fn surface(scene: &mut v1::Scene) -> &mut v1::Surface {
    scene.surface.as_mut().unwrap()
}

fn underside(item: &mut v1::Item) -> &mut v1::Underside {
    item.views[1].underside.as_mut().unwrap()
}

fn set_first(heights_m: &mut [u8], height_m: f32) {
    heights_m[..4].copy_from_slice(&height_m.to_le_bytes());
}

fn view_message() -> v1::ItemView {
    v1::ItemView {
        nx: 1,
        ny: 2,
        top: vec![3, 0, 0, 0],
        bottom: vec![0, 0, 0xff, 0xff],
        underside: Some(v1::Underside {
            samples_per_cell: 1,
            heights_m: [0.0_f32, f32::INFINITY]
                .iter()
                .flat_map(|height| height.to_le_bytes())
                .collect(),
        }),
        origin_from_corner: Some(v1::Vector3::default()),
        centre_of_mass: Some(v1::Vector3::default()),
    }
}

fn pose_message() -> v1::Pose {
    pose::write(&nalgebra::Isometry3::identity())
}

#[test]
fn grids() {
    refused! {
        &grid::write(&Grid::reference()), grid::read, it;
        "grid.container" => it.container = None;
        "grid.container.x_m" => it.container.as_mut().unwrap().x_m = -0.3;
        "grid.container.y_m" => it.container.as_mut().unwrap().y_m = f64::NAN;
        "grid.container.z_m" => it.container.as_mut().unwrap().z_m = 1000.1;
        "grid.cell_m" => it.cell_m = 0.0;
        "grid.cell_m" => it.cell_m = f64::INFINITY;
        "grid.cell_m" => it.cell_m = 1e-9;
        "grid.cell_m" => it.cell_m = f64::MIN_POSITIVE;
        "grid.cell_m" => it.cell_m = 1.0;
        "grid.height_unit_m" => it.height_unit_m = -1.0;
        "grid.height_unit_m" => it.height_unit_m = 1e-6;
        "grid.height_unit_m" => it.height_unit_m = 1.0;
        "grid.yaws_rad" => it.yaws_rad.clear();
        "grid.yaws_rad" => it.yaws_rad[0] = f64::NAN;
        "grid.yaws_rad" => it.yaws_rad = vec![0.0; 361];
    }
}

#[test]
fn scenes() {
    refused! {
        &scene_message(), scene::read, it;
        "scene.grid" => it.grid = None;
        "grid.cell_m" => it.grid.as_mut().unwrap().cell_m = 0.0;
        "scene.heights" => it.heights.clear();
        "scene.heights" => it.heights.push(0);
        "scene.heights" => it.heights[1] = 0xff;
        "scene.heights" => it.heights[1] = 0x20;
        "scene.surface.samples_per_cell" => surface(it).samples_per_cell = 5;
        "scene.surface.samples_per_cell" => surface(it).samples_per_cell = u32::MAX;
        "scene.surface.heights_m" => surface(it).heights_m.pop();
        "scene.surface.heights_m" => set_first(&mut surface(it).heights_m, f32::NAN);
        "scene.surface.heights_m" => set_first(&mut surface(it).heights_m, -0.1);
    }
}

#[test]
fn scenes_of_cells_as_large_as_possible() {
    // 400,000 samples along a cell: the size is refused before memory is taken for it.
    let mut message = scene_message();
    let grid = message.grid.as_mut().unwrap();
    let side = 1000.0;
    grid.container = Some(v1::BoxSize {
        x_m: side,
        y_m: side,
        z_m: 0.3,
    });
    grid.cell_m = side;
    message.heights = vec![0; 2];
    message.surface.as_mut().unwrap().samples_per_cell = 400_000;
    refused! {
        &v1::Scene { surface: None, ..message.clone() }, scene::read, it;
        "scene.surface.samples_per_cell" => it.surface = Some(v1::Surface::default());
    }
    assert!(matches!(
        scene::read(&message),
        Err(WireError::Invalid {
            field: "scene.surface.heights_m",
            ..
        })
    ));
}

#[test]
fn items() {
    let valid = v1::Item {
        name: "ell".to_owned(),
        views: vec![view_message(); 2],
        mesh_volume_m3: 1e-4,
    };
    refused! {
        &valid, item::read, it;
        "item.name" => it.name.clear();
        "item.name" => it.name = "a".repeat(257);
        "item.views" => it.views.clear();
        "item.views" => it.views = vec![view_message(); 361];
        "item.views.nx" => it.views[1].nx = 0;
        "item.views.nx" => it.views[1].nx = 2049;
        "item.views.ny" => it.views[1].ny = 0;
        "item.views.ny" => it.views[1].ny = u32::MAX;
        "item.views.top" => it.views[1].top.truncate(3);
        "item.views.top" => it.views[1].nx = 2;
        "item.views.bottom" => it.views[1].bottom.clear();
        // Out of order, below nothing, above the greatest height, and with no material.
        "item.views" => it.views[1].top[0] = 0;
        "item.views" => it.views[1].bottom[..2].copy_from_slice(&[0xfe, 0xff]);
        "item.views" => it.views[1].top[1] = 0x20;
        "item.views" => it.views[1].bottom[..2].copy_from_slice(&[0xff, 0xff]);
        "item.views.underside.heights_m" => underside(it).heights_m.clear();
        "item.views.underside.heights_m" => underside(it).samples_per_cell = u32::MAX;
        "item.views.underside.heights_m" => it.views[1].underside = Some(v1::Underside::default());
        "item.views.underside.heights_m" =>
            set_first(&mut underside(it).heights_m, f32::NEG_INFINITY);
        "item.views.underside.heights_m" => set_first(&mut underside(it).heights_m, f32::NAN);
        "item.views.origin_from_corner" => it.views[1].origin_from_corner = None;
        "item.views.origin_from_corner" => it.views[1].origin_from_corner = Some(v1::Vector3 {
            y_m: f64::NEG_INFINITY,
            ..v1::Vector3::default()
        });
        "item.views.centre_of_mass" => it.views[1].centre_of_mass.as_mut().unwrap().x_m = 1.1e6;
        "item.mesh_volume_m3" => it.mesh_volume_m3 = -1.0;
        "item.mesh_volume_m3" => it.mesh_volume_m3 = f64::INFINITY;
    }
}

#[test]
fn placements() {
    let valid = v1::Placements {
        yaw: vec![0, 1],
        x: vec![2, 3],
        y: vec![4, 5],
    };
    refused! {
        &valid, |placements| placement::read_all("parts.proposals", placements), it;
        "parts.proposals" => it.x.push(0);
        "parts.proposals" => it.y.clear();
        "parts.proposals" => it.yaw[1] = 360;
        "parts.proposals" => it.x[1] = 2048;
        "parts.proposals" => it.y[1] = u32::MAX;
        "parts.proposals" => it.yaw = vec![0; (1 << 22) + 1];
    }
    let resting = v1::RestingPlacement {
        yaw: 359,
        x: 2047,
        y: 2047,
        resting_height: 8191,
    };
    refused! {
        &resting, placement::read_resting, it;
        "placement" => it.yaw = 360;
        "placement.resting_height" => it.resting_height = 8192;
        "placement.resting_height" => it.resting_height = u32::MAX;
    }
    let ranked = v1::RankedPlacement {
        candidate: 999,
        placement: Some(resting),
        value: -1.5,
        pose: 0,
    };
    refused! {
        &ranked, placement::read_ranked, it;
        "ranked_placement.candidate" => it.candidate = 1000;
        "ranked_placement.placement" => it.placement = None;
        "placement" => it.placement.as_mut().unwrap().x = 2048;
        "ranked_placement.value" => it.value = f64::NAN;
        "ranked_placement.value" => it.value = f64::INFINITY;
    }
    let counts = v1::PlacementCounts {
        refusals: vec![v1::Refusals {
            check: v1::Check::Fits.into(),
            count: 1,
            detail: String::new(),
        }],
        ..Default::default()
    };
    refused! {
        &counts, placement::read_tally, it;
        "placement_counts.candidate" => it.candidate = 1000;
        "placement_counts.refusals.check" => it.refusals[0].check = 0;
        "placement_counts.refusals.check" => it.refusals[0].check = 99;
    }
}

#[test]
fn what_is_not_there_is_named() {
    let named = [
        objective::read_required("objective", None).err(),
        pose::read_required("pose", None).err(),
        RequestHeader::read(None).err(),
    ];
    let named = named.map(|error| error.unwrap().to_string());
    let fields = ["objective", "pose", "header"].map(|field| format!("{field} is missing"));
    assert_eq!(named, fields);
}

#[test]
fn checks() {
    refused! {
        &vec![1, 3], |checks: &Vec<i32>| check::read_all(checks), it;
        "checks" => it.push(0);
        "checks" => it.push(-7);
        "checks" => it.push(3);
    }
}

#[test]
fn objectives() {
    let valid = v1::Objective {
        heuristic: v1::Heuristic::Sdfm.into(),
        weights: Some(v1::Weights::default()),
        ..Default::default()
    };
    refused! {
        &valid, |message| objective::read_required("objective", Some(message)), it;
        "objective.heuristic" => it.heuristic = 0;
        "objective.heuristic" => it.heuristic = 7;
        "objective.weights" => it.weights.as_mut().unwrap().distance = -1.0;
        "objective.weights" => it.weights.as_mut().unwrap().touching_area = f64::NAN;
    }
}

#[test]
fn cycles() {
    fn trajectory(cycle: &mut v1::ArmCycle) -> &mut v1::Trajectory {
        cycle.legs[0].trajectory.as_mut().unwrap()
    }
    refused! {
        &cycle::write(&domain::cycle()), cycle::read, it;
        "cycle.arm" => it.arm.clear();
        "cycle.cycle_s" => it.cycle_s = f64::NAN;
        "cycle.cycle_s" => it.cycle_s = -1.0;
        "cycle.container_from_item_at_pick" => it.container_from_item_at_pick = None;
        "cycle.grasp_yaw_rad" => it.grasp_yaw_rad = 13.0;
        "cycle.grip_s" => it.grip_s = 61.0;
        "cycle.release_s" => it.release_s = f64::INFINITY;
        "cycle.legs" => it.legs.clear();
        "cycle.legs" => it.legs = vec![it.legs[0].clone(); 17];
        "cycle.legs.kind" => it.legs[0].kind = 99;
        "cycle.legs.trajectory" => it.legs[1].trajectory = None;
        "trajectory.position_rad" => trajectory(it).position_rad.pop();
        "trajectory.position_rad" => trajectory(it).position_rad[7] = f64::NAN;
        "trajectory.time_s" => *trajectory(it) = v1::Trajectory {
            time_s: (0..2_001).map(f64::from).collect(),
            position_rad: vec![0.0; 2_001 * JOINTS],
        };
        // Times begin at zero and increase.
        "trajectory.time_s" => trajectory(it).time_s = vec![0.001, 0.01, 0.02];
        "trajectory.time_s" => trajectory(it).time_s = vec![0.0, 0.01, 0.01];
        "trajectory.time_s" => trajectory(it).time_s = vec![0.0, 0.02, 0.01];
        "trajectory.time_s" => trajectory(it).time_s = vec![0.0, f64::NAN, 0.01];
        "trajectory.time_s" => trajectory(it).time_s = vec![0.0, 0.01, 1e6];
    }
}

#[test]
fn poses() {
    refused! {
        &pose_message(), |message| pose::read_required("container_from_item", Some(message)), it;
        "container_from_item" => it.position = None;
        "container_from_item" => it.orientation = None;
        "container_from_item" => it.position.as_mut().unwrap().z_m = f64::NAN;
        "container_from_item" => it.orientation.as_mut().unwrap().w = 1.002;
        "container_from_item" => it.orientation = Some(v1::Quaternion::default());
        "container_from_item" => it.orientation.as_mut().unwrap().x = f64::NAN;
        "container_from_item" => it.orientation.as_mut().unwrap().x = f64::MAX;
    }
}

#[test]
fn clouds() {
    let capture = cloud::Capture {
        sequence: 1,
        captured_at_ns: 0,
        state_number: 0,
        container_from_sensor: nalgebra::Isometry3::identity(),
    };
    refused! {
        &cloud::write(&capture, &[nalgebra::Point3::origin(); 3]),
        |message| cloud::read(message).map(|cloud| cloud.len()), it;
        "cloud.sequence" => it.sequence = 0;
        "cloud.container_from_sensor" => it.container_from_sensor = None;
        "cloud.point_stride" => it.point_stride = 0;
        "cloud.point_stride" => it.point_stride = 1025;
        "cloud.fields.offset" => it.point_stride = 11;
        "cloud.data" => it.point_stride = 13;
        "cloud.data" => it.data.truncate(35);
        "cloud.fields" => it.fields.clear();
        "cloud.fields" => it.fields[1].name = "x".to_owned();
        "cloud.fields" => it.fields = vec![it.fields[0].clone(); 33];
        "cloud.fields.offset" => it.fields[2].offset = 9;
        "cloud.fields.offset" => it.fields[2].offset = u32::MAX;
        "cloud.fields.type" => it.fields[0].r#type = 0;
        "cloud.fields.type" => it.fields[0].r#type = 9;
        "cloud.fields.type" => it.fields[0].r#type = v1::NumericType::Int32.into();
    }
}

#[test]
fn headers() {
    let valid = RequestHeader {
        request_id: "a-Z_0.9:".to_owned(),
        time_limit: Duration::from_secs(600),
        caller: Some(Instance::new("planner-1").unwrap()),
        session_id: Some("monday-1".to_owned()),
        cell: Some(Cell::new("cell-1").unwrap()),
    };
    let nobody = RequestHeader {
        caller: None,
        session_id: None,
        cell: None,
        ..valid.clone()
    };
    for header in [&valid, &nobody] {
        assert_eq!(
            &RequestHeader::read(Some(&header.to_message())).unwrap(),
            header
        );
    }
    refused! {
        &valid.to_message(), |header| RequestHeader::read(Some(header)), it;
        "header.session_id" => it.session_id = "no name".to_owned();
        "header.request_id" => it.request_id.clear();
        "header.request_id" => it.request_id = "a".repeat(65);
        "header.request_id" => it.request_id = "a b".to_owned();
        "header.caller" => it.caller = "a/b".to_owned();
        "header.time_limit_us" => it.time_limit_us = 0;
        "header.time_limit_us" => it.time_limit_us = 600_000_001;
    }
}

#[test]
fn long_texts_are_cut_between_characters() {
    assert_eq!(header::text("short"), "short");
    let cut = header::text(&"ä".repeat(3000));
    assert_eq!(cut, "ä".repeat(2048));
    let cut = header::text(&format!("a{}", "ä".repeat(3000)));
    assert_eq!(cut.len(), 4095);
}

#[test]
fn solids() {
    let good = v1::Solid {
        name: "solid".to_owned(),
        vertices_m: vec![0.0; 9],
        triangles: vec![0, 1, 2],
        pieces: vec![v1::ConvexPiece {
            vertices_m: vec![0.0; 12],
        }],
        centre_of_mass: Some(v1::Vector3::default()),
        inertia_kg_m2: vec![1.0; 9],
        ..v1::Solid::default()
    };
    refused! {
        &good, solid::read, it;
        "solid.name" => it.name.clear();
        "solid.vertices_m" => it.vertices_m.truncate(8);
        "solid.vertices_m" => it.vertices_m[3] = f64::NAN;
        "solid.vertices_m" => it.vertices_m[3] = 1e300;
        "solid.triangles" => it.triangles.truncate(2);
        "solid.triangles" => it.triangles[2] = 3;
        "solid.pieces.vertices_m" => it.pieces[0].vertices_m.truncate(11);
        "solid.centre_of_mass" => it.centre_of_mass = None;
        "solid.inertia_kg_m2" => it.inertia_kg_m2.truncate(8);
        "solid.inertia_kg_m2" => it.inertia_kg_m2[0] = f64::INFINITY;
        "solid.mass_kg" => it.mass_kg = -1.0;
        "solid.carries_kg" => it.carries_kg = Some(f64::NAN);
    }
}

#[test]
fn ids_of_items_have_32_bytes() {
    let id = ItemId::of(&v1::Item::default());
    assert_eq!(ItemId::from_bytes("item_id", &id.to_bytes()), Ok(id));
    assert_eq!(id.to_string().len(), 16);
    for bytes in [&[][..], &[0; 31], &[0; 33]] {
        assert!(matches!(
            ItemId::from_bytes("item_id", bytes),
            Err(WireError::Invalid {
                field: "item_id",
                ..
            })
        ));
    }
}
