//! The wish that the process ends: asked once, seen by all.

use std::sync::{Arc, Condvar, Mutex, PoisonError, Weak};
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
    /// The wishes of parts, which are made with it.
    parts: Mutex<Vec<Weak<Self>>>,
}

impl Shared {
    fn request(&self) {
        // No part is added after this that does not see it.
        let parts = {
            let mut parts = lock(&self.parts);
            *lock(&self.is_requested) = true;
            std::mem::take(&mut *parts)
        };
        self.changed.notify_all();
        for part in parts.iter().filter_map(Weak::upgrade) {
            part.request();
        }
    }
}

impl Shutdown {
    /// Asks for the end. Asking again changes nothing.
    pub fn request(&self) {
        self.shared.request();
    }

    /// Makes the wish of a part: its end is asked for with this one, or alone.
    #[must_use]
    pub fn of_part(&self) -> Self {
        let part = Self::default();
        let mut parts = lock(&self.shared.parts);
        parts.retain(|part| part.strong_count() > 0);
        if self.is_requested() {
            part.request();
        } else {
            parts.push(Arc::downgrade(&part.shared));
        }
        part
    }

    /// Says whether the end was asked for.
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

    #[test]
    fn a_part_ends_alone_or_with_the_whole() {
        let whole = Shutdown::default();
        let (one, other) = (whole.of_part(), whole.of_part());
        one.request();
        assert!(one.is_requested() && !other.is_requested() && !whole.is_requested());
        let waiting = other.clone();
        let thread = std::thread::spawn(move || waiting.wait());
        whole.request();
        thread.join().unwrap();
        assert!(other.is_requested() && whole.of_part().is_requested());
    }
}
