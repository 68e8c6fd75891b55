//! A step over several containers that are open at the same time.
//!
//! Each has a planner of its own, and all plan for the same buffer. The fullest in which an item of
//! the buffer has a valid placement takes one: gaps are filled before room is begun.

use crate::planning::plan::Plan;
use crate::ranking::step::{Candidate, Timings};

/// Candidates, by their indices, that each container may take in an attempt, the fullest first.
pub type Attempt = Vec<Vec<usize>>;

/// Result of planning a step over open containers.
#[derive(Debug, Clone)]
pub struct Found {
    /// The container of the placement by its place in the attempt; without one, the emptiest.
    pub container: usize,
    /// Candidates that it may take, on which the plan is.
    pub candidates: Vec<Candidate>,
    /// The plan in this container.
    pub plan: Plan,
    /// Time per stage, over all containers.
    pub timings: Timings,
    /// Whether the time was over in any container before everything was looked at.
    pub is_cut: bool,
}

/// Plans a step over open containers: what the first attempt that finds a placement finds; else the
/// last plan of all; `None` without containers. `plan_in` plans in a container of an attempt.
pub fn plan_over<E>(
    attempts: &[Attempt],
    candidates: &[Candidate],
    mut plan_in: impl FnMut(usize, &[Candidate]) -> Result<Plan, E>,
) -> Result<Option<Found>, E> {
    let mut last = None;
    let (mut timings, mut is_cut) = (Timings::default(), false);
    for (container, admitted) in attempts
        .iter()
        .flat_map(|attempt| attempt.iter().enumerate())
    {
        let admitted = admitted.iter().filter_map(|index| candidates.get(*index));
        let admitted: Vec<Candidate> = admitted.cloned().collect();
        let plan = match admitted.is_empty() {
            true => Plan::default(),
            false => plan_in(container, &admitted)?,
        };
        timings += plan.timings();
        is_cut |= plan.is_cut();
        let is_found = plan.choice().is_some();
        last = Some(Found {
            container,
            candidates: admitted,
            plan,
            timings,
            is_cut,
        });
        if is_found {
            break;
        }
    }
    Ok(last)
}
