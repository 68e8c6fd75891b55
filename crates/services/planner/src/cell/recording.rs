//! What steps were planned on, for who records it.

use ppnpack_wire::v1;

use super::CellPlanner;
use super::prepare::Prepared;
use super::refusal::Refusal;
use crate::record::StepResult;
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
        let result = StepResult {
            session_id: self.session.id(),
            is_cut: found.is_cut,
            decision,
        };
        let record = self.recorder.record(&prepared.plan, &result);
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
