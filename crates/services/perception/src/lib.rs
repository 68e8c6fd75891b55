//! The perception service: takes the point clouds of cells, and gives the container heightmaps that
//! placements are planned on.
//!
//! Each cell has an actor that takes the newest cloud of each of its sensors; those that came
//! before it was ready are dropped and counted. It begins with the cell's first cloud. One more
//! actor answers requests for heightmaps, one says what lies on the cells' trays, and one how items
//! lie that were placed.

mod counts;
mod delay;
mod heightmaps;
mod inspect;
mod objects;
mod order;
mod room;
mod ros;
mod round;
mod router;
mod sensors;
mod settings;
mod tray;
mod worker;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Instant;

use ppnpack_service::actor::{self, Address, LatestValues};
use ppnpack_service::lease::{self, Lease};
use ppnpack_service::process::Process;
use ppnpack_service::rpc::Listener;
use ppnpack_service::stream::{self, Subscription, Unread};
use ppnpack_service::{Running, ServiceError};
use ppnpack_wire::MAX_CLOUD_BYTES;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::v1;
use zenoh::pubsub::Subscriber;

use counts::Counts;
pub use counts::Fate;
use heightmaps::Heightmaps;
use inspect::Inspections;
pub use objects::Objects;
use room::Held;
pub use ros::settings::RosCamera;
use router::Router;
pub use settings::Settings;
pub use tray::settings::TraySettings;
use tray::{Tray, Trays};
use worker::{Outputs, Worker};

/// The running service. Dropped, it ends.
pub struct Perception {
    // Nothing comes any more before the threads end: fields are dropped in this order.
    inputs: Vec<Input>,
    router: Arc<Router>,
    threads: Vec<JoinHandle<()>>,
    counts: Arc<Counts>,
}

/// Takes the clouds and requests of one cell or of all, until it is dropped.
struct Input {
    _lease: Lease,
    _listeners: [Listener; 3],
    _clouds: [Subscription; 2],
    _cameras: Vec<Subscriber<()>>,
}

/// Addresses of those who take clouds and requests.
struct Actors {
    router: Arc<Router>,
    heightmaps: Address<heightmaps::Message>,
    trays: Address<tray::Message>,
    tray_clouds: tray::Clouds,
    inspections: Address<inspect::Message>,
    counts: Arc<Counts>,
}

/// Starts the service with the objects that can be recognised, which cells with trays need. Where
/// another perception serves a cell this waits until that has ended; other cells are served
/// meanwhile.
///
/// # Errors
/// [`ServiceError`] where a cell's name is impossible, or the session or a thread cannot be had.
pub fn start(
    process: &Process,
    settings: &Settings,
    objects: Option<&Objects>,
) -> Result<Perception, ServiceError> {
    let counts = Arc::new(Counts::new());
    let (actors, threads) = start_actors(process, settings, objects, &counts)?;
    let mut perception = Perception {
        inputs: Vec::new(),
        router: Arc::clone(&actors.router),
        threads,
        counts,
    };
    let cells: Vec<Option<Cell>> = match settings.has_unlisted_cells {
        true => vec![None],
        false => {
            let names = settings.cells.keys();
            let cells = names.map(|name| Cell::new(name).map(Some));
            cells.collect::<Result<_, _>>()?
        }
    };
    lease::take_each(process, cells, |cell, lease| {
        let input = Input::new(process, settings, cell, &actors, lease)?;
        perception.inputs.push(input);
        Ok(())
    })?;
    Ok(perception)
}

fn start_actors(
    process: &Process,
    settings: &Settings,
    objects: Option<&Objects>,
    counts: &Arc<Counts>,
) -> Result<(Actors, Vec<JoinHandle<()>>), ServiceError> {
    let most = settings.queue.max(1);
    let (heightmaps, heightmaps_mailbox) = actor::mailbox(most);
    let (trays, trays_mailbox) = actor::mailbox(most);
    let (inspections, inspections_mailbox) = actor::mailbox(inspect::MOST_PENDING);

    let known_trays = known_trays(settings, objects)?;
    let tray_clouds = tray::Clouds::new(&known_trays, &trays, Arc::clone(counts));
    let inspected = LatestValues::new(&inspections);
    let outputs = Outputs {
        heightmaps: heightmaps.clone(),
        // Without objects they are of no use.
        inspected: objects.map(|_| inspected.clone()),
        counts: Arc::clone(counts),
    };
    let router = {
        let (own, of_cells, epoch) = (process.clone(), settings.clone(), rand::random());
        let build = move |cell: &Cell, clouds| {
            Worker::new(&own, &of_cells, cell, epoch, clouds, outputs.clone())
        };
        let supervisor = process.supervisor();
        Arc::new(Router::new(settings, Arc::clone(counts), supervisor, build))
    };
    let answering = Heightmaps::new(Arc::clone(&router), most);
    let looking = Trays::new(known_trays, tray_clouds.clone(), most);
    let inspecting = Inspections::new(objects, settings.inspection, inspected);
    let [of_heightmaps, of_trays, of_inspections] =
        ["heightmaps", "trays", "inspections"].map(|name| format!("perception-{name}"));
    let threads = vec![
        actor::spawn(process, &of_heightmaps, answering, heightmaps_mailbox)?,
        actor::spawn(process, &of_trays, looking, trays_mailbox)?,
        actor::spawn(process, &of_inspections, inspecting, inspections_mailbox)?,
    ];
    let actors = Actors {
        router,
        heightmaps,
        trays,
        tray_clouds,
        inspections,
        counts: Arc::clone(counts),
    };
    Ok((actors, threads))
}

fn known_trays(
    settings: &Settings,
    objects: Option<&Objects>,
) -> Result<BTreeMap<Cell, Tray>, ServiceError> {
    let tray = |(name, tray): (&String, &TraySettings)| {
        let cell = Cell::new(name)?;
        let nothing = || ServiceError::start("trays: there are no objects to recognise");
        let objects = objects.ok_or_else(nothing)?;
        let grid = settings.grid_of(&cell).unwrap_or(&settings.grid).build();
        let resolution = grid.map_err(ServiceError::start)?.resolution().clone();
        Ok((cell, Tray::new(tray, objects, resolution)))
    };
    settings.trays.iter().map(tray).collect()
}

impl Input {
    fn new(
        process: &Process,
        settings: &Settings,
        cell: Option<&Cell>,
        actors: &Actors,
        lease: Lease,
    ) -> Result<Self, ServiceError> {
        let cameras = settings.ros.iter();
        let cameras = cameras.filter(|camera| cell.is_none_or(|cell| camera.cell == cell.as_str()));
        let cameras = cameras.map(|camera| {
            let (router, trays) = (&actors.router, &actors.tray_clouds);
            ros::subscribe(process, camera, router, trays, &actors.counts)
        });
        let (router, tray_clouds) = (Arc::clone(&actors.router), actors.tray_clouds.clone());
        let (heightmaps, inspections) = (&actors.heightmaps, &actors.inspections);
        let listeners = [
            heightmaps.listen(process, cell, heightmaps::Message::Request)?,
            actors.trays.listen(process, cell, |incoming| incoming)?,
            inspections.listen(process, cell, |incoming| incoming)?,
        ];
        let clouds = [
            subscribe(process, cell, Stream::Cloud, &actors.router, {
                move |cell, cloud| router.route(cell, cloud)
            })?,
            subscribe(process, cell, Stream::TrayCloud, &actors.router, {
                move |cell, cloud| tray_clouds.put(cell, cloud)
            })?,
        ];
        Ok(Self {
            _listeners: listeners,
            _clouds: clouds,
            _cameras: cameras.collect::<Result<_, _>>()?,
            _lease: lease,
        })
    }
}

/// Calls `on_cloud` with every cloud of a stream that there is room for.
fn subscribe(
    process: &Process,
    cell: Option<&Cell>,
    stream: Stream,
    router: &Arc<Router>,
    on_cloud: impl Fn(&Cell, Held<v1::PointCloud>) + Send + Sync + 'static,
) -> Result<Subscription, ServiceError> {
    let router = Arc::clone(router);
    let on_unread = move |cell: Cell, unread: Unread<'_, v1::PointCloud>| {
        if let Some(room) = router.room(&cell, unread.bytes())
            && let Some(cloud) = unread.read()
        {
            on_cloud(&cell, room.with(cloud));
        }
    };
    stream::subscribe_unread(process.session(), cell, stream, MAX_CLOUD_BYTES, on_unread)
}

impl Perception {
    /// Counts the clouds that had this fate since the service started.
    pub fn clouds(&self, fate: Fate) -> u64 {
        self.counts.of(fate)
    }

    /// Ends the inputs and the actors of cells.
    fn stop(&mut self) {
        self.inputs.clear();
        self.threads.extend(self.router.close());
    }
}

impl Running for Perception {
    fn finish(mut self: Box<Self>, deadline: Instant) -> Result<(), String> {
        self.stop();
        ppnpack_service::join(std::mem::take(&mut self.threads), deadline)
    }
}

impl Drop for Perception {
    fn drop(&mut self) {
        self.stop();
    }
}
