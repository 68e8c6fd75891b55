//! Packing cells as they work, served to [Foxglove](https://foxglove.dev) over its WebSocket
//! protocol.
//!
//! There is a channel for each stream of each cell, such as `/cell-1/plan`, and `/all/health` for
//! all cells. `/cell-1/planned_scene` has the meshes of what the last step was planned on, what was
//! chosen, what would have been next, and the arm with its way as lines.
//!
//! A stream is subscribed only while somebody looks at its channel: with no viewer nothing is read,
//! and planners make no records. A viewer that does not read loses the oldest messages of its own
//! queue, and holds nobody else up.

mod arm;
mod cells;
mod channels;
mod draw;
mod drawings;
mod error;
mod scene;

use std::net::SocketAddr;
use std::thread::JoinHandle;
use std::time::Duration;

use foxglove::{Context, WebSocketServer, WebSocketServerHandle};
use ppnpack_service::Shutdown;
use ppnpack_service::process::thread;
use tokio::runtime::Runtime;
use zenoh::Session;

use cells::Cells;
pub use error::ViewError;
pub use scene::PlannedScenes;

/// Maximum of messages that wait for a viewer; older ones are dropped then.
const BACKLOG: usize = 64;

/// How often it is looked for viewers of channels.
const LOOK: Duration = Duration::from_millis(100);

const GRACE: Duration = Duration::from_secs(2);

/// The cells, served to viewers until it is told to end.
pub struct View {
    server: WebSocketServerHandle,
    runtime: Runtime,
    address: SocketAddr,
    shutdown: Shutdown,
    thread: JoinHandle<Result<(), ViewError>>,
}

impl View {
    /// Serves the cells at an address; port 0 is one of the system's choice.
    ///
    /// # Errors
    /// [`ViewError`] where it cannot listen there, or the session is closed.
    pub fn start(session: &Session, address: SocketAddr) -> Result<Self, ViewError> {
        // One thread sends to all viewers: the cores are the planner's.
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .thread_name("view")
            .enable_all()
            .build()
            .map_err(|error| ViewError::Thread(error.to_string()))?;
        let context = Context::new();
        let server = WebSocketServer::new()
            .name("ppnpack")
            .context(&context)
            .bind(address.ip().to_string(), address.port())
            .message_backlog_size(BACKLOG)
            .tokio_runtime(runtime.handle());
        let server = runtime.block_on(server.start());
        let server = server.map_err(|error| ViewError::Listen {
            address,
            reason: error.to_string(),
        })?;
        let address = SocketAddr::new(address.ip(), server.port());
        let shutdown = Shutdown::default();
        let cells = Cells::new(session, context)?;
        let thread = {
            let shutdown = shutdown.clone();
            thread("view-cells", move || follow(cells, &shutdown))?
        };
        Ok(Self {
            server,
            runtime,
            address,
            shutdown,
            thread,
        })
    }

    /// Gives the address that viewers connect to.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// How many viewers are connected.
    pub fn viewers(&self) -> usize {
        self.server.client_count()
    }

    /// Whether it has ended by itself: [`Self::finish`] gives the reason.
    pub fn has_ended(&self) -> bool {
        self.thread.is_finished()
    }

    /// Ends it.
    ///
    /// # Errors
    /// [`ViewError`] where it has ended by itself: the reason.
    pub fn finish(self) -> Result<(), ViewError> {
        self.shutdown.request();
        let lost = |_| ViewError::Thread("it ended by a panic".to_owned());
        let ended = self.thread.join().map_err(lost)?;
        drop(self.server.stop());
        self.runtime.shutdown_timeout(GRACE);
        ended
    }
}

fn follow(mut cells: Cells, shutdown: &Shutdown) -> Result<(), ViewError> {
    while !shutdown.wait_timeout(LOOK) {
        cells.advance()?;
    }
    Ok(())
}
