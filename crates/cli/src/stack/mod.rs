//! All services in one process, over a Zenoh router of their own.

pub(crate) mod connect;
pub mod controller;
pub mod report;

use std::collections::BTreeMap;
use std::error::Error;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, anyhow};
use ppnpack_bridge::RemoteSettings;
use ppnpack_bridge::simulated::{FaultSettings, Scan, SimulatedSettings, sensor_names};
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_packing::kernel::grid::{Grid, GridSettings};
use ppnpack_packing::planning::method::Method;
use ppnpack_perception::settings::MapperSettings;
use ppnpack_perception_service::TraySettings;
use ppnpack_physics::twin::TwinSettings;
use ppnpack_physics::view::CameraSettings;
use ppnpack_planner::{CellSettings, ClosingSettings, ContainerSettings};
use ppnpack_recognition::library::Library;
use ppnpack_robot::station::StationSettings;
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::Client;
use ppnpack_service::{Process, Running, Shutdown};
use ppnpack_wire::keys::{Cell, Service};

use crate::failure::{Failure, OrInput, OrRun, Outcome};
use crate::options::{Network, Simulated};

/// Maximum time for services to finish what is in flight.
const GRACE: Duration = Duration::from_secs(10);

/// The containers of a cell.
#[derive(Debug, Clone, Copy)]
pub struct Containers {
    /// Their number, at least one.
    pub count: u32,
    /// Whether the bridge brings an empty one for each that is full, so that the automatic mode
    /// goes on.
    pub renews: bool,
}

impl Containers {
    /// One, which stays when it is full.
    pub const ONE: Self = Self {
        count: 1,
        renews: false,
    };
}

/// The plan of a stack.
pub struct Plan<'a> {
    /// The names of its cells.
    pub cells: Vec<Cell>,
    /// The containers of each cell.
    pub containers: Containers,
    /// The grid that they plan on.
    pub grid: &'a Grid,
    /// The method by which they plan.
    pub method: &'a Method,
    /// The most resting poses in which an object may be packed; the catalogue has to have as many.
    pub poses: usize,
    /// The arm that has to make the placements, if any.
    pub arm: Option<&'a StationSettings>,
    /// The simulated cells that the bridge works.
    pub simulated: &'a Simulated,
    /// Sensing and handling of its cells.
    pub sensing: &'a Sensing,
    /// The objects.
    pub catalogue: Arc<Catalogue>,
    /// Number of valid placements beside the chosen one that decisions of the automatic mode tell.
    pub alternatives: usize,
    /// The name of the source that `catalogue` was loaded from.
    pub source: &'a str,
    /// The network that proposes, where one does.
    pub network: Option<Network<'a>>,
    /// The folder of sessions and of the bridge's journal; without one they are in memory.
    pub store: Option<&'a Path>,
    /// Zenoh endpoints to listen on beside a loopback port of the system's choice.
    pub listen: Vec<String>,
    /// The domain of ROS 2 that its cells are in, where they are in one.
    pub ros: Option<u32>,
}

/// Sensing and handling of a stack's cells; by default exact, and without faults.
#[derive(Debug, Clone, Default)]
pub struct Sensing {
    /// The cameras that see the container; without any, it is scanned exactly.
    pub camera: Option<CameraSettings>,
    /// Settings by which clouds become heightmaps.
    pub mapper: MapperSettings,
    /// Rates at which placements go wrong.
    pub faults: FaultSettings,
    /// The robots, where they are programs of their own.
    pub remote: Option<RemoteSettings>,
    /// Speed at which robots follow the motions of placements: 1 in time, 0 without any wait.
    pub motion_speed: f64,
    /// Whether placed items are inspected; as the planner does by itself where nothing is said.
    pub inspect: Option<bool>,
    /// The tray on which items wait to be recognised.
    pub tray: Option<TraySettings>,
    /// The objects that can be recognised: a tray and inspections need them.
    pub library: Option<Arc<Library>>,
}

/// A running stack.
pub struct Stack {
    services: Vec<(Service, Process, Box<dyn Running>)>,
    session: zenoh::Session,
    hub: Hub,
}

impl Stack {
    /// Starts all services. A network that cannot run here is left out: the planner then searches
    /// exhaustively and says so with each decision.
    pub fn start(plan: &Plan<'_>) -> Outcome<Self> {
        let hub = embedded::hub_at(&plan.listen).or_input()?;
        let session = embedded::session(&hub).or_run()?;
        let mut stack = Self {
            services: Vec::new(),
            session,
            hub,
        };
        if let Some(folder) = plan.store {
            let made = std::fs::create_dir_all(folder);
            let none = || format!("{} cannot be made", folder.display());
            made.with_context(none).or_input()?;
        }
        stack.add(Service::Heuristic, |process| {
            ppnpack_heuristic::start(process, &ppnpack_heuristic::Settings::default())
        })?;
        if let Some(network) = &plan.network {
            stack.add_network(network, &ppnpack_ppn_service::Settings::default());
        }
        stack.add(Service::Perception, |process| {
            let library = plan.sensing.library.clone();
            let objects = library.map(ppnpack_perception_service::Objects::of);
            let settings = perception_settings(plan);
            ppnpack_perception_service::start(process, &settings, objects.as_ref())
        })?;
        stack.add(Service::Bridge, |process| {
            ppnpack_bridge::start(process, &bridge_settings(plan), &plan.catalogue)
        })?;
        stack.add(Service::Planner, |process| {
            let catalogues = [Arc::clone(&plan.catalogue)];
            ppnpack_planner::start(process, &planner_settings(plan), &catalogues)
        })?;
        if let Some(domain) = plan.ros {
            stack.add(Service::Ros, |process| {
                let settings = ppnpack_ros_service::Settings {
                    domain,
                    ..ppnpack_ros_service::Settings::default()
                };
                ppnpack_ros_service::start(process, &settings)
            })?;
        }
        Ok(stack)
    }

    /// Serves the operator's page by settings that are valid. Gives its address, with the port that
    /// the system chose.
    pub(crate) fn serve_console(
        &mut self,
        settings: &ppnpack_console::Settings,
    ) -> Outcome<SocketAddr> {
        let mut address = settings.listen;
        self.add(Service::Console, |process| {
            let started = ppnpack_console::start(process, settings);
            started.inspect(|console| address = console.address())
        })?;
        Ok(address)
    }

    /// Gives the endpoint that others connect to.
    pub(crate) fn endpoint(&self) -> &str {
        self.hub.endpoint()
    }

    /// Makes a client of the stack.
    pub fn client(&self) -> Client {
        Client::new(&self.session)
    }

    /// Gives the session of what belongs to no service.
    pub fn session(&self) -> &zenoh::Session {
        &self.session
    }

    /// Gives the wish that the stack ends.
    pub(crate) fn shutdown(&self) -> &Shutdown {
        self.hub.shutdown()
    }

    /// Gives the reason why the stack ends, where it does not as it was asked to.
    pub(crate) fn fault(&self) -> Option<String> {
        self.hub.fault()
    }

    /// Ends all services, those first that ask others.
    pub fn finish(self) -> Outcome {
        let deadline = Instant::now() + GRACE;
        self.hub.shutdown().request();
        let mut left = Vec::new();
        for (service, process, running) in self.services.into_iter().rev() {
            process.health().end_quietly();
            if let Err(undone) = running.finish(deadline) {
                left.push(format!("{service}: {undone}"));
            }
            drop(process);
        }
        match left.join("; ") {
            left if left.is_empty() => Ok(()),
            left => Err(Failure::Run(anyhow!("not finished in time: {left}"))),
        }
    }

    fn add<R: Running + 'static, E: Error + Send + Sync + 'static>(
        &mut self,
        service: Service,
        start: impl FnOnce(&Process) -> Result<R, E>,
    ) -> Outcome {
        let process = embedded::process(&self.hub, service, &format!("{service}-1")).or_run()?;
        let running = start(&process);
        let running = running.with_context(|| format!("the {service} service does not start"));
        let running = running.or_run()?;
        self.services.push((service, process, Box::new(running)));
        Ok(())
    }

    fn add_network(&mut self, network: &Network<'_>, settings: &ppnpack_ppn_service::Settings) {
        let opened = network.backend.network(network.model, network.device);
        let added = opened.map_err(Failure::Run).and_then(|network| {
            self.add(Service::Ppn, |process| {
                ppnpack_ppn_service::start(process, settings, network)
            })
        });
        if let Err(failure) = added {
            tracing::warn!(reason = %failure, "the stack runs without a network");
        }
    }
}

/// Names a cell's containers: by the cell's own name where it has one, else with a letter each.
fn containers_of(plan: &Plan<'_>, cell: &Cell) -> Vec<String> {
    match plan.containers.count {
        ..=1 => vec![cell.to_string()],
        count => {
            let letters = ('a'..='z').take(count as usize);
            letters.map(|letter| format!("{cell}-{letter}")).collect()
        }
    }
}

fn of_containers<T>(plan: &Plan<'_>, settings: impl Fn() -> T) -> BTreeMap<String, T> {
    let containers = plan.cells.iter().flat_map(|cell| containers_of(plan, cell));
    containers.map(|name| (name, settings())).collect()
}

fn file(plan: &Plan<'_>, name: &str) -> Option<PathBuf> {
    plan.store.map(|folder| folder.join(name))
}

fn perception_settings(plan: &Plan<'_>) -> ppnpack_perception_service::Settings {
    let sensing = plan.sensing;
    let tray = sensing.tray.as_ref();
    let trays = tray.map(|tray| of_containers(plan, || tray.clone()));
    let cameras = sensing.camera.map_or(1, |camera| camera.cameras);
    let sensors = (cameras > 1).then(|| of_containers(plan, || sensor_names(cameras)));
    ppnpack_perception_service::Settings {
        cells: of_containers(plan, || GridSettings::from(plan.grid)),
        sensors: sensors.unwrap_or_default(),
        mapper: sensing.mapper.clone(),
        catalogue: sensing.library.as_ref().map(|_| plan.source.to_owned()),
        trays: trays.unwrap_or_default(),
        ..ppnpack_perception_service::Settings::default()
    }
}

fn bridge_settings(plan: &Plan<'_>) -> ppnpack_bridge::Settings {
    let cell = || SimulatedSettings {
        physics: plan.simulated.cell.clone(),
        scan_pitch_m: plan.grid.resolution().surface_pitch_m(),
        scan: plan.sensing.camera.map_or(Scan::Exact, |_| Scan::Camera),
        camera: plan.sensing.camera.unwrap_or_default(),
        faults: plan.sensing.faults,
        motion_speed: plan.sensing.motion_speed,
        remote: plan.sensing.remote,
        ..SimulatedSettings::default()
    };
    let robots = plan.cells.iter().filter(|_| plan.containers.count > 1);
    let robots = robots.map(|cell| (cell.to_string(), containers_of(plan, cell)));
    ppnpack_bridge::Settings {
        cells: of_containers(plan, cell),
        robots: robots.collect(),
        journal: file(plan, "bridge.redb"),
        catalogue: plan.source.to_owned(),
        ..ppnpack_bridge::Settings::default()
    }
}

fn planner_settings(plan: &Plan<'_>) -> ppnpack_planner::Settings {
    let containers = |cell: &Cell| {
        let several = containers_of(plan, cell).into_iter();
        let several = several.filter(|_| plan.containers.count > 1);
        several.map(|name| (name, ContainerSettings::default()))
    };
    let settings = |cell: &Cell| CellSettings {
        containers: containers(cell).collect(),
        closing: ClosingSettings {
            renews: plan.containers.renews,
            ..ClosingSettings::default()
        },
        grid: GridSettings::from(plan.grid),
        method: plan.method.clone(),
        arm: plan.arm.cloned(),
        poses: plan.poses,
        alternatives: plan.alternatives,
        inspect: plan.sensing.inspect,
        twin: TwinSettings::of(&plan.simulated.cell),
        ..CellSettings::default()
    };
    let cells = plan.cells.iter();
    ppnpack_planner::Settings {
        cells: cells
            .map(|cell| (cell.to_string(), settings(cell)))
            .collect(),
        store: file(plan, "sessions.redb"),
        catalogue: plan.source.to_owned(),
        ..ppnpack_planner::Settings::default()
    }
}
