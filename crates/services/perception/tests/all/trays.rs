//! What lies on trays, over a real session: a simulated camera above a tray in, items to be
//! announced out.

use std::time::Duration;

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_perception_service::{Fate, Settings, TraySettings};
use ppnpack_service::ServiceSettings;
use ppnpack_service::embedded::{self};
use ppnpack_wire::convert::{item, pose};
use ppnpack_wire::keys::{Cell, Service, Stream};
use ppnpack_wire::v1::{self, Status, UnknownReason};

use crate::rig::{PATIENCE, Rig, TRAY_M, brick, cell, known, refusal, seen_from, settings};

/// What a camera 90 cm above the tray sees of meshes at these poses.
fn cloud_of(items: &[(Mesh, Isometry3<f64>)], sequence: u64) -> v1::PointCloud {
    let tray = (
        brick(0.6, 0.5, 0.02),
        on_tray(0.0, 0.0, -0.01, UnitQuaternion::identity()),
    );
    let meshes = [&[tray], items].concat();
    let eye_m = Point3::from(TRAY_M + Vector3::z() * 0.9);
    seen_from(eye_m, 600.0, &meshes, [sequence, 0])
}

fn at_least(least_sequence: u64) -> v1::ItemsRequest {
    v1::ItemsRequest {
        header: None,
        least_sequence,
    }
}

fn on_tray(x_m: f64, y_m: f64, half_height_m: f64, turn: UnitQuaternion<f64>) -> Isometry3<f64> {
    Isometry3::from_parts(
        (TRAY_M + Vector3::new(x_m, y_m, half_height_m)).into(),
        turn,
    )
}

#[test]
fn known_and_unknown_items_are_told_with_what_an_announcement_needs() {
    let rig = Rig::new(Stream::TrayCloud);
    let about = |axis, rad| UnitQuaternion::from_axis_angle(&axis, rad);
    // The slab stands on its long edge, 6 cm high.
    let on_edge =
        about(Vector3::z_axis(), 0.5) * about(Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
    let slab = (known(), on_tray(-0.08, 0.03, 0.03, on_edge));
    let stranger = brick(0.10, 0.08, 0.02);
    let turned = about(Vector3::z_axis(), 0.3);
    let stranger = (stranger, on_tray(0.1, -0.02, 0.01, turned));
    let reply = rig.show(cloud_of(&[slab.clone(), stranger], 6), &at_least(7));
    assert_eq!(reply.items.len(), 2);
    assert!(reply.cloud_sequence >= 7);

    let seen = reply.items.iter().find(|item| item.object == "slab");
    let seen = seen.expect("the slab is known");
    assert!(seen.fitness > 0.8, "{}", seen.fitness);
    let found = pose::read_required("pose", seen.container_from_item.as_ref()).unwrap();
    let off_m = (found.translation.vector - slab.1.translation.vector).norm();
    assert!(off_m < 0.003, "{off_m}");
    let heightmaps = item::read(seen.item.as_ref().unwrap()).unwrap();
    let view = &heightmaps.views()[0];
    let sides = (view.nx().min(view.ny()), view.nx().max(view.ny()));
    assert_eq!((sides, view.height()), ((3, 12), 30));
    // The frame of the heightmaps stands upright where the item waits.
    let frame = pose::read_required("frame", seen.heightmap_from_item.as_ref()).unwrap();
    let up = found * frame.inverse() * Vector3::z();
    assert!(up.z > 0.999, "{up}");

    let unknown = reply.items.iter().find(|item| item.object.is_empty());
    let unknown = unknown.expect("the other one is not known");
    assert_ne!(unknown.unknown_reason(), UnknownReason::Unspecified);
    let heightmaps = item::read(unknown.item.as_ref().unwrap()).unwrap();
    let name = heightmaps.name();
    assert!(name.starts_with("unknown"), "{name}");
    let view = &heightmaps.views()[0];
    let sides = (view.nx().min(view.ny()), view.nx().max(view.ny()));
    assert!(
        sides.0.abs_diff(8) <= 1 && sides.1.abs_diff(10) <= 1,
        "{sides:?}"
    );
    assert!(view.height().abs_diff(10) <= 2, "{}", view.height());
}

#[test]
fn an_empty_tray_has_no_items() {
    let reply = Rig::new(Stream::TrayCloud).show(cloud_of(&[], 0), &at_least(1));
    assert_eq!(reply.items.len(), 0);
}

#[test]
fn who_asks_for_what_does_not_come_is_told() {
    let rig = Rig::new(Stream::TrayCloud);
    let short = Duration::from_millis(300);
    let (refused, message) = rig.refused(&cell(), &at_least(0), short);
    assert_eq!(refused, Status::TimedOut);
    assert!(message.contains("no cloud of the tray"), "{message}");

    rig.show(cloud_of(&[], 3), &at_least(4));
    let (refused, message) = rig.refused(&cell(), &at_least(1_000_000), short);
    assert_eq!(refused, Status::TimedOut);
    assert!(message.contains("no newer cloud"), "{message}");

    let other = Cell::new("cell-2").unwrap();
    let (refused, message) = refusal(rig.ask(&other, at_least(0), PATIENCE));
    assert_eq!(refused, Status::NotFound);
    assert!(message.contains("service.trays.cell-2"), "{message}");
}

#[test]
fn malformed_clouds_of_a_tray_are_counted() {
    let rig = Rig::new(Stream::TrayCloud);
    rig.show(cloud_of(&[], 0), &at_least(1));
    let mut cloud = cloud_of(&[], 2);
    cloud.data.pop();
    rig.send_refused(&cloud, Fate::Malformed);
}

#[test]
fn trays_that_cannot_be_are_refused() {
    settings().validate().unwrap();
    let refused = |change: fn(&mut Settings)| {
        let mut settings = settings();
        change(&mut settings);
        settings.validate().unwrap_err()
    };
    assert!(refused(|s| s.catalogue = None).contains("catalogue"));
    assert!(refused(|s| s.has_unlisted_cells = false).contains("no cell is served"));
    let other = refused(|s| {
        s.has_unlisted_cells = false;
        s.cells.insert("other".to_owned(), s.grid);
    });
    assert!(other.contains("trays.cell-1: the cell is not served"));
    let tray = |change: fn(&mut TraySettings)| {
        let mut settings = settings();
        settings.trays.values_mut().for_each(change);
        settings.validate().unwrap_err()
    };
    assert!(
        tray(|t| t.segmentation.join_m = f64::NAN).contains("trays.cell-1.segmentation.join_m")
    );
    assert!(tray(|t| t.segmentation.region.highest_m.z = -9.0).contains("region"));
    assert!(tray(|t| t.recognition.least_fitness = 2.0).contains("recognition.least_fitness"));

    let hub = embedded::hub().unwrap();
    let process = embedded::process(&hub, Service::Perception, "perception-1").unwrap();
    let started = ppnpack_perception_service::start(&process, &settings(), None);
    let reason = started.err().unwrap().to_string();
    assert!(
        reason.starts_with("trays: there are no objects"),
        "{reason}"
    );
}
