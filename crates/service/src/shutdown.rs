//! The wish that the process ends: asked once, seen by all.

use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::watch;

/// The wish that the process ends. Clones share it.
#[derive(Debug, Clone, Default)]
pub struct Shutdown {
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    is_requested: Mutex<bool>,
    changed: Condvar,
    sender: watch::Sender<bool>,
}

impl Shutdown {
    /// Asks for the end. Asking again changes nothing.
    pub fn request(&self) {
        *self.lock() = true;
        self.shared.changed.notify_all();
        self.shared.sender.send_replace(true);
    }

    /// Whether the end was asked for.
    pub fn is_requested(&self) -> bool {
        *self.lock()
    }

    /// Waits until the end is asked for.
    pub fn wait(&self) {
        let is_requested = self.lock();
        drop(
            self.shared
                .changed
                .wait_while(is_requested, |is_requested| !*is_requested)
                .unwrap_or_else(PoisonError::into_inner),
        );
    }

    /// Waits until the end is asked for, at most so long; says whether it was.
    pub fn wait_timeout(&self, duration: Duration) -> bool {
        let is_requested = self.lock();
        let (is_requested, _) = self
            .shared
            .changed
            .wait_timeout_while(is_requested, duration, |is_requested| !*is_requested)
            .unwrap_or_else(PoisonError::into_inner);
        *is_requested
    }

    /// Waits until the end is asked for.
    pub async fn requested(&self) {
        let mut receiver = self.shared.sender.subscribe();
        // The sender lives as long as `self`, so this ends only when asked for.
        receiver.wait_for(|is_requested| *is_requested).await.ok();
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, bool> {
        self.shared
            .is_requested
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_seen_by_all() {
        let shutdown = Shutdown::default();
        assert!(!shutdown.wait_timeout(Duration::ZERO));
        let waiting = shutdown.clone();
        let thread = std::thread::spawn(move || waiting.wait());
        shutdown.request();
        thread.join().unwrap();
        assert!(shutdown.is_requested() && shutdown.wait_timeout(Duration::from_secs(60)));
        let runtime = tokio::runtime::Builder::new_current_thread()
            .build()
            .unwrap();
        runtime.block_on(shutdown.requested());
    }
}
