//! The end of a process that cannot go on: a thread panicked or hangs, or the session was closed.
//!
//! A process that lives on with a part of it dead looks ready to everybody and serves nobody; one
//! that ends is started again.

use std::sync::{Arc, Mutex, Weak};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::error::ServiceError;
use crate::process::thread;
use crate::shutdown::Shutdown;
use crate::sync::lock;

/// Maximum time of work on one message: requests may take ten minutes at most.
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
    /// Makes the supervisor of a process, which it ends by requesting this.
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

    pub(crate) fn shutdown(&self) -> &Shutdown {
        &self.shared.shutdown
    }

    /// Keeps the process from ending for want of a router, until the guard is dropped: for work
    /// that cannot be broken off.
    #[must_use]
    pub fn keep(&self) -> Kept {
        Kept {
            _counted: Arc::clone(&self.shared.kept),
        }
    }

    pub(crate) fn is_kept(&self) -> bool {
        Arc::strong_count(&self.shared.kept) > 1
    }

    /// Ends the process, which fails for this reason; of several reasons the first stays.
    pub fn give_up(&self, fault: String) {
        tracing::error!(fault, "the process ends, to begin anew");
        lock(&self.shared.fault).get_or_insert(fault);
        self.shared.shutdown.request();
    }

    /// Gives the reason for which the process fails, if it does.
    pub fn fault(&self) -> Option<String> {
        lock(&self.shared.fault).clone()
    }

    /// Ends the process where somebody hangs.
    pub(crate) fn look(&self) {
        let pulses = self.pulses();
        if let Some(stuck) = pulses.iter().find(|pulse| pulse.is_stuck(LONGEST_WORK)) {
            let (name, minutes) = (&stuck.name, LONGEST_WORK.as_secs() / 60);
            let fault = format!("{name} has worked on one thing for {minutes} minutes");
            self.give_up(fault);
        }
    }

    /// Starts a thread that the process cannot do without: a panic in it ends the process.
    ///
    /// # Errors
    /// [`ServiceError::System`] where there can be no more threads.
    pub fn thread<T: Send + 'static>(
        &self,
        name: &str,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<JoinHandle<T>, ServiceError> {
        let guard = Guard {
            supervisor: self.clone(),
            name: name.to_owned(),
        };
        thread(name, move || {
            let _guard = guard;
            work()
        })
    }

    /// Names those whose work is watched.
    pub fn watched(&self) -> Vec<String> {
        let pulses = self.pulses();
        pulses.iter().map(|pulse| pulse.name.clone()).collect()
    }

    /// Gives the pulses of those that live, and forgets the others.
    fn pulses(&self) -> Vec<Arc<Pulse>> {
        let mut pulses = lock(&self.shared.pulses);
        pulses.retain(|pulse| pulse.strong_count() > 0);
        pulses.iter().filter_map(Weak::upgrade).collect()
    }

    /// Watches the work of somebody, as long as they keep their pulse.
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

/// Ends the process where the thread that holds it panics.
struct Guard {
    supervisor: Supervisor,
    name: String,
}

impl Drop for Guard {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let fault = format!("the thread {} ended by a panic", self.name);
            self.supervisor.give_up(fault);
        }
    }
}

/// Tells since when somebody works on a message.
#[derive(Debug)]
pub(crate) struct Pulse {
    name: String,
    busy_since: Mutex<Option<Instant>>,
}

impl Pulse {
    pub(crate) fn begin(&self) {
        *lock(&self.busy_since) = Some(Instant::now());
    }

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
        let fault = supervisor.fault().unwrap();
        assert_eq!(fault, "the thread first ended by a panic");
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
