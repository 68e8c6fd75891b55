//! The page and what it asks, over HTTP.

mod access;
mod control;
mod events;
mod failure;
mod files;
mod listener;
mod looks;

use std::net::SocketAddr;
use std::sync::Arc;

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::middleware;
use axum::routing::{get, post};
use ppnpack_service::rpc::Client;
use ppnpack_service::{ServiceError, Shutdown};
use ppnpack_wire::keys::Cell;
use tokio::net::TcpListener;
use tokio::runtime::Handle;
use tokio::sync::Semaphore;

use crate::board::Board;
use crate::controls::Controls;
use crate::directory::Directory;
use crate::shapes::ShapeStore;
pub(crate) use access::Access;
use failure::Failure;

const MOST_BODY_BYTES: usize = 16 << 10;

const MOST_PAGES: usize = 32;

/// Maximum of shapes that are asked for at the same time.
const MOST_SHAPES: usize = 8;

/// Maximum of controls that are carried out at the same time; those that stop a robot have as many
/// of their own.
const MOST_CONTROLS: usize = 8;

/// Maximum of threads that all of these take together, with the one that explains.
pub(crate) const BLOCKING_THREADS: usize = MOST_SHAPES + 2 * MOST_CONTROLS + 1;

pub(crate) struct Served {
    pub(crate) board: Arc<Board>,
    pub(crate) directory: Arc<Directory>,
    pub(crate) shapes: Arc<ShapeStore>,
    pub(crate) controls: Controls,
    pub(crate) client: Client,
    pub(crate) access: Access,
    pub(crate) limits: Limits,
    pub(crate) shutdown: Shutdown,
}

/// Limits on how much of each is done at the same time.
pub(crate) struct Limits {
    pages: Arc<Semaphore>,
    shapes: Arc<Semaphore>,
    explaining: Arc<Semaphore>,
    controls: Semaphore,
    stops: Semaphore,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            pages: Arc::new(Semaphore::new(MOST_PAGES)),
            shapes: Arc::new(Semaphore::new(MOST_SHAPES)),
            explaining: Arc::new(Semaphore::new(1)),
            controls: Semaphore::new(MOST_CONTROLS),
            stops: Semaphore::new(MOST_CONTROLS),
        }
    }
}

/// Serves the page at an address from now on. Gives the address, with the port that the system
/// chose.
///
/// # Errors
/// [`ServiceError::Start`] where it cannot be listened on.
pub(crate) fn serve(
    runtime: &Handle,
    address: SocketAddr,
    served: Served,
) -> Result<SocketAddr, ServiceError> {
    let failed = |error| {
        ServiceError::start(format_args!(
            "{address} cannot be listened on: {error}; set service.listen (of `ppnpack up`, --console) to a free one"
        ))
    };
    let listener = runtime
        .block_on(TcpListener::bind(address))
        .map_err(failed)?;
    let address = listener.local_addr().map_err(failed)?;
    let router = router(Arc::new(served));
    runtime.spawn(listener::serve(listener, router, listener::MOST_HEAD));
    Ok(address)
}

fn router(served: Arc<Served>) -> Router {
    Router::new()
        .route("/", get(files::index))
        .route("/{file}", get(files::named))
        .route("/api/state", get(events::state))
        .route("/api/events", get(events::events))
        .route("/api/cells/{cell}/shapes/{id}", get(looks::shape))
        .route("/api/cells/{cell}/explain/{item_id}", get(looks::explain))
        .route("/api/control/{action}", post(control::control))
        .fallback(files::missing)
        .method_not_allowed_fallback(files::other_method)
        .layer(DefaultBodyLimit::max(MOST_BODY_BYTES))
        .layer(middleware::from_fn_with_state(
            Arc::clone(&served),
            access::guard,
        ))
        .with_state(served)
}

/// Waits for work on a thread that may wait for services.
async fn waited<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Failure> {
    let done = tokio::task::spawn_blocking(work).await;
    done.map_err(|_| Failure::lost())
}

impl Served {
    /// Gives a cell that there is, by its name.
    fn cell(&self, name: &str) -> Result<Cell, Failure> {
        let cell = Cell::new(name).ok();
        let known = cell.filter(|cell| self.directory.has(cell));
        known.ok_or_else(|| Failure::unknown_cell(name))
    }
}
