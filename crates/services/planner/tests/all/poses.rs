//! Objects of the catalogue that may be packed in several resting poses.

use std::sync::Arc;

use crate::common::{self, cell, ids, placed, soon};
use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::catalogue::{self, Catalogue, NamedMesh, Source};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_packing::grid::{Grid, GridSettings};
use ppnpack_packing::heightmap::Surface;
use ppnpack_packing::method::Method;
use ppnpack_packing::trial::TrialSettings;
use ppnpack_planner::{CellSettings, PlannerService, Settings};
use ppnpack_service::Process;
use ppnpack_service::Running;
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::{self, CallError, Client, Incoming, Listener};
use ppnpack_wire::keys::Service;
use ppnpack_wire::v1::{self, ItemState, PlanResult, Reason, Status};
use ppnpack_wire::{convert, rpc::Request};

/// The state that the container stays in.
const STATE: u64 = 2;

/// Each object as its mesh stands, by the sides of its box in metres. The container is 32 x 32 cm and 30 cm high.
const OBJECTS: [(&str, [f64; 3]); 4] = [
    // Fits only where it lies.
    ("post", [0.03, 0.03, 0.31]),
    // Fits in no pose.
    ("slab", [0.5, 0.4, 0.35]),
    // Nearly as wide as the container one way, and wider than what a post leaves free beside it the other.
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

/// An empty container, whatever was placed.
fn heightmap(incoming: Incoming<v1::HeightmapRequest>) {
    let grid = grid().build().unwrap();
    let surface = Surface::empty(&grid);
    common::show_from(incoming, &grid, surface, STATE);
}

/// An object that arrives; the id of the item is the object's name.
fn announcement(object: &str) -> v1::Announcement {
    v1::Announcement {
        item_id: object.to_owned(),
        shape: Some(v1::announcement::Shape::Object(object.to_owned())),
        ..v1::Announcement::default()
    }
}

/// A planner that keeps its sessions in a file, and can be started again.
struct Rig {
    planner: Box<PlannerService>,
    settings: Settings,
    client: Client,
    _perception: (Process, Listener),
    hub: Hub,
    folder: tempfile::TempDir,
}

impl Rig {
    /// A cell with a buffer of so many items that allows so many poses, with a session.
    fn new(buffer: usize, poses: usize) -> Self {
        let hub = embedded::hub().unwrap();
        let perception = embedded::process(&hub, Service::Perception, "perception-1").unwrap();
        let listener = rpc::listen(&perception, None, heightmap).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let settings = CellSettings {
            grid: grid(),
            method: Method {
                buffer,
                trial: TrialSettings::off(),
                ..crate::common::method()
            },
            // The heightmap is never another one.
            heightmap_age_limit_s: 600.0,
            poses,
            ..crate::common::coarse()
        };
        let settings = Settings {
            store: Some(folder.path().join("sessions.redb")),
            ..common::settings(settings)
        };
        let rig = Self {
            planner: common::start(&hub, &settings, &[catalogue(poses)]),
            settings,
            client: Client::new(&embedded::session(&hub).unwrap()),
            _perception: (perception, listener),
            hub,
            folder,
        };
        rig.ask(v1::BeginRequest {
            session_id: "s".to_owned(),
            set_aside: Some(1),
            ..v1::BeginRequest::default()
        });
        rig
    }

    /// The planner anew, with a catalogue in so many poses.
    fn restarted(self, poses: usize) -> Self {
        self.planner.finish(soon()).unwrap();
        Self {
            planner: common::start(&self.hub, &self.settings, &[catalogue(poses)]),
            ..self
        }
    }

    fn finish(self) {
        self.planner.finish(soon()).unwrap();
        drop(self.folder);
    }

    fn call<R: Request>(&self, request: R) -> Result<R::Reply, CallError> {
        self.client.call(&cell(), request, soon())
    }

    fn ask<R: Request>(&self, request: R) -> R::Reply {
        self.call(request).unwrap()
    }

    fn announce(&self, items: Vec<v1::Announcement>) -> Result<v1::AnnounceReply, CallError> {
        self.call(v1::AnnounceRequest {
            items,
            ..v1::AnnounceRequest::default()
        })
    }

    fn plan(&self) -> v1::PlanReply {
        self.ask(v1::PlanRequest {
            alternatives: 2,
            ..v1::PlanRequest::default()
        })
    }

    fn explain(&self, item_id: &str) -> v1::ExplainReply {
        self.ask(v1::ExplainRequest {
            item_id: item_id.to_owned(),
            ..v1::ExplainRequest::default()
        })
    }

    fn session(&self) -> v1::Session {
        self.ask(v1::SessionRequest::default()).session.unwrap()
    }

    fn report_placed(&self, decision: &v1::Decision) {
        self.ask(placed(decision, decision.state_number + 1));
    }
}

/// How high an object of the catalogue reaches where a decision puts it, and its lowest point, in metres.
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
    let rig = Rig::new(2, 3);
    rig.announce(vec![announcement("slab"), announcement("post")])
        .unwrap();
    let explained = rig.explain("post");
    assert_eq!(explained.best.unwrap().pose, 1);
    let reply = rig.plan();
    assert_eq!(reply.result(), PlanResult::Decided);
    let decision = reply.decision.unwrap();
    assert_eq!((decision.item_id.as_str(), decision.pose), ("post", 1));
    let [high_m, low_m] = heights_m(&decision);
    assert!(low_m.abs() < 1e-9 && (high_m - 0.03).abs() < 1e-9);
    // Whatever their poses, items are told of once.
    assert_eq!(decision.buffer, ["slab", "post"]);
    let alternatives = decision.alternatives.iter();
    let alternatives = alternatives.map(|other| (other.candidate, other.pose));
    assert_eq!(alternatives.collect::<Vec<_>>(), [(1, 1); 2]);

    rig.report_placed(&decision);
    let session = rig.session();
    let poses = session.items.iter().map(|item| (item.poses, item.pose));
    assert_eq!(poses.collect::<Vec<_>>(), [(3, 0), (3, 1)]);
    let rig = rig.restarted(3);
    assert_eq!(rig.session(), session);
    rig.finish();
}

#[test]
fn an_item_in_several_poses_has_one_reason_and_is_set_aside_as_one() {
    let rig = Rig::new(1, 3);
    let other = v1::Announcement {
        item_id: "other".to_owned(),
        ..announcement("slab")
    };
    rig.announce(vec![announcement("slab"), other, announcement("post")])
        .unwrap();
    let explained = rig.explain("slab");
    assert_eq!(explained.best, None);
    assert_eq!(explained.reason.unwrap().reason(), Reason::TooLarge);
    let reply = rig.plan();
    assert_eq!(reply.result(), PlanResult::NothingFits);
    assert_eq!(ids(&reply.set_aside), ["slab"]);
    assert_eq!(ids(&reply.reasons), ["other"]);
    let withdraw = v1::WithdrawRequest {
        item_id: "other".to_owned(),
        ..v1::WithdrawRequest::default()
    };
    rig.ask(withdraw);
    let decision = rig.plan().decision.unwrap();
    assert_eq!((decision.item_id.as_str(), decision.pose), ("post", 1));
    assert_eq!(decision.buffer, ["post"]);
    rig.finish();
}

#[test]
fn an_announcement_may_allow_fewer_poses_than_the_cell_and_no_more() {
    let rig = Rig::new(1, 2);
    let allowing = |poses: u32| v1::Announcement {
        poses,
        ..announcement("post")
    };
    let refused = |item: v1::Announcement| {
        let refusal = rig.announce(vec![item]).unwrap_err();
        assert_eq!(refusal.status(), Some(Status::Invalid), "{refusal}");
        assert!(refusal.to_string().contains("poses"), "{refusal}");
    };
    refused(allowing(3));
    // One that lies somewhere, or in a way that was seen, is packed as it lies.
    refused(v1::Announcement {
        waits_at: Some(convert::pose::write(&nalgebra::Isometry3::identity())),
        ..allowing(2)
    });
    let catalogue = catalogue(1);
    let (_, post) = catalogue.find("post").unwrap();
    let heightmaps = convert::item::write(&post.item);
    let seen = |poses: u32| v1::Announcement {
        item_id: "seen".to_owned(),
        shape: Some(v1::announcement::Shape::Item(heightmaps.clone())),
        poses,
        ..v1::Announcement::default()
    };
    refused(seen(2));

    rig.announce(vec![allowing(1), seen(0)]).unwrap();
    for item_id in ["post", "seen"] {
        let explained = rig.explain(item_id);
        assert_eq!(explained.reason.unwrap().reason(), Reason::TooLarge);
    }
    let session = rig.session();
    assert!(session.items.iter().all(|item| item.poses == 0));
    rig.finish();
}

/// An object that may be packed in these poses alone.
fn allowing(object: &str, allowed_poses: &[u32]) -> v1::Announcement {
    v1::Announcement {
        allowed_poses: allowed_poses.to_vec(),
        ..announcement(object)
    }
}

#[test]
fn an_item_is_packed_in_the_poses_that_its_announcement_names_alone() {
    let rig = Rig::new(2, 3);
    // A post fits lying alone, and a brick standing on its end is 20 cm high.
    rig.announce(vec![allowing("post", &[0]), allowing("brick", &[2])])
        .unwrap();
    let explained = rig.explain("post");
    assert_eq!(explained.reason.unwrap().reason(), Reason::TooLarge);
    let decision = rig.plan().decision.unwrap();
    assert_eq!((decision.item_id.as_str(), decision.pose), ("brick", 2));
    let [high_m, _] = heights_m(&decision);
    assert!((high_m - 0.2).abs() < 1e-9, "{high_m}");

    // They are part of the announcement, and kept.
    rig.announce(vec![allowing("post", &[0])]).unwrap();
    let other = rig.announce(vec![announcement("post")]).unwrap_err();
    assert_eq!(other.status(), Some(Status::Conflict), "{other}");
    let session = rig.session();
    let allowed = session
        .items
        .iter()
        .map(|item| item.allowed_poses.as_slice());
    assert_eq!(allowed.collect::<Vec<_>>(), [[0], [2]]);
    let rig = rig.restarted(3);
    assert_eq!(rig.session(), session);
    rig.finish();
}

#[test]
fn poses_that_an_item_cannot_be_packed_in_are_refused_by_number() {
    let rig = Rig::new(1, 3);
    let refused = |item: v1::Announcement, named: &str| {
        let refusal = rig.announce(vec![item]).unwrap_err();
        assert_eq!(refusal.status(), Some(Status::Invalid), "{refusal}");
        let text = refusal.to_string();
        assert!(text.contains("item post") && text.contains(named), "{text}");
    };
    refused(allowing("post", &[1, 3]), "allowed_poses: 3");
    // It is as wide as it is deep.
    refused(allowing("post", &[2]), "allowed_poses: 2");
    refused(allowing("post", &[1, 1]), "allowed_poses: 1 is there twice");
    let both = v1::Announcement {
        poses: 2,
        ..allowing("post", &[1])
    };
    refused(both, "give one of them");
    let lying = |allowed_poses: &[u32]| v1::Announcement {
        waits_at: Some(convert::pose::write(&nalgebra::Isometry3::identity())),
        ..allowing("post", allowed_poses)
    };
    refused(lying(&[1]), "as it lies");
    refused(lying(&[0, 1]), "as it lies");
    rig.announce(vec![lying(&[0])]).unwrap();
    rig.finish();
}

#[test]
fn an_item_whose_only_poses_are_not_known_any_more_is_told_of() {
    let rig = Rig::new(1, 2);
    rig.announce(vec![allowing("post", &[1])]).unwrap();
    assert!(rig.explain("post").best.is_some());
    let rig = rig.restarted(1);
    let refusal = rig.call(v1::PlanRequest::default()).unwrap_err();
    assert_eq!(refusal.status(), Some(Status::Unavailable), "{refusal}");
    assert!(refusal.to_string().contains("`poses`"), "{refusal}");
    rig.finish();
}

#[test]
fn nothing_is_placed_above_a_fragile_item_as_it_lies() {
    let rig = Rig::new(1, 2);
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
    rig.announce(vec![fragile, plate]).unwrap();
    let decision = rig.plan().decision.unwrap();
    assert_eq!((decision.item_id.as_str(), decision.pose), ("post", 1));
    rig.report_placed(&decision);
    let explained = rig.explain("plate");
    assert_eq!(explained.reason.unwrap().reason(), Reason::Constrained);

    // Without the pose it is not known which floor is below it.
    let rig = rig.restarted(1);
    let states = rig.session().items.into_iter().map(|item| item.state());
    assert_eq!(
        states.collect::<Vec<_>>(),
        [ItemState::Packed, ItemState::Waiting]
    );
    let refusal = rig.call(v1::PlanRequest::default()).unwrap_err();
    assert_eq!(refusal.status(), Some(Status::Unavailable), "{refusal}");
    assert!(refusal.to_string().contains("`poses`"), "{refusal}");
    rig.finish();
}
