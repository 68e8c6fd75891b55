//! The check of loads.

use std::sync::Arc;

use super::{Load, Pile, UNKNOWN_MASS};
use crate::checks::check::{Cost, Evidence, ValidityCheck, Verdict};
use crate::kernel::grid::Grid;
use crate::kernel::placement::RestingPlacement;
use crate::ranking::step::{Candidate, StageResult, StepInput};
use crate::scene::content::Content;

/// Note on a content that is not wholly known.
const PARTIAL_CONTENT: &str =
    "what lies in the container and is not known was left out of the loads";

/// Accepts placements that load no item below with more than it may carry.
///
/// What is not known to lie there carries anything, and an item of unknown mass loads nothing: the
/// evidence says so.
#[derive(Debug)]
pub struct LoadCheck {
    margin: f64,
    pile: Option<(Grid, Pile)>,
    /// Solids with limits: index, name, and the greatest mass that each may carry, in kilograms.
    limited: Vec<(usize, Arc<str>, f64)>,
    is_partial: bool,
}

impl LoadCheck {
    /// A check that holds so many times the estimated loads against what items may carry.
    pub fn new(margin: f64) -> Self {
        Self {
            margin,
            pile: None,
            limited: Vec::new(),
            is_partial: false,
        }
    }

    /// Estimates the load of a solid with `added_kg` more, in kilograms: at most all above it.
    fn estimated_kg(&self, pile: &Pile, solid: usize, added_kg: f64, mass_kg: f64) -> f64 {
        let with_margin_kg = self.margin * (pile.carried_kg(solid) + added_kg);
        with_margin_kg.min(pile.above_kg(solid) + mass_kg)
    }
}

impl ValidityCheck for LoadCheck {
    fn cost(&self) -> Cost {
        Cost::Footprint
    }

    fn begin(&mut self, input: &StepInput<'_>) -> StageResult {
        let content = input.scene.content();
        // Where something is not quite where it was to be, its load is nearly the same.
        let solids = content.map_or(&[][..], Content::all_solids);
        let limited = solids.iter().enumerate().filter_map(|(index, solid)| {
            let name = Arc::clone(&solid.burden.name);
            Some((index, name, solid.burden.carries_kg?))
        });
        self.limited = limited.collect();
        self.is_partial = content.is_some_and(Content::has_unknown);
        if self.limited.is_empty() {
            return Ok(());
        }
        let mut pile = self.pile.iter();
        if !pile.any(|(grid, _)| grid == input.grid) {
            self.pile = Some((input.grid.clone(), Pile::new(input.grid)));
        }
        if let Some((_, pile)) = &mut self.pile {
            pile.lay_down(solids);
        }
        Ok(())
    }

    fn judge(
        &mut self,
        _input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> StageResult<Verdict> {
        let view = candidate.item.view(resting.placement.yaw)?;
        let pile = self.pile.as_ref().filter(|_| !self.limited.is_empty());
        let Some((_, pile)) = pile else {
            return Ok(Verdict::Accepted(Evidence::default()));
        };
        let Some(mass_kg) = candidate.weighs_kg() else {
            return Ok(Verdict::Accepted(Evidence::noting(UNKNOWN_MASS)));
        };
        let added_kg = pile.added_kg(view, &resting.placement, mass_kg);
        let loads = self.limited.iter().filter_map(|(solid, name, carries_kg)| {
            let added_kg = added_kg.get(*solid).copied().filter(|kg| *kg > 0.0)?;
            Some(Load {
                item: name.to_string(),
                estimated_kg: self.estimated_kg(pile, *solid, added_kg, mass_kg),
                carries_kg: *carries_kg,
            })
        });
        let greatest = loads.max_by(|one, other| one.share().total_cmp(&other.share()));
        if let Some(load) = &greatest
            && load.share() > 1.0
        {
            return Ok(Verdict::Refused(load.refusal()));
        }
        let evidence = match self.is_partial {
            true => Evidence::noting(PARTIAL_CONTENT),
            false => Evidence::default(),
        };
        Ok(Verdict::Accepted(Evidence {
            load: greatest,
            ..evidence
        }))
    }
}
