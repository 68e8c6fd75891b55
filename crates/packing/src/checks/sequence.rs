//! The order of leaving as a check: what leaves earlier never lies below what leaves later.

use crate::checks::check::{Cost, Evidence, ValidityCheck, Verdict};
use crate::kernel::placement::RestingPlacement;
use crate::ranking::refusal::{Cause, Refusal};
use crate::ranking::step::{Candidate, StageResult, StepInput};

/// Items lie above none that leaves earlier.
///
/// An item comes from above, and whatever lies in a cell that it covers is below it: it is refused
/// where one of these leaves earlier, also where it does not touch it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sequence;

impl ValidityCheck for Sequence {
    fn cost(&self) -> Cost {
        Cost::Footprint
    }

    fn judge(
        &mut self,
        input: &StepInput<'_>,
        held: &Candidate,
        resting: &RestingPlacement,
    ) -> StageResult<Verdict> {
        let view = held.item.view(resting.placement.yaw)?;
        let leaving = input.scene.leaving();
        let leaving = leaving.filter(|leaving| leaving.earliest < held.stop);
        let below = leaving.map(|leaving| leaving.below(view, resting));
        Ok(match below.filter(|below| *below < held.stop) {
            None => Verdict::Accepted(Evidence::default()),
            Some(below) => {
                let detail = format!("{} above {}", held.stop.said(), below.said());
                Verdict::Refused(Refusal::because(Cause::Sequence, detail))
            }
        })
    }
}
