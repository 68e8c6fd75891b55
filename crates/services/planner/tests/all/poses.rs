//! Objects of the catalogue that may be packed in several resting poses.

use std::sync::Arc;

use crate::common::{self, Rig, announce, ids, placed, states};
use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::catalogue::{self, Catalogue, NamedMesh, Source};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_packing::kernel::grid::{Grid, GridSettings};
use ppnpack_planner::CellSettings;
use ppnpack_wire::convert;
use ppnpack_wire::v1::{self, ItemState, PlanResult, Reason, Status};

/// Each object as its mesh stands, by the sides of its box in metres. The container is 32 x 32 cm
/// and 30 cm high.
const OBJECTS: [(&str, [f64; 3]); 4] = [
    // Fits only where it lies.
    ("post", [0.03, 0.03, 0.31]),
    // Fits in no pose.
    ("slab", [0.5, 0.4, 0.35]),
    // Nearly as wide as the container one way, and wider than what a post leaves free beside it the
    // other.
    ("plate", [0.27, 0.315, 0.02]),
    // Fits in each of its three poses.
    ("brick", [0.2, 0.1, 0.05]),
];

/// One yaw: items are turned by their poses alone.
fn grid() -> GridSettings {
    GridSettings {
        yaws: 1,
        ..GridSettings::from(&Grid::reference())
    }
}

fn catalogue(poses: usize) -> Arc<Catalogue> {
    let objects = OBJECTS.map(|(name, sides_m)| NamedMesh {
        name: name.to_owned(),
        mesh: Mesh::cuboid([0.0; 3], sides_m),
        density_kg_m3: 400.0,
    });
    let settings = catalogue::Settings {
        poses,
        cache: CacheDir::Nowhere,
        ..catalogue::Settings::default()
    };
    let source = Source::Meshes(objects.to_vec().into());
    let resolution = grid().resolution().unwrap();
    Arc::new(Catalogue::load(&source, &settings, &resolution, &|_, _| ()).unwrap())
}

/// A cell with a buffer of so many items that allows so many poses, with a session.
fn rig(buffer: usize, poses: usize) -> Rig {
    let mut settings = CellSettings {
        grid: grid(),
        poses,
        ..common::untried()
    };
    settings.method.buffer = buffer;
    let rig = Rig::with_objects(settings, &[catalogue(poses)]);
    rig.begin_as(v1::BeginRequest {
        set_aside: Some(1),
        ..v1::BeginRequest::default()
    });
    rig
}

/// An object that arrives; the id of the item is the object's name.
fn announcement(object: &str) -> v1::Announcement {
    v1::Announcement {
        item_id: object.to_owned(),
        shape: Some(v1::announcement::Shape::Object(object.to_owned())),
        ..v1::Announcement::default()
    }
}

/// An object that may be packed in these poses alone.
fn allowing(object: &str, allowed_poses: &[u32]) -> v1::Announcement {
    v1::Announcement {
        allowed_poses: allowed_poses.to_vec(),
        ..announcement(object)
    }
}

/// An object that stands on the container's origin.
fn waiting(item: v1::Announcement) -> v1::Announcement {
    v1::Announcement {
        waits_at: Some(convert::pose::write(&nalgebra::Isometry3::identity())),
        ..item
    }
}

fn assert_invalid(rig: &Rig, item: v1::Announcement, named: &str) {
    let refused = rig.ask(announce([item])).unwrap_err();
    assert_eq!(refused.status(), Some(Status::Invalid), "{refused}");
    let text = refused.to_string();
    assert!(text.contains("item ") && text.contains(named), "{text}");
}

fn assert_unknown_poses(rig: &Rig) {
    rig.assert_refused(v1::PlanRequest::default(), Status::Unavailable, "`poses`");
}

/// How high an object of the catalogue reaches where a decision puts it, and its lowest point, in
/// metres.
fn heights_m(decision: &v1::Decision) -> [f64; 2] {
    let pose = decision.container_from_item.as_ref();
    let pose = convert::pose::read_required("pose", pose).unwrap();
    let catalogue = catalogue(1);
    let (_, object) = catalogue.find(&decision.object).unwrap();
    let vertices = object.model.mesh.vertices.iter();
    let heights_m = vertices.map(|vertex| (pose * vertex).z);
    let none = [f64::NEG_INFINITY, f64::INFINITY];
    heights_m.fold(none, |[high, low], z_m| [high.max(z_m), low.min(z_m)])
}

#[test]
fn an_item_that_is_too_high_as_it_stands_is_decided_lying() {
    let mut rig = rig(2, 3);
    rig.announce(["slab", "post"].map(announcement));
    assert_eq!(rig.explain("post").best.unwrap().pose, 1);
    let reply = rig.call(v1::PlanRequest {
        alternatives: 2,
        ..v1::PlanRequest::default()
    });
    let decision = reply.decision.unwrap();
    assert_eq!((decision.item_id.as_str(), decision.pose), ("post", 1));
    let [high_m, low_m] = heights_m(&decision);
    assert!(low_m.abs() < 1e-9 && (high_m - 0.03).abs() < 1e-9);
    // Whatever their poses, items are told of once.
    assert_eq!(decision.buffer, ["slab", "post"]);
    let alternatives = decision.alternatives.iter();
    let alternatives = alternatives.map(|other| (other.candidate, other.pose));
    assert_eq!(alternatives.collect::<Vec<_>>(), [(1, 1); 2]);

    rig.call(placed(&decision, decision.state_number + 1));
    let session = rig.session();
    let poses = session.items.iter().map(|item| (item.poses, item.pose));
    assert_eq!(poses.collect::<Vec<_>>(), [(3, 0), (3, 1)]);
    rig.restart(&[catalogue(3)], |_| {});
    assert_eq!(rig.session(), session);
}

#[test]
fn an_item_in_several_poses_has_one_reason_and_is_set_aside_as_one() {
    let rig = rig(1, 3);
    let other = v1::Announcement {
        item_id: "other".to_owned(),
        ..announcement("slab")
    };
    rig.announce([announcement("slab"), other, announcement("post")]);
    let explained = rig.explain("slab");
    assert_eq!(explained.best, None);
    assert_eq!(explained.reason.unwrap().reason(), Reason::TooLarge);
    let reply = rig.plan();
    assert_eq!(reply.result(), PlanResult::NothingFits);
    assert_eq!(ids(&reply.set_aside), ["slab"]);
    assert_eq!(ids(&reply.reasons), ["other"]);
    rig.withdraw("other");
    let decision = rig.decision();
    assert_eq!((decision.item_id.as_str(), decision.pose), ("post", 1));
    assert_eq!(decision.buffer, ["post"]);
}

#[test]
fn an_announcement_may_allow_fewer_poses_than_the_cell_and_no_more() {
    let rig = rig(1, 2);
    let of_poses = |poses: u32| v1::Announcement {
        poses,
        ..announcement("post")
    };
    assert_invalid(&rig, of_poses(3), "poses");
    // One that lies somewhere, or in a way that was seen, is packed as it lies.
    assert_invalid(&rig, waiting(of_poses(2)), "poses");
    let catalogue = catalogue(1);
    let (_, post) = catalogue.find("post").unwrap();
    let heightmaps = convert::item::write(&post.item);
    let seen = |poses: u32| v1::Announcement {
        poses,
        ..common::announcement("seen", heightmaps.clone())
    };
    assert_invalid(&rig, seen(2), "poses");

    rig.announce([of_poses(1), seen(0)]);
    for item_id in ["post", "seen"] {
        let reason = rig.explain(item_id).reason.unwrap();
        assert_eq!(reason.reason(), Reason::TooLarge);
    }
    let session = rig.session();
    assert!(session.items.iter().all(|item| item.poses == 0));
}

#[test]
fn an_item_is_packed_in_the_poses_that_its_announcement_names_alone() {
    let mut rig = rig(2, 3);
    // A post fits lying alone, and a brick standing on its end is 20 cm high.
    rig.announce([allowing("post", &[0]), allowing("brick", &[2])]);
    let reason = rig.explain("post").reason.unwrap();
    assert_eq!(reason.reason(), Reason::TooLarge);
    let decision = rig.decision();
    assert_eq!((decision.item_id.as_str(), decision.pose), ("brick", 2));
    let [high_m, _] = heights_m(&decision);
    assert!((high_m - 0.2).abs() < 1e-9, "{high_m}");

    // They are part of the announcement, and kept.
    rig.announce([allowing("post", &[0])]);
    rig.assert_refused(announce([announcement("post")]), Status::Conflict, "");
    let session = rig.session();
    rig.restart(&[catalogue(3)], |_| {});
    assert_eq!(rig.session(), session);
}

#[test]
fn poses_that_an_item_cannot_be_packed_in_are_refused_by_number() {
    let rig = rig(1, 3);
    let both = v1::Announcement {
        poses: 2,
        ..allowing("post", &[1])
    };
    for (item, named) in [
        (allowing("post", &[1, 3]), "allowed_poses: 3"),
        // It is as wide as it is deep.
        (allowing("post", &[2]), "allowed_poses: 2"),
        (allowing("post", &[1, 1]), "allowed_poses: 1 is there twice"),
        (both, "give one of them"),
        (waiting(allowing("post", &[1])), "as it lies"),
        (waiting(allowing("post", &[0, 1])), "as it lies"),
    ] {
        assert_invalid(&rig, item, named);
    }
    rig.announce([waiting(allowing("post", &[0]))]);
}

#[test]
fn an_item_whose_only_poses_are_not_known_any_more_is_told_of() {
    let mut rig = rig(1, 2);
    rig.announce([allowing("post", &[1])]);
    assert!(rig.explain("post").best.is_some());
    rig.restart(&[catalogue(1)], |_| {});
    assert_unknown_poses(&rig);
}

#[test]
fn nothing_is_placed_above_a_fragile_item_as_it_lies() {
    let mut rig = rig(1, 2);
    let fragile = v1::Announcement {
        rules: Some(v1::ItemRules {
            is_fragile: true,
            ..v1::ItemRules::default()
        }),
        ..announcement("post")
    };
    let plate = v1::Announcement {
        poses: 1,
        ..announcement("plate")
    };
    rig.announce([fragile, plate]);
    let decision = rig.step();
    assert_eq!((decision.item_id.as_str(), decision.pose), ("post", 1));
    let reason = rig.explain("plate").reason.unwrap();
    assert_eq!(reason.reason(), Reason::Constrained);

    // Without the pose it is not known which floor is below it.
    rig.restart(&[catalogue(1)], |_| {});
    let expected = [ItemState::Packed, ItemState::Waiting];
    assert_eq!(states(&rig.session()), expected);
    assert_unknown_poses(&rig);
}
