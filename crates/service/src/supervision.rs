//! What ends a process that cannot go on: a thread that ended by a panic or does not come back, a session that was closed. A
//! process that lives on with a part of it dead looks ready to everybody and serves nobody; one that ends is started again.

use std::sync::{Arc, Mutex, Weak};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::error::ServiceError;
use crate::process::thread;
use crate::shutdown::Shutdown;
use crate::sync::lock;

/// Whoever works longer than this on one message does not come back: requests may take ten minutes at most.
const LONGEST_WORK: Duration = Duration::from_secs(20 * 60);

/// Watches the threads of a process. Clones share it.
#[derive(Debug, Clone)]
pub struct Supervisor {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    shutdown: Shutdown,
    fault: Mutex<Option<String>>,
    /// Held by those who keep the process.
    kept: Arc<()>,
    pulses: Mutex<Vec<Weak<Pulse>>>,
}

impl Supervisor {
    /// The supervisor of a process, which ends where this is requested.
    pub fn new(shutdown: Shutdown) -> Self {
        Self {
            shared: Arc::new(Shared {
                shutdown,
                fault: Mutex::default(),
                kept: Arc::default(),
                pulses: Mutex::default(),
            }),
        }
    }

    /// Keeps the process, until the guard is dropped, from ending for want of a router: for who does
    /// what cannot be broken off.
    #[must_use]
    pub fn keep(&self) -> Kept {
        Kept {
            _counted: Arc::clone(&self.shared.kept),
        }
    }

    /// Whether somebody keeps the process.
    pub(crate) fn is_kept(&self) -> bool {
        Arc::strong_count(&self.shared.kept) > 1
    }

    /// Ends the process, which fails for this reason; of several the first stays.
    pub fn give_up(&self, fault: String) {
        tracing::error!(fault, "the process ends, to begin anew");
        lock(&self.shared.fault).get_or_insert(fault);
        self.shared.shutdown.request();
    }

    /// Why the process ends, where it does not as it was asked to.
    pub fn fault(&self) -> Option<String> {
        lock(&self.shared.fault).clone()
    }

    /// Sees whether everybody who works comes back.
    pub(crate) fn look(&self) {
        let mut pulses = lock(&self.shared.pulses);
        pulses.retain(|pulse| pulse.strong_count() > 0);
        let alive: Vec<Arc<Pulse>> = pulses.iter().filter_map(Weak::upgrade).collect();
        drop(pulses);
        if let Some(stuck) = alive.iter().find(|pulse| pulse.is_stuck(LONGEST_WORK)) {
            let minutes = LONGEST_WORK.as_secs() / 60;
            let name = &stuck.name;
            self.give_up(format!(
                "{name} has worked on one thing for {minutes} minutes"
            ));
        }
    }

    /// Starts a thread that the process cannot do without: it ends where that ends by a panic.
    ///
    /// # Errors
    /// [`ServiceError::System`] where there can be no more threads.
    pub fn thread<T: Send + 'static>(
        &self,
        name: &str,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<JoinHandle<T>, ServiceError> {
        let guard = self.guard(name);
        thread(name, move || {
            let _guard = guard;
            work()
        })
    }

    fn guard(&self, name: &str) -> Guard {
        Guard {
            supervisor: self.clone(),
            name: name.to_owned(),
        }
    }

    /// Whose work is watched: whoever never comes back from it ends the process.
    pub fn watched(&self) -> Vec<String> {
        let pulses = lock(&self.shared.pulses);
        let alive = pulses.iter().filter_map(Weak::upgrade);
        alive.map(|pulse| pulse.name.clone()).collect()
    }

    /// Tells whether somebody works.
    pub(crate) fn pulse(&self, name: &str) -> Arc<Pulse> {
        let pulse = Arc::new(Pulse {
            name: name.to_owned(),
            busy_since: Mutex::default(),
        });
        lock(&self.shared.pulses).push(Arc::downgrade(&pulse));
        pulse
    }
}

/// Keeps a process, until it is dropped.
#[derive(Debug)]
pub struct Kept {
    _counted: Arc<()>,
}

/// Held by a thread: ends the process where that ends by a panic.
struct Guard {
    supervisor: Supervisor,
    name: String,
}

impl Drop for Guard {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let name = &self.name;
            self.supervisor
                .give_up(format!("the thread {name} ended by a panic"));
        }
    }
}

/// Whether somebody works on a message, and since when.
#[derive(Debug)]
pub(crate) struct Pulse {
    name: String,
    busy_since: Mutex<Option<Instant>>,
}

impl Pulse {
    /// Something is worked on from now.
    pub(crate) fn begin(&self) {
        *lock(&self.busy_since) = Some(Instant::now());
    }

    /// Nothing is worked on.
    pub(crate) fn rest(&self) {
        *lock(&self.busy_since) = None;
    }

    fn is_stuck(&self, longest: Duration) -> bool {
        lock(&self.busy_since).is_some_and(|since| since.elapsed() > longest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_ends_the_process_and_an_end_as_planned_does_not() {
        let shutdown = Shutdown::default();
        let supervisor = Supervisor::new(shutdown.clone());
        let planned = supervisor.thread("planned", || 7).unwrap();
        assert_eq!(planned.join().unwrap(), 7);
        assert!(!shutdown.is_requested() && supervisor.fault().is_none());
        for name in ["first", "second"] {
            let fails = || panic!("as the test asked for");
            let thread = supervisor.thread(name, fails).unwrap();
            assert!(thread.join().is_err());
        }
        assert!(shutdown.is_requested());
        assert_eq!(
            supervisor.fault().unwrap(),
            "the thread first ended by a panic"
        );
    }

    #[test]
    fn the_process_is_kept_as_long_as_somebody_keeps_it() {
        let supervisor = Supervisor::new(Shutdown::default());
        assert!(!supervisor.is_kept());
        let (one, other) = (supervisor.keep(), supervisor.clone().keep());
        drop(one);
        assert!(supervisor.is_kept());
        drop(other);
        assert!(!supervisor.is_kept());
    }

    #[test]
    fn who_works_for_too_long_is_stuck() {
        let supervisor = Supervisor::new(Shutdown::default());
        let pulse = supervisor.pulse("cell");
        let long = Duration::from_secs(3600);
        assert!(!pulse.is_stuck(Duration::ZERO));
        pulse.begin();
        std::thread::yield_now();
        assert!(pulse.is_stuck(Duration::ZERO) && !pulse.is_stuck(long));
        supervisor.look();
        assert_eq!(supervisor.fault(), None);
        pulse.rest();
        assert!(!pulse.is_stuck(Duration::ZERO));
    }
}
