//! The cells as they work, served to Foxglove by the planner itself where its settings say so.

use std::net::SocketAddr;
use std::thread::JoinHandle;
use std::time::Duration;

use ppnpack_service::process::Process;
use ppnpack_service::{ServiceError, Shutdown};
use ppnpack_view::View;

/// How often it is looked whether it is still served.
const LOOK: Duration = Duration::from_millis(200);

/// What viewers are served by.
pub(crate) struct Viewing {
    /// Where viewers connect.
    pub(crate) address: SocketAddr,
    shutdown: Shutdown,
    thread: JoinHandle<()>,
}

impl Viewing {
    /// Serves what the planner may read. Cells are packed on where it ends by itself.
    pub(crate) fn start(process: &Process, address: SocketAddr) -> Result<Self, ServiceError> {
        let view = View::start(process.session(), address).map_err(ServiceError::start)?;
        let address = view.address();
        tracing::info!(%address, "viewers connect here");
        let shutdown = process.shutdown().of_part();
        let asked = shutdown.clone();
        let thread = process
            .supervisor()
            .thread("viewing", move || follow(view, &asked))?;
        Ok(Self {
            address,
            shutdown,
            thread,
        })
    }

    /// Ends it; the thread is one to wait for.
    pub(crate) fn end(self) -> JoinHandle<()> {
        self.shutdown.request();
        self.thread
    }
}

/// Keeps the view until it is told to end, or has ended by itself.
fn follow(view: View, shutdown: &Shutdown) {
    while !view.has_ended() && !shutdown.wait_timeout(LOOK) {}
    if let Err(error) = view.finish() {
        tracing::error!(%error, "viewers are not served any more");
    }
}
