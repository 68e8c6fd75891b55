//! The services of one kind that may be asked in a step.

use std::sync::Arc;
use std::time::{Duration, Instant};

use ppnpack_packing::ranking::step::StepInput;
use ppnpack_service::alive::Alive;
use ppnpack_service::rpc::Client;
use ppnpack_wire::keys::{Cell, Instance};

/// The services of one kind that are alive, and how they are asked for a cell.
#[derive(Clone)]
pub(crate) struct Peers {
    pub(crate) cell: Cell,
    pub(crate) client: Client,
    pub(crate) alive: Arc<Alive>,
    /// Maximum time of an answer.
    pub(crate) limit: Duration,
}

impl Peers {
    /// Gives the instance that is asked for this cell: the same as long as the same ones are alive.
    pub(super) fn chosen(&self) -> Option<Instance> {
        let alive = self.alive.instances_for(&self.cell);
        let sum: usize = self.cell.as_str().bytes().map(usize::from).sum();
        alive.get(sum % alive.len().max(1)).cloned()
    }

    /// Gives when they have to have answered: half of what is left of the step is kept.
    pub(super) fn deadline(&self, input: &StepInput<'_>) -> Instant {
        let now = Instant::now();
        let left = input
            .deadline
            .map(|deadline| deadline.saturating_duration_since(now) / 2);
        now + left.map_or(self.limit, |left| left.min(self.limit))
    }
}
