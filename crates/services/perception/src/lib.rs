//! The perception service: takes the point clouds of cells, and gives the container heightmaps that placements are
//! planned on.
//!
//! Each cell has a thread that takes the newest cloud of each of its sensors; those that came before it was ready are
//! dropped and counted. One more thread answers requests for heightmaps.

mod counts;
mod desk;
mod doubts;
mod order;
mod ros;
mod round;
mod router;
mod sensors;
mod settings;
mod slot;
mod streams;
mod worker;

use std::sync::Arc;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::Instant;

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
pub use ros::RosCamera;
use router::Router;
pub use settings::{GridSettings, Settings};

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
    /// The thread that answers requests cannot be started.
    #[error("the thread that answers requests cannot be started: {0}")]
    Thread(std::io::Error),
}

/// The running service. Dropped, it ends.
pub struct Perception {
    // Nothing comes any more before the threads end: fields are dropped in this order.
    doors: Vec<Door>,
    cameras: Vec<ros::Door>,
    router: Arc<Router>,
    desk: Option<JoinHandle<()>>,
    counts: Arc<Counts>,
}

/// Where clouds and requests come in, of one cell or of all.
struct Door {
    _alive: alive::Token,
    _requests: Listener,
    _clouds: Subscription,
}

/// Starts the service.
///
/// # Errors
/// [`StartError`] where a cell's name is impossible, or the session or a thread cannot be had.
pub fn start(process: &Process, settings: &Settings) -> Result<Perception, StartError> {
    let (mailbox, mail) = sync_channel(settings.queue.max(1));
    let counts = Arc::new(Counts::new());
    let router = Router::new(process, settings, mailbox.clone(), Arc::clone(&counts));
    let router = Arc::new(router);
    let desk = Desk::new(Arc::clone(&router), settings.queue.max(1));
    let desk = std::thread::Builder::new()
        .name("perception-desk".to_owned())
        .spawn(move || desk.run(&mail))
        .map_err(StartError::Thread)?;
    let mut doors = Vec::new();
    if settings.has_unlisted_cells {
        doors.push(Door::open(process, None, &router, &mailbox)?);
    } else {
        for name in settings.cells.keys() {
            let cell = Cell::new(name)?;
            doors.push(Door::open(process, Some(&cell), &router, &mailbox)?);
        }
    }
    let open = |camera: &RosCamera| ros::Door::open(process, camera, &router, &counts);
    let cameras = settings.ros.iter().map(open).collect::<Result<_, _>>()?;
    Ok(Perception {
        doors,
        cameras,
        router,
        desk: Some(desk),
        counts,
    })
}

impl Door {
    fn open(
        process: &Process,
        cell: Option<&Cell>,
        router: &Arc<Router>,
        mailbox: &SyncSender<Mail>,
    ) -> Result<Self, ServiceError> {
        let mailbox = mailbox.clone();
        let router = Arc::clone(router);
        Ok(Self {
            _requests: rpc::listen(process, cell, move |incoming: Incoming<_>| {
                rpc::deliver(&mailbox, incoming, Mail::Request);
            })?,
            _clouds: stream::subscribe(
                process,
                cell,
                Stream::Cloud,
                MAX_CLOUD_BYTES,
                move |cell, cloud: v1::PointCloud| router.route(&cell, cloud),
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
        threads.extend(self.desk.take());
        ppnpack_service::join(threads, deadline)
    }
}

impl Drop for Perception {
    fn drop(&mut self) {
        self.close_doors();
        self.router.close();
    }
}
