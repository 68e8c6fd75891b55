//! The balance of a container: one whose heavy content lies far from its middle tips.

use nalgebra::Vector2;

use super::UNKNOWN_MASS;
use crate::checks::check::{Cost, Evidence, ValidityCheck, Verdict};
use crate::kernel::placement::RestingPlacement;
use crate::ranking::refusal::Cause;
use crate::ranking::step::{Candidate, StageResult, StepInput};
use crate::scene::content::{Content, LyingSolid};

/// Accepts placements that leave the container balanced, or no more out of balance than it was. An
/// item of unknown mass weighs nothing, which the evidence says.
#[derive(Debug, Clone)]
pub struct BalanceCheck {
    most_kg_m: f64,
    moment_kg_m: Vector2<f64>,
}

impl BalanceCheck {
    /// A check with the greatest mass times distance from the middle, in kg m.
    pub fn new(most_kg_m: f64) -> Self {
        Self {
            most_kg_m,
            moment_kg_m: Vector2::zeros(),
        }
    }
}

fn middle_m(input: &StepInput<'_>) -> Vector2<f64> {
    let size = input.grid.container();
    Vector2::new(size.x_m, size.y_m) / 2.0
}

impl ValidityCheck for BalanceCheck {
    fn cost(&self) -> Cost {
        Cost::Lookup
    }

    fn begin(&mut self, input: &StepInput<'_>) -> StageResult {
        let middle = middle_m(input);
        let moment = |solid: &LyingSolid| {
            let centre = solid.container_from_item * solid.model.mass.centre_of_mass_m;
            (centre.coords.xy() - middle) * solid.burden.mass_kg
        };
        let content = input.scene.content();
        let solids = content.map_or(&[][..], Content::all_solids);
        self.moment_kg_m = solids.iter().map(moment).sum();
        Ok(())
    }

    fn judge(
        &mut self,
        input: &StepInput<'_>,
        held: &Candidate,
        at: &RestingPlacement,
    ) -> StageResult<Verdict> {
        let view = held.item.view(at.placement.yaw)?;
        let Some(mass_kg) = held.weighs_kg() else {
            return Ok(Verdict::Accepted(Evidence::noting(UNKNOWN_MASS)));
        };
        let cell_m = input.grid.resolution().cell_m();
        let centre = view.placed_centre_of_mass_m(&at.placement, cell_m).coords;
        let moment = self.moment_kg_m + (centre - middle_m(input)) * mass_kg;
        let is_met = moment.norm() <= self.most_kg_m || moment.norm() <= self.moment_kg_m.norm();
        Ok(Verdict::of(is_met, Cause::Balance))
    }
}
