//! What the stages of a step need to know beside its input, and what they tell beside their answer.

use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use crate::session::Rules;

/// Shared by the stages of one cell's planner.
#[derive(Debug)]
pub(crate) struct StepContext(Mutex<Step>);

#[derive(Debug)]
struct Step {
    deadline: Instant,
    wanted: usize,
    rules: HashMap<usize, Rules>,
    degraded: Vec<String>,
    is_cut: bool,
}

impl StepContext {
    pub(crate) fn new() -> Self {
        Self(Mutex::new(Step {
            deadline: Instant::now(),
            wanted: 1,
            rules: HashMap::new(),
            degraded: Vec::new(),
            is_cut: false,
        }))
    }

    /// A new step, to be planned by `deadline`; `wanted` placements are enough, unless rules refuse some. `rules` are
    /// by arrival.
    pub(crate) fn begin(&self, deadline: Instant, wanted: usize, rules: HashMap<usize, Rules>) {
        *self.lock() = Step {
            deadline,
            wanted,
            rules,
            degraded: Vec::new(),
            is_cut: false,
        };
    }

    pub(crate) fn deadline(&self) -> Instant {
        self.lock().deadline
    }

    /// How many placements to ask for at first.
    pub(crate) fn wanted(&self) -> usize {
        self.lock().wanted
    }

    /// The rules of an item.
    pub(crate) fn rules_of(&self, arrival: usize) -> Rules {
        self.lock().rules.get(&arrival).copied().unwrap_or_default()
    }

    /// Says that something was done in another way than was asked for; each reason once.
    pub(crate) fn degrade(&self, reason: String) {
        let mut step = self.lock();
        if !step.degraded.contains(&reason) {
            step.degraded.push(reason);
        }
    }

    /// Says that the time was over before the placements of so many items were searched.
    pub(crate) fn cut(&self, items: usize) {
        self.degrade(format!("the time limit left {items} items unsearched"));
        self.lock().is_cut = true;
    }

    /// Says that the time was over before all placements were checked.
    pub(crate) fn cut_checks(&self) {
        self.degrade("the time limit left placements unchecked".to_owned());
        self.lock().is_cut = true;
    }

    /// Whether some placements were not searched for want of time.
    pub(crate) fn is_cut(&self) -> bool {
        self.lock().is_cut
    }

    pub(crate) fn take_degraded(&self) -> Vec<String> {
        std::mem::take(&mut self.lock().degraded)
    }

    fn lock(&self) -> MutexGuard<'_, Step> {
        // Every change is a whole one: a panic elsewhere leaves nothing half done.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
