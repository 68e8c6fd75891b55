//! The wish that the process ends: asked once, seen by all.

use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use crate::sync::lock;

/// The wish that the process ends. Clones share it.
#[derive(Debug, Clone, Default)]
pub struct Shutdown {
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    is_requested: Mutex<bool>,
    changed: Condvar,
}

impl Shutdown {
    /// Asks for the end. Asking again changes nothing.
    pub fn request(&self) {
        *lock(&self.shared.is_requested) = true;
        self.shared.changed.notify_all();
    }

    /// Whether the end was asked for.
    pub fn is_requested(&self) -> bool {
        *lock(&self.shared.is_requested)
    }

    /// Waits until the end is asked for.
    pub fn wait(&self) {
        let is_requested = lock(&self.shared.is_requested);
        let waited = self.shared.changed.wait_while(is_requested, |it| !*it);
        drop(waited.unwrap_or_else(PoisonError::into_inner));
    }

    /// Waits until the end is asked for, at most so long; says whether it was.
    pub fn wait_timeout(&self, duration: Duration) -> bool {
        let is_requested = lock(&self.shared.is_requested);
        let changed = &self.shared.changed;
        let waited = changed.wait_timeout_while(is_requested, duration, |it| !*it);
        *waited.unwrap_or_else(PoisonError::into_inner).0
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
    }
}
