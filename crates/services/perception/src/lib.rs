//! The perception service: takes the point clouds of cells, and gives the container heightmaps that placements are
//! planned on.
//!
//! Each cell has a thread that takes the newest cloud of each of its sensors; those that came before it was ready are
//! dropped and counted. One more thread answers requests for heightmaps, one says what lies on the cells' trays,
//! and one how items lie that were placed.

mod counts;
mod desk;
mod doubts;
mod inspect;
mod order;
mod ros;
mod round;
mod router;
mod sensors;
mod settings;
mod slot;
mod streams;
mod tray;
mod waiting;
mod worker;

use std::sync::Arc;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::Instant;

use ppnpack_packing::grid::GridError;
use ppnpack_recognition::library::Library;
use ppnpack_service::process::Process;
use ppnpack_service::rpc::{self, Incoming, Listener};
use ppnpack_service::stream::{self, Subscription};
use ppnpack_service::{Running, ServiceError, alive};
use ppnpack_wire::MAX_CLOUD_BYTES;
use ppnpack_wire::keys::{Cell, KeyError, Stream};
use ppnpack_wire::v1;

use counts::Counts;
pub use counts::Fate;
use desk::{Desk, Mail};
use inspect::Inspections;
pub use ros::RosCamera;
use router::Router;
pub use settings::Settings;
pub use tray::TraySettings;
use tray::{Tray, Trays};

/// Why the service did not start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StartError {
    /// The process lacks something.
    #[error(transparent)]
    Service(#[from] ServiceError),
    /// A cell has an impossible name.
    #[error(transparent)]
    Cell(#[from] KeyError),
    /// A camera of ROS 2 cannot be as it is set.
    #[error("ros: {0}")]
    Ros(String),
    /// A grid is not possible.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// There are trays, but nothing is known that could lie there.
    #[error("trays: there are no objects to recognise")]
    NoLibrary,
    /// A thread that answers requests cannot be started.
    #[error("a thread that answers requests cannot be started: {0}")]
    Thread(std::io::Error),
}

/// The running service. Dropped, it ends.
pub struct Perception {
    // Nothing comes any more before the threads end: fields are dropped in this order.
    doors: Vec<Door>,
    cameras: Vec<ros::Door>,
    router: Arc<Router>,
    threads: Vec<JoinHandle<()>>,
    counts: Arc<Counts>,
}

/// Where clouds and requests come in, of one cell or of all.
struct Door {
    _alive: alive::Token,
    _requests: Vec<Listener>,
    _clouds: Subscription,
    _tray_clouds: Subscription,
}

/// Where what comes in goes.
struct Inside {
    router: Arc<Router>,
    heightmaps: SyncSender<Mail>,
    items: SyncSender<tray::Mail>,
    inspections: SyncSender<inspect::Mail>,
    tray_clouds: tray::Inlet,
}

/// Starts the service; `library` has the objects that can be recognised, which cells with trays need.
///
/// # Errors
/// [`StartError`] where a cell's name is impossible, or the session or a thread cannot be had.
pub fn start(
    process: &Process,
    settings: &Settings,
    library: Option<&Arc<Library>>,
) -> Result<Perception, StartError> {
    let most = settings.queue.max(1);
    let (heightmaps, mail) = sync_channel(most);
    let (items, tray_mail) = sync_channel(most);
    let counts = Arc::new(Counts::new());
    let (inspections, inspection_mail) = sync_channel(inspect::MOST_WAITING);
    let inspector = Inspections::new(library, settings.inspection);
    let inspected = inspector.inlet(inspections.clone());
    let router = Router::new(
        process,
        settings,
        heightmaps.clone(),
        inspected,
        Arc::clone(&counts),
    );
    let router = Arc::new(router);
    let desk = Desk::new(Arc::clone(&router), most);
    let trays = Trays::new(trays(settings, library)?, most, Arc::clone(&counts));
    let inside = Inside {
        router: Arc::clone(&router),
        heightmaps,
        inspections,
        tray_clouds: tray::Inlet::new(&trays, items.clone()),
        items,
    };
    let threads = vec![
        spawn("perception-desk", move || desk.run(&mail))?,
        spawn("perception-trays", move || trays.run(&tray_mail))?,
        spawn("perception-inspections", move || {
            inspector.run(&inspection_mail);
        })?,
    ];
    let mut doors = Vec::new();
    if settings.has_unlisted_cells {
        doors.push(Door::open(process, None, &inside)?);
    } else {
        for name in settings.cells.keys() {
            let cell = Cell::new(name)?;
            doors.push(Door::open(process, Some(&cell), &inside)?);
        }
    }
    let open = |camera: &RosCamera| ros::Door::open(process, camera, &router, &counts);
    let cameras = settings.ros.iter().map(open).collect::<Result<_, _>>()?;
    Ok(Perception {
        doors,
        cameras,
        router,
        threads,
        counts,
    })
}

/// The trays that are set.
fn trays(settings: &Settings, library: Option<&Arc<Library>>) -> Result<Vec<Tray>, StartError> {
    let tray = |(name, tray): (&String, &TraySettings)| {
        let cell = Cell::new(name)?;
        let library = library.ok_or(StartError::NoLibrary)?;
        let grid = settings.grid_of(&cell).unwrap_or(&settings.grid).build()?;
        let resolution = grid.resolution().clone();
        Ok(Tray::new(cell, tray, library, resolution))
    };
    settings.trays.iter().map(tray).collect()
}

fn spawn(name: &str, work: impl FnOnce() + Send + 'static) -> Result<JoinHandle<()>, StartError> {
    std::thread::Builder::new()
        .name(name.to_owned())
        .spawn(work)
        .map_err(StartError::Thread)
}

impl Door {
    fn open(process: &Process, cell: Option<&Cell>, inside: &Inside) -> Result<Self, ServiceError> {
        let (heightmaps, items) = (inside.heightmaps.clone(), inside.items.clone());
        let (router, tray_clouds) = (Arc::clone(&inside.router), inside.tray_clouds.clone());
        let inspections = inside.inspections.clone();
        let requests = vec![
            rpc::listen(process, cell, move |incoming: Incoming<_>| {
                rpc::deliver(&heightmaps, incoming, Mail::Request);
            })?,
            rpc::listen(process, cell, move |incoming: Incoming<_>| {
                rpc::deliver(&items, incoming, tray::Mail::request);
            })?,
            rpc::listen(process, cell, move |incoming: Incoming<_>| {
                rpc::deliver(&inspections, incoming, inspect::Mail::request);
            })?,
        ];
        Ok(Self {
            _requests: requests,
            _clouds: stream::subscribe(
                process,
                cell,
                Stream::Cloud,
                MAX_CLOUD_BYTES,
                move |cell, cloud: v1::PointCloud| router.route(&cell, cloud),
            )?,
            _tray_clouds: stream::subscribe(
                process,
                cell,
                Stream::TrayCloud,
                MAX_CLOUD_BYTES,
                move |cell, cloud: v1::PointCloud| tray_clouds.put(&cell, cloud),
            )?,
            _alive: alive::announce(process, cell)?,
        })
    }
}

impl Perception {
    /// How many clouds had this fate since the service started.
    pub fn clouds(&self, fate: Fate) -> u64 {
        self.counts.of(fate)
    }

    /// Nothing comes any more.
    fn close_doors(&mut self) {
        self.doors.clear();
        self.cameras.clear();
    }
}

impl Running for Perception {
    fn finish(mut self: Box<Self>, deadline: Instant) -> Result<(), String> {
        self.close_doors();
        let mut threads = self.router.close();
        threads.append(&mut self.threads);
        ppnpack_service::join(threads, deadline)
    }
}

impl Drop for Perception {
    fn drop(&mut self) {
        self.close_doors();
        self.router.close();
    }
}
