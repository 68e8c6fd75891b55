//! `ppnpack up`: all services in one process; with `--pack` one sequence is packed through them.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use clap::Args;
use ppnpack_bridge::RemoteSettings;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_perception::settings::MapperSettings;
use ppnpack_perception_service::TraySettings;
use ppnpack_physics::packing_cell::Sampling;
use ppnpack_recognition::library::{Library, LibrarySettings};
use ppnpack_recognition::recognise::RecognitionSettings;
use ppnpack_recognition::segmentation::{Region, SegmentationSettings};
use ppnpack_service::ServiceSettings;
use ppnpack_service::configuration::Secret;
use ppnpack_service::rpc::Client;
use ppnpack_view::View;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;

use super::job::{ALTERNATIVES, CellOptions, JobOptions};
use super::view::{self, DEFAULT_ADDRESS};
use crate::failure::{Failure, OrInput, OrRun, Outcome};
use crate::network::Backend;
use crate::options::{Simulated, parse_region};
use crate::output::print_line;
use crate::progress;
use crate::report::{ArmWork, Packing, Settings};
use crate::stack::controller::Controller;
use crate::stack::{self, Containers, Stack, connect};

/// Default address of the operator's page: on this machine alone.
const DEFAULT_CONSOLE: &str = "127.0.0.1:8770";

/// The environment variable that has the token of the page's controls.
const CONSOLE_TOKEN_VARIABLE: &str = "PPNPACK_CONSOLE_TOKEN";

/// Runs perception, ppn, heuristic, bridge (simulated cells) and planner in one process, with a
/// Zenoh router that cell controllers connect to.
#[derive(Debug, Args)]
pub(crate) struct UpArguments {
    #[command(flatten)]
    cell: CellOptions,

    #[command(flatten)]
    services: ServiceOptions,

    #[command(flatten)]
    packing: PackingOptions,
}

/// The cells, and what serves them.
#[derive(Debug, Args)]
#[command(next_help_heading = "Services")]
struct ServiceOptions {
    /// How many cells there are: cell-1, cell-2 and so on
    #[arg(long, value_name = "COUNT", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    cells: u32,

    /// How many containers each cell packs at the same time: cell-1-a, cell-1-b and so on
    #[arg(long, value_name = "COUNT", default_value_t = 1, conflicts_with = "pack", value_parser = clap::value_parser!(u32).range(1..=8))]
    containers: u32,

    /// In automatic mode, have a container taken away and an empty one brought where nothing fits
    /// any more
    #[arg(long, conflicts_with = "pack")]
    renew: bool,

    /// The cells' robots and cameras are programs of their own, such as of `ppnpack.robot` in
    /// Python, in place of simulated ones
    #[arg(long, conflicts_with = "pack")]
    remote_robots: bool,

    /// A Zenoh endpoint to listen on (may be repeated) [default: the environment's
    /// PPNPACK_ENDPOINT, else tcp/127.0.0.1:7447; with --pack and without --ros a free port of this
    /// machine]
    #[arg(long, value_name = "ENDPOINT")]
    listen: Vec<String>,

    /// A folder in which sessions and what was placed survive a restart [default: in memory]
    #[arg(long, value_name = "DIR")]
    store: Option<PathBuf>,

    /// The place where items wait below a sensor of their own, by the lowest and the highest corner
    /// in the container frame: they are recognised there. See docs/protocol.md
    #[arg(long, value_name = "X,Y,Z,X,Y,Z", value_parser = parse_region, allow_hyphen_values = true)]
    tray: Option<Region>,

    /// Serve the cells to Foxglove as they work, at this address [with no address: 127.0.0.1:8765]
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = DEFAULT_ADDRESS, conflicts_with = "connect")]
    viewers: Option<SocketAddr>,

    /// Have the cells in ROS 2, in this domain [with no domain: 0]. Its nodes connect to the Zenoh
    /// endpoint. See docs/ros2.md
    #[arg(long, value_name = "DOMAIN", num_args = 0..=1, default_missing_value = "0", conflicts_with = "connect", value_parser = clap::value_parser!(u32).range(0..=232))]
    ros: Option<u32>,

    /// Serve the operator's page at this address [with no address: 127.0.0.1:8770]. Its controls
    /// ask for the token in the environment's PPNPACK_CONSOLE_TOKEN; without one there are none.
    /// See docs/console.md
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = DEFAULT_CONSOLE, conflicts_with = "connect")]
    console: Option<SocketAddr>,
}

/// One sequence to pack.
#[derive(Debug, Args)]
#[command(next_help_heading = "Packing one sequence")]
struct PackingOptions {
    /// Pack one sequence into an empty container through the services, write a report, and end
    #[arg(long)]
    pack: bool,

    #[command(flatten)]
    job: JobOptions,

    /// Pack through the stack at this Zenoh endpoint instead, into an empty container that it is
    /// asked to bring. Catalogue, grid and method must be what that stack is configured with; of
    /// these, only the grid is checked
    #[arg(long, value_name = "ENDPOINT", requires = "pack", conflicts_with_all = ["listen", "store", "cells", "tray"])]
    connect: Option<String>,

    /// A Zenoh configuration (JSON5) for --connect to begin with, such as one with certificates
    #[arg(long, value_name = "FILE", requires = "connect")]
    zenoh_config: Option<PathBuf>,
}

pub(crate) fn run(arguments: &UpArguments, backend: &dyn Backend) -> Outcome {
    let UpArguments {
        cell: options,
        services,
        packing,
    } = arguments;
    if options.method.arm.listed()? {
        return Ok(());
    }
    let cell = options.set_up(backend, packing.connect.is_none())?;
    if cell.method.proposals.gives_up_early() {
        return Err(Failure::input(
            "--method: proposals of random tries are for `ppnpack pack` and comparisons; a stack gives no item up that has a \
             valid placement",
        ));
    }
    if cell.simulated.scan != Sampling::Greatest {
        return Err(Failure::input(
            "--view middles is for `ppnpack pack`; the services see every cell exactly",
        ));
    }
    if cell.simulated.preloaded.is_some() {
        return Err(Failure::input(
            "--physics: `preloaded` is for `ppnpack pack`; services see by their pictures what lies there",
        ));
    }
    if packing.pack {
        packing.job.begin()?;
    }
    let catalogue = options.load(&cell, &[])?;
    let pack = |controller: &Controller| -> Outcome<Packing> {
        let (settings, arm) = packing.job.settings(options, &cell, &catalogue)?;
        packed(controller, &catalogue, settings, arm)
    };
    if let Some(endpoint) = &packing.connect {
        let session = connect::open(endpoint, packing.zenoh_config.as_deref())?;
        let controller = Controller::new(Client::new(&session), Cell::new("cell-1").or_input()?);
        controller.renew()?;
        return packing.job.publish(&pack(&controller)?);
    }
    let items = catalogue.items();
    let network = options
        .method
        .proposals
        .network(backend, cell.model.as_ref(), &items);
    let cells = (1..=services.cells).map(|number| Cell::new(&format!("cell-{number}")));
    let plan = stack::Plan {
        cells: cells.collect::<Result<_, _>>().or_input()?,
        containers: Containers {
            count: services.containers,
            renews: services.renew,
        },
        grid: &cell.grid,
        method: &cell.method,
        poses: options.catalogue.poses as usize,
        // Who looks on compares them.
        alternatives: match services.console {
            Some(_) => ALTERNATIVES.into(),
            None => 0,
        },
        arm: cell.arm.as_ref(),
        simulated: &cell.simulated,
        sensing: &arguments.sensing(&cell.simulated, &catalogue)?,
        catalogue: Arc::clone(&catalogue),
        source: &options.catalogue.catalogue,
        network: network.filter(|_| cell.method.proposals.is_network()),
        store: services.store.as_deref(),
        listen: arguments.listen(),
        ros: services.ros,
    };
    // What is wrong with it is said before anything is started.
    let console = services.console.map(console_settings).transpose()?;
    let mut stack = Stack::start(&plan)?;
    let console = console.map(|settings| stack.serve_console(&settings));
    let console = console.transpose()?;
    let view = services.viewers;
    let view = view.map(|address| View::start(stack.session(), address));
    let view = view.transpose().or_run()?;
    if !packing.pack {
        return serve(stack, &plan, view, console);
    }
    let first = plan.cells.first().cloned();
    let first = first.ok_or_else(|| Failure::input("--pack needs a cell"))?;
    let controller = Controller::new(stack.client(), first);
    // With a store, what a packing before this one left lies there, and would be in this one's way
    // and figures.
    if !controller.state()?.bodies.is_empty() {
        tracing::warn!("the container is not empty: an empty one is brought");
        controller.renew()?;
    }
    let done = pack(&controller)?;
    view.map_or(Ok(()), View::finish).or_run()?;
    stack.finish()?;
    packing.job.publish(&done)
}

impl UpArguments {
    /// Sets up how cells are seen, with what can be recognised where that is wanted.
    fn sensing(&self, simulated: &Simulated, catalogue: &Catalogue) -> Outcome<stack::Sensing> {
        let mut sensing = stack::Sensing {
            // A packing of its own is done as soon as can be; a cell that others watch moves in
            // time.
            motion_speed: if self.packing.pack { 0.0 } else { 1.0 },
            remote: self.services.remote_robots.then(RemoteSettings::default),
            ..stack::Sensing::default()
        };
        if let Some(camera) = simulated.camera {
            sensing.camera = Some(camera);
            sensing.mapper = MapperSettings::of_camera(camera.noise.sigma_m);
        }
        if let Some(region) = self.services.tray {
            let library = Library::new(&catalogue.models(), LibrarySettings::default());
            let segmentation = SegmentationSettings::of(region);
            segmentation.validate().or_input()?;
            sensing.library = Some(Arc::new(library.or_input()?));
            sensing.tray = Some(TraySettings {
                segmentation,
                recognition: RecognitionSettings::default(),
            });
        }
        Ok(sensing)
    }

    fn listen(&self) -> Vec<String> {
        // Nodes of ROS have to find a packing, too.
        let is_found = !self.packing.pack || self.services.ros.is_some();
        match &self.services.listen {
            none if none.is_empty() && is_found => vec![connect::default_endpoint()],
            given => given.clone(),
        }
    }
}

/// Gives the settings of the operator's page at an address.
fn console_settings(listen: SocketAddr) -> Outcome<ppnpack_console::Settings> {
    let token = std::env::var(CONSOLE_TOKEN_VARIABLE).ok();
    let settings = ppnpack_console::Settings {
        listen,
        token: token.map(Secret::from),
        ..ppnpack_console::Settings::default()
    };
    settings.validate().map_err(Failure::input)?;
    Ok(settings)
}

/// Serves until it is told to end.
fn serve(
    stack: Stack,
    plan: &stack::Plan<'_>,
    view: Option<View>,
    console: Option<SocketAddr>,
) -> Outcome {
    let shutdown = stack.shutdown().clone();
    ctrlc::set_handler(move || shutdown.request()).or_run()?;
    let cells: Vec<&str> = plan.cells.iter().map(Cell::as_str).collect();
    print_line(&format!("Cells: {}", cells.join(", ")))?;
    print_line(&format!("Zenoh: {}", stack.endpoint()))?;
    if let Some(view) = &view {
        print_line(&view::address(view))?;
    }
    if let Some(domain) = plan.ros {
        print_line(&format!("ROS 2: domain {domain}"))?;
    }
    if let Some(address) = console {
        print_line(&format!("Console: {}", ppnpack_console::url(address)))?;
    }
    print_line("Ready. `ppnpack status` and `ppnpack watch` show what goes on; Ctrl-C ends it.")?;
    stack.shutdown().wait();
    let fault = stack.fault();
    view.map_or(Ok(()), View::finish).or_run()?;
    stack.finish()?;
    match fault {
        Some(fault) => Err(anyhow::Error::msg(fault).into()),
        None => Ok(()),
    }
}

/// Packs one sequence through the services of a cell.
fn packed(
    controller: &Controller,
    catalogue: &Catalogue,
    settings: Settings,
    arm: Option<ArmWork>,
) -> Outcome<Packing> {
    let objects = settings.sequence.objects.iter().enumerate();
    let arrivals = objects.filter_map(|(arrival, index)| {
        let object = catalogue.get(*index)?.item.name().to_string();
        Some(v1::Announcement {
            item_id: stack::report::item_id(arrival),
            shape: Some(v1::announcement::Shape::Object(object)),
            poses: settings.poses,
            ..v1::Announcement::default()
        })
    });
    let items: Vec<v1::Announcement> = arrivals.collect();
    let set_aside = u32::try_from(settings.set_aside).unwrap_or(u32::MAX);
    let bar = progress::bar("Packing", items.len() as u64);
    let started = Instant::now();
    let packed = controller.pack(&items, set_aside, ALTERNATIVES.into(), &mut || bar.inc(1))?;
    bar.finish_and_clear();
    stack::report::packing(settings, catalogue, &packed, arm, started.elapsed()).or_run()
}
