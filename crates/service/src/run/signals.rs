//! SIGTERM and SIGINT.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use tokio::runtime::Runtime;
use tokio::signal::unix::{Signal, SignalKind, signal};

use crate::error::ServiceError;
use crate::shutdown::Shutdown;

/// Exit code after a second signal.
const EXIT_IMPATIENT: i32 = 1;

/// Asks for the end at the first signal; ends at once at the second.
pub(super) fn watch(runtime: &Runtime, shutdown: &Shutdown) -> Result<(), ServiceError> {
    let failed = |source| ServiceError::System {
        what: "listening for signals",
        source,
    };
    let _context = runtime.enter();
    let terminate = signal(SignalKind::terminate()).map_err(failed)?;
    let interrupt = signal(SignalKind::interrupt()).map_err(failed)?;
    let is_second = Arc::new(AtomicBool::new(false));
    for signal in [terminate, interrupt] {
        runtime.spawn(wait(signal, shutdown.clone(), is_second.clone()));
    }
    Ok(())
}

async fn wait(mut signal: Signal, shutdown: Shutdown, is_second: Arc<AtomicBool>) {
    while signal.recv().await.is_some() {
        if is_second.swap(true, Ordering::Relaxed) {
            tracing::warn!("a second signal: ending at once");
            std::process::exit(EXIT_IMPATIENT);
        }
        shutdown.request();
    }
}
