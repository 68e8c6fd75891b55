//! A planner of a cell with several containers.

use std::collections::BTreeMap;

use ppnpack_packing::grid::GridSettings;
use ppnpack_packing::heightmap::Surface;
use ppnpack_packing::method::Method;
use ppnpack_packing::trial::TrialSettings;
use ppnpack_planner::{CellSettings, ContainerSettings, PlannerService, Settings};
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::{self, CallError, Client, Incoming, Listener};
use ppnpack_service::{Process, Running, ServiceSettings};
use ppnpack_wire::keys::{Cell, Service};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::{self, PlanResult, Status};

use super::{announcement, block, cell, placed, soon};

/// A planner of a cell with two containers, and a perception that sees some of them, always empty.
pub(crate) struct Rig {
    planner: Box<PlannerService>,
    settings: Settings,
    pub(crate) client: Client,
    _perception: (Process, Vec<Listener>),
    pub(crate) hub: Hub,
    folder: tempfile::TempDir,
}

/// A cell with two containers, in which nothing is tried: a twin would know better than what a test shows.
pub(crate) fn left_and_right() -> CellSettings {
    let containers = ["left", "right"].map(|name| (name.to_owned(), ContainerSettings::default()));
    CellSettings {
        containers: BTreeMap::from(containers),
        method: Method {
            trial: TrialSettings::off(),
            ..crate::common::method()
        },
        heightmap_age_limit_s: 600.0,
        ..crate::common::coarse()
    }
}

impl Rig {
    pub(crate) fn new(seen: &[&str], change: impl FnOnce(&mut CellSettings)) -> Self {
        let mut settings = left_and_right();
        change(&mut settings);
        let hub = embedded::hub().unwrap();
        let perception = embedded::process(&hub, Service::Perception, "perception-1").unwrap();
        let listeners = seen.iter().map(|name| {
            let container = Cell::new(name).unwrap();
            let own = settings.containers.get(*name);
            let grid = GridSettings {
                container: own
                    .and_then(|own| own.container)
                    .unwrap_or(settings.grid.container),
                ..settings.grid
            };
            let grid = grid.build().unwrap();
            let show = move |incoming: Incoming<v1::HeightmapRequest>| {
                let surface = Surface::empty(&grid);
                super::show_from(incoming, &grid, surface, 2);
            };
            rpc::listen(&perception, Some(&container), show).unwrap()
        });
        let listeners = listeners.collect();
        let folder = tempfile::tempdir().unwrap();
        let settings = Settings {
            store: Some(folder.path().join("sessions.redb")),
            ..super::settings(settings)
        };
        settings.validate().unwrap();
        Self {
            planner: super::start(&hub, &settings, &[]),
            settings,
            client: Client::new(&embedded::session(&hub).unwrap()),
            _perception: (perception, listeners),
            hub,
            folder,
        }
    }

    pub(crate) fn finish(self) {
        self.planner.finish(soon()).unwrap();
        drop(self.folder);
    }

    pub(crate) fn restarted(self, change: impl FnOnce(&mut Settings)) -> Self {
        self.planner.finish(soon()).unwrap();
        let mut settings = self.settings;
        change(&mut settings);
        Self {
            planner: super::start(&self.hub, &settings, &[]),
            settings,
            ..self
        }
    }

    pub(crate) fn ask<R: Request>(&self, request: R) -> Result<R::Reply, CallError> {
        self.client.call(&cell(), request, soon())
    }

    pub(crate) fn call<R: Request>(&self, request: R) -> R::Reply {
        self.ask(request).unwrap()
    }

    pub(crate) fn refused<R: Request>(&self, request: R) -> (Option<Status>, String) {
        let error = self.ask(request).map(|_| ()).unwrap_err();
        (error.status(), error.to_string())
    }

    /// Begins a session of so many blocks.
    pub(crate) fn begin(&self, blocks: usize) {
        super::begin(&self.client);
        self.announce(blocks);
    }

    pub(crate) fn announce(&self, blocks: usize) {
        let items = (0..blocks).map(|number| announcement(&format!("i{number}"), block()));
        self.call(v1::AnnounceRequest {
            items: items.collect(),
            ..v1::AnnounceRequest::default()
        });
    }

    /// Plans a step, and reports it as placed.
    pub(crate) fn step(&self) -> v1::Decision {
        let reply = self.call(v1::PlanRequest::default());
        assert_eq!(reply.result(), PlanResult::Decided);
        let decision = reply.decision.unwrap();
        self.call(placed(&decision, decision.state_number + 1));
        decision
    }

    pub(crate) fn session(&self) -> v1::Session {
        self.call(v1::SessionRequest::default()).session.unwrap()
    }
}

pub(crate) fn close(container: &str, sequence: u64) -> v1::CloseRequest {
    v1::CloseRequest {
        container: container.to_owned(),
        sequence,
        text: "the truck leaves".to_owned(),
        ..v1::CloseRequest::default()
    }
}

pub(crate) fn open(container: &str, sequence: u64) -> v1::OpenRequest {
    v1::OpenRequest {
        start: Some(v1::ContainerStart {
            container: container.to_owned(),
            least_state_number: 50,
            ..v1::ContainerStart::default()
        }),
        sequence,
        ..v1::OpenRequest::default()
    }
}
