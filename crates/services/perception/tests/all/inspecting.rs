//! How a placed item lies, over a real session: clouds of the container in, what became of the item
//! out.

use std::sync::mpsc::channel;
use std::time::Duration;

use nalgebra::{Isometry3, Point3, Vector3};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::heightmap::Surface;
use ppnpack_packing::scene::Scene;
use ppnpack_perception_service::Objects;
use ppnpack_recognition::library::Library;
use ppnpack_wire::convert::{pose, scene};
use ppnpack_wire::keys::Stream;
use ppnpack_wire::v1::{self, InspectionKind, Status};

use crate::rig::{PATIENCE, Rig, at_state, cell, known, library, refusal, seen_from};

/// The empty reference container: its floor and its walls.
fn container() -> Vec<Mesh> {
    let (side, rim, wall) = (0.32, 0.30, 0.01);
    vec![
        Mesh::cuboid([-wall, -wall, -0.02], [side + wall, side + wall, 0.0]),
        Mesh::cuboid([-wall, -wall, 0.0], [0.0, side + wall, rim]),
        Mesh::cuboid([side, -wall, 0.0], [side + wall, side + wall, rim]),
        Mesh::cuboid([0.0, -wall, 0.0], [side, 0.0, rim]),
        Mesh::cuboid([0.0, side, 0.0], [side, side + wall, rim]),
    ]
}

/// What a camera above the container sees in a state of the cell.
fn cloud_of(item: Option<&Isometry3<f64>>, state_number: u64) -> v1::PointCloud {
    let walls = container().into_iter();
    let mut meshes: Vec<_> = walls.map(|mesh| (mesh, Isometry3::identity())).collect();
    meshes.extend(item.map(|pose| (known(), *pose)));
    let eye_m = Point3::new(0.16, 0.16, 1.1);
    seen_from(eye_m, 900.0, &meshes, [0, state_number])
}

/// Asks for the slab in a container that was empty before.
fn request(planned: &Isometry3<f64>, least_state_number: u64) -> v1::InspectRequest {
    let grid = Grid::reference();
    let empty = Scene::from_surface(&grid, Surface::empty(&grid)).unwrap();
    v1::InspectRequest {
        header: None,
        object: "slab".to_owned(),
        planned: Some(pose::write(planned)),
        before: Some(scene::write(&grid, &empty)),
        least_state_number,
    }
}

fn lying(x_m: f64, y_m: f64, yaw_rad: f64) -> Isometry3<f64> {
    Isometry3::new(Vector3::new(x_m, y_m, 0.015), Vector3::z() * yaw_rad)
}

#[test]
fn an_item_is_found_as_planned_moved_or_missing() {
    let rig = Rig::new(Stream::Cloud);
    let planned = lying(0.12, 0.15, 0.0);
    let inspected = |item: Option<&Isometry3<f64>>, state_number| {
        let request = request(&planned, state_number);
        let reply = rig.show(cloud_of(item, state_number), &request);
        assert!(reply.state_number >= state_number);
        reply.inspection.unwrap()
    };
    let as_planned = inspected(Some(&lying(0.121, 0.15, 0.01)), 5);
    let kind = as_planned.kind();
    assert_eq!(kind, InspectionKind::AsPlanned, "{as_planned:?}");
    assert!(as_planned.is_inside && as_planned.fitness > 0.8);

    let truth = lying(0.16, 0.18, 0.4);
    let moved = inspected(Some(&truth), 6);
    assert_eq!(moved.kind(), InspectionKind::Moved, "{moved:?}");
    let found = pose::read_required("pose", moved.container_from_item.as_ref()).unwrap();
    let off_m = (found.translation.vector - truth.translation.vector).norm();
    assert!(off_m < 0.005, "{off_m}");
    assert!((moved.slide_m - 0.05).abs() < 0.005, "{}", moved.slide_m);

    // That is not the catalogue's fault: others can be found.
    let stranger = v1::InspectRequest {
        object: "stranger".to_owned(),
        ..request(&planned, 6)
    };
    let unknown = rig.ask(&cell(), stranger, PATIENCE).unwrap();
    let unknown = unknown.inspection.unwrap();
    assert_eq!(unknown.kind(), InspectionKind::Unclear);
    assert!(unknown.reason.contains("no object 'stranger'"));

    let missing = inspected(None, 7);
    assert_eq!(missing.kind(), InspectionKind::Missing, "{missing:?}");
    assert!(missing.reason.contains("not seen in the container"));
}

#[test]
fn what_cannot_be_inspected_is_refused_with_the_reason() {
    let rig = Rig::new(Stream::Cloud);
    let planned = lying(0.12, 0.15, 0.0);
    let short = Duration::from_millis(300);
    let (status, message) = rig.refused(&cell(), &request(&planned, 1), short);
    assert_eq!(status, Status::TimedOut);
    assert!(message.contains("no cloud"), "{message}");

    rig.show(cloud_of(None, 2), &request(&planned, 2));
    let nowhere = v1::InspectRequest {
        planned: None,
        ..request(&planned, 2)
    };
    let (status, message) = refusal(rig.ask(&cell(), nowhere, PATIENCE));
    assert_eq!(status, Status::Invalid);
    assert!(message.contains("planned"), "{message}");
}

/// To prepare objects takes seconds, and nothing is packed without heightmaps.
#[test]
fn heightmaps_do_not_wait_for_the_objects_that_are_recognised() {
    let (prepared, prepare) = channel::<()>();
    let rig = Rig::recognising(Stream::Cloud, |process| {
        let objects = Objects::preparing(process, move || {
            prepare.recv().map_err(|error| error.to_string())?;
            Ok::<Library, String>(Library::clone(&library()))
        });
        objects.unwrap()
    });
    rig.show(cloud_of(None, 3), &at_state(3));
    let planned = lying(0.12, 0.15, 0.0);
    let short = Duration::from_millis(300);
    let (status, message) = rig.refused(&cell(), &request(&planned, 3), short);
    assert_eq!(status, Status::TimedOut);
    assert!(message.contains("being prepared"), "{message}");
    let items = rig.ask(&cell(), v1::ItemsRequest::default(), PATIENCE);
    let (status, message) = refusal(items);
    assert_eq!(status, Status::Unavailable, "{message}");

    prepared.send(()).unwrap();
    rig.show(cloud_of(None, 4), &request(&planned, 4));
}
