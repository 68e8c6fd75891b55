//! Records of steps, for who keeps them.

use ppnpack_wire::v1;

use super::CellPlanner;
use super::prepare::Prepared;
use super::refusal::Refusal;
use crate::step_plan::Found;

/// Maximum number of records that wait until a request is answered; more are published before.
const MOST_WAITING: usize = 8;

/// Maximum number of shapes that one request may ask for.
const MOST_SHAPES: usize = 1_024;

impl CellPlanner {
    /// Notes the input and the result of a step, where somebody records them. They are published
    /// after the request is answered.
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
