//! What steps were planned on, for who records it.

use ppnpack_wire::v1;

use super::CellPlanner;
use super::prepare::Prepared;
use super::refusal::Refusal;
use crate::step_plan::Found;

/// Records that wait until a request is answered, at most; more are published before.
const MOST_WAITING: usize = 8;

/// Shapes that one request may ask for.
const MOST_SHAPES: usize = 1_024;

impl CellPlanner {
    /// Notes what a step was planned on and what came of it, where somebody records that. It is published after the request is answered.
    pub(super) fn record(
        &mut self,
        prepared: &Prepared,
        found: &Found,
        decision: Option<&v1::Decision>,
    ) {
        if !self.recorder.is_wanted() {
            return;
        }
        let (recorder, id) = (&mut self.recorder, self.session.id());
        let record = recorder.record(id, &prepared.plan, found, decision);
        if self.news.records.len() < MOST_WAITING {
            self.news.records.push(record);
        } else {
            self.recorder.publish(&record);
        }
    }

    /// The items and solids that records name.
    pub(super) fn shapes(&self, ids: &[Vec<u8>]) -> Result<v1::ShapesReply, Refusal> {
        if !(1..=MOST_SHAPES).contains(&ids.len()) {
            return Err(Refusal::invalid(format_args!(
                "ids: {} where 1 to {MOST_SHAPES} are possible",
                ids.len()
            )));
        }
        Ok(self.recorder.shapes(ids))
    }
}
