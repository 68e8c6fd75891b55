//! The health of a process: the conditions under which it is ready.

use std::sync::{Arc, Mutex};

use ppnpack_wire::v1;

use crate::metrics::{self, Metric};
use crate::sync::lock;

/// Named conditions that must all hold for the process to be ready. Clones share them.
#[derive(Debug, Clone, Default)]
pub struct Health {
    state: Arc<Mutex<State>>,
}

#[derive(Debug, Default)]
struct State {
    checks: Vec<Check>,
    /// Whether checks may fail without a word, because the process ends.
    is_ending: bool,
}

#[derive(Debug)]
struct Check {
    name: &'static str,
    /// The fault; `None` where it passes.
    trouble: Option<String>,
}

/// Says of one condition whether it holds. When the last clone is dropped, it fails as "ended".
#[derive(Debug, Clone)]
pub struct HealthLatch {
    registered: Arc<Registered>,
}

#[derive(Debug)]
struct Registered {
    health: Health,
    index: usize,
}

impl Health {
    /// Registers a condition, which fails until it is said to hold.
    pub fn check(&self, name: &'static str) -> HealthLatch {
        let mut state = lock(&self.state);
        let (health, index) = (self.clone(), state.checks.len());
        state.checks.push(Check {
            name,
            trouble: Some("not started".to_owned()),
        });
        let registered = Arc::new(Registered { health, index });
        HealthLatch { registered }
    }

    /// Gives all conditions, in the order in which they were registered.
    pub fn report(&self) -> Vec<v1::HealthCheck> {
        let state = lock(&self.state);
        let report = state.checks.iter().map(|check| v1::HealthCheck {
            name: check.name.to_owned(),
            is_passing: check.trouble.is_none(),
            message: check.trouble.clone().unwrap_or_default(),
        });
        report.collect()
    }

    /// Says whether all conditions hold.
    pub fn is_ready(&self) -> bool {
        lock(&self.state).is_ready()
    }

    /// Has conditions fail without a word from now on, because the service ends.
    pub fn end_quietly(&self) {
        lock(&self.state).is_ending = true;
    }

    fn set(&self, index: usize, trouble: Option<String>) {
        let mut state = lock(&self.state);
        let is_ending = state.is_ending;
        let check = state.checks.get_mut(index);
        let Some(check) = check.filter(|check| check.trouble != trouble) else {
            return;
        };
        match &trouble {
            Some(_) if is_ending => {}
            Some(reason) => tracing::warn!(check = check.name, reason, "not healthy"),
            None => tracing::info!(check = check.name, "healthy"),
        }
        check.trouble = trouble;
        let is_ready = f64::from(u8::from(state.is_ready()));
        metrics::gauge(Metric::Ready, &[]).set(is_ready);
    }
}

impl State {
    fn is_ready(&self) -> bool {
        self.checks.iter().all(|check| check.trouble.is_none())
    }
}

impl HealthLatch {
    /// Says that the condition holds.
    pub fn pass(&self) {
        self.registered.health.set(self.registered.index, None);
    }

    /// Says why the condition does not hold.
    pub fn fail(&self, message: impl Into<String>) {
        let trouble = Some(message.into());
        self.registered.health.set(self.registered.index, trouble);
    }
}

impl Drop for Registered {
    fn drop(&mut self) {
        self.health.set(self.index, Some("ended".to_owned()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ready_while_every_check_passes() {
        let health = Health::default();
        assert!(health.is_ready());
        let store = health.check("store");
        let threads = health.check("threads");
        store.pass();
        assert!(!health.is_ready());
        threads.pass();
        assert!(health.is_ready());
        store.fail("disk full");
        let report = health.report();
        let failing = (report[0].name.as_str(), report[0].message.as_str());
        assert_eq!(failing, ("store", "disk full"));
        assert!(!report[0].is_passing && report[1].is_passing);
        store.pass();
        drop(threads.clone());
        assert!(health.is_ready());
        drop(threads);
        assert_eq!(health.report()[1].message, "ended");
    }
}
