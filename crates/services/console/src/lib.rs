//! The operator's page: packing cells as they work, in a browser, and controls behind a token.
//!
//! It reads the streams that any viewer reads and makes the requests that any controller makes;
//! nothing depends on it. All streams are folded into one picture of all cells (`picture/`), which
//! is put on a board in parts (`board.rs`); pages get the parts as they change (`web/`). All files
//! of the page are within the program, and nothing is fetched from elsewhere.

mod board;
mod controls;
mod directory;
mod follow;
mod look;
mod page;
mod picture;
mod settings;
mod shapes;
mod web;

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use ppnpack_service::actor::{self, Address, LatestValues};
use ppnpack_service::rpc::Client;
use ppnpack_service::stream::Subscription;
use ppnpack_service::{HealthLatch, Process, Running, ServiceError, Shutdown, alive, join};
use ppnpack_wire::keys::Cell;
use serde_json::json;
use tokio::runtime::Runtime;

use board::Board;
use controls::Controls;
use directory::Directory;
use follow::{Follower, FollowerMessage, Inboxes};
use look::{HealthPoller, StatePoller};
use settings::NO_TOKEN;
pub use settings::Settings;
use shapes::{Prefetcher, ShapeStore};
use web::{Access, BLOCKING_THREADS, Limits, Served};

/// Maximum of messages that wait for the follower.
const QUEUE: usize = 256;

/// Maximum of records whose shapes wait to be asked for.
const WANTED: usize = 16;

const GRACE: Duration = Duration::from_secs(1);

/// The page, served until it is told to end.
pub struct Console {
    // Nothing is heard any more before the threads end: fields are dropped in this order.
    alive: alive::Token,
    following: Following,
    shutdown: Shutdown,
    runtime: Runtime,
    address: SocketAddr,
    _ready: HealthLatch,
}

/// Serves the page.
///
/// # Errors
/// [`ServiceError`] where its address or its token is not to be had, the session is closed, or
/// there can be no more threads.
pub fn start(process: &Process, settings: &Settings) -> Result<Console, ServiceError> {
    let ready = process.health().check("page");
    let token = settings.read_token().map_err(ServiceError::start)?;
    let board = Arc::new(Board::default());
    let part = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "instance": process.instance().as_str(),
        "started_ms": now_ms(),
        "controls": token.is_some(),
        "why_off": token.is_none().then_some(NO_TOKEN),
    });
    board.put((None, None, "console"), part);
    let directory = Arc::new(Directory::begun());
    let client = Client::new(process.session());
    let shapes = Arc::new(ShapeStore::new(client.clone(), Arc::clone(&directory)));
    let shutdown = process.shutdown().of_part();
    let cells = settings.cell_names().map_err(ServiceError::start)?;
    let following = follow(process, &cells, &board, &directory, &shapes, &shutdown)?;
    // One thread sends to all pages: the cores are the planner's.
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .max_blocking_threads(BLOCKING_THREADS)
        .thread_name("console")
        .enable_all()
        .build()
        .map_err(|source| ServiceError::System {
            what: "starting the page's threads",
            source,
        })?;
    let served = Served {
        board,
        controls: Controls::new(client.clone(), Arc::clone(&directory)),
        directory,
        shapes,
        client,
        access: Access::new(token.as_ref(), &settings.hosts),
        limits: Limits::default(),
        shutdown: shutdown.clone(),
    };
    let address = web::serve(runtime.handle(), settings.listen, served)?;
    let alive = alive::announce(process, None)?;
    ready.pass();
    tracing::info!(
        url = url(address),
        controls = token.is_some(),
        "the page is served"
    );
    Ok(Console {
        alive,
        following,
        shutdown,
        runtime,
        address,
        _ready: ready,
    })
}

/// Gives the time of day, in milliseconds since 1970.
fn now_ms() -> u64 {
    ppnpack_service::clock::now_ns() / 1_000_000
}

/// Gives the URL of the page that is served at an address.
pub fn url(address: SocketAddr) -> String {
    format!("http://{address}")
}

struct Following {
    subscriptions: Vec<Subscription>,
    follower: Address<FollowerMessage>,
    threads: Vec<JoinHandle<()>>,
}

/// Follows these cells from now on, or all where none is named, until it is told to end.
fn follow(
    process: &Process,
    cells: &[Cell],
    board: &Arc<Board>,
    directory: &Arc<Directory>,
    shapes: &Arc<ShapeStore>,
    shutdown: &Shutdown,
) -> Result<Following, ServiceError> {
    let (follower, heard) = actor::mailbox(QUEUE);
    let (prefetcher, wanted) = actor::mailbox(WANTED);
    let (asker, to_ask) = actor::mailbox(1);
    let inboxes = Inboxes {
        newest: LatestValues::new(&follower),
        heightmaps: LatestValues::new(&follower),
        follower: follower.clone(),
    };
    let health = HealthPoller {
        session: process.session().clone(),
        cells: cells.to_vec(),
        directory: Arc::clone(directory),
        asker,
        shutdown: shutdown.clone(),
    };
    let states = StatePoller {
        client: Client::new(process.session()),
        directory: Arc::clone(directory),
        newest: inboxes.newest.clone(),
        heightmaps: inboxes.heightmaps.clone(),
        asked: BTreeMap::new(),
    };
    let prefetching = Prefetcher {
        store: Arc::clone(shapes),
    };
    let (board, directory) = (Arc::clone(board), Arc::clone(directory));
    let following = Follower::new(board, directory, &inboxes, prefetcher);
    let supervisor = process.supervisor();
    Ok(Following {
        subscriptions: inboxes.hear(process.session(), cells)?,
        follower,
        threads: vec![
            actor::spawn(process, "console-cells", following, heard)?,
            actor::spawn(process, "console-shapes", prefetching, wanted)?,
            actor::spawn(process, "console-asks", states, to_ask)?,
            supervisor.thread("console-looks", move || health.run())?,
        ],
    })
}

impl Console {
    /// Gives the address that the page is served at.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Running for Console {
    fn finish(self: Box<Self>, deadline: Instant) -> Result<(), String> {
        self.shutdown.request();
        self.runtime.shutdown_timeout(GRACE);
        // Without these nobody has the follower's address, nor it the others': threads end as their
        // mailboxes are empty.
        let following = self.following;
        drop((self.alive, following.subscriptions, following.follower));
        join(following.threads, deadline)
    }
}
