//! Loads of a tried placement on the items below.

use nalgebra::Isometry3;
use ppnpack_packing::checks::loads::Load;
use ppnpack_packing::ranking::refusal::Refusal;

use super::Place;
use crate::error::PhysicsError;
use crate::twin::{Solid, Twin};

/// Simulated loads tremble by less than this, as a share of them.
const TREMBLING: f64 = 0.02;

/// Maximum of placements of an item that a step refuses by their loads; after that the item is left
/// out of the step. To try a load takes longer than to try a placement, as the whole content takes
/// part.
const MOST_REFUSED: usize = 5;

/// Minimum load that counts, in kilograms: what leans on an item's side presses it down by some
/// tenths of a gram.
const LEAST_KG: f64 = 0.002;

/// Holds what items carry, where a placement was tried, against what they may.
pub(super) struct LoadTries {
    /// Factor of loads, which never count more than all that is above.
    margin: f64,
    /// Refusals of this step.
    refused: Vec<(Place, Refusal)>,
}

impl LoadTries {
    pub(super) fn new(margin: f64) -> Self {
        Self {
            margin,
            refused: Vec::new(),
        }
    }

    /// Begins a step.
    pub(super) fn begin(&mut self) {
        self.refused.clear();
    }

    /// Gives a refusal at a place that `is_near`.
    pub(super) fn refused(&self, is_near: impl Fn(&Place) -> bool) -> Option<&Refusal> {
        let mut refused = self.refused.iter();
        let near = refused.find(|(place, _)| is_near(place));
        near.map(|(_, refusal)| refusal)
    }

    /// Gives the last refusal of an item of which no more placements are looked at.
    pub(super) fn done_with(&self, arrival: usize) -> Option<&Refusal> {
        let of_item = self.refused.iter().rev();
        let mut of_item = of_item.filter(|(place, _)| place.arrival == arrival);
        let last = of_item.next()?;
        let before = of_item.count();
        (before + 1 >= MOST_REFUSED).then_some(&last.1)
    }

    /// Gives the item that would be loaded most for what it may carry, where one has a limit.
    pub(super) fn greatest(
        &self,
        twin: &Twin,
        solid: &Solid,
        mass_kg: Option<f64>,
        pose: &Isometry3<f64>,
        pool: Option<&rayon::ThreadPool>,
    ) -> Result<Option<Load>, PhysicsError> {
        let Some(mass_kg) = mass_kg.filter(|_| Self::are_tried(twin, mass_kg)) else {
            return Ok(None);
        };
        let planned_kg = twin.try_loads_kg(solid, mass_kg, pose, self.margin)?;
        let planned = greatest(twin, &planned_kg);
        // What this one try refuses needs no other.
        if planned.as_ref().is_some_and(is_too_much) {
            return Ok(planned);
        }
        let disturbed_kg = twin.try_disturbed_loads_kg(solid, mass_kg, pose, self.margin, pool)?;
        let disturbed = greatest(twin, &disturbed_kg);
        Ok(heaviest(planned.into_iter().chain(disturbed)))
    }

    /// Says whether all that there is may be too much for an item, so that loads are tried. An item
    /// of unknown mass loads nothing.
    pub(super) fn are_tried(twin: &Twin, mass_kg: Option<f64>) -> bool {
        let lying_kg: f64 = twin.burdens().map(|burden| burden.mass_kg).sum();
        let mut limits = twin
            .burdens()
            .filter_map(|burden| Some((burden, burden.carries_kg?)));
        mass_kg.is_some_and(|mass_kg| {
            limits.any(|(burden, carries_kg)| lying_kg + mass_kg - burden.mass_kg > carries_kg)
        })
    }

    /// Refuses a placement that loads an item with more than it may carry, and remembers that.
    pub(super) fn refuse(&mut self, place: Place, load: &Load) -> Option<Refusal> {
        is_too_much(load).then(|| {
            let refusal = load.refusal();
            self.refused.push((place, refusal.clone()));
            refusal
        })
    }
}

/// Gives the load that comes nearest to a limit.
fn greatest(twin: &Twin, loads_kg: &[f64]) -> Option<Load> {
    let loads = twin.burdens().zip(loads_kg);
    let loads = loads.filter_map(|(burden, load_kg)| {
        let carries_kg = burden.carries_kg?;
        (*load_kg > LEAST_KG).then(|| Load {
            item: burden.name.to_string(),
            estimated_kg: *load_kg,
            carries_kg,
        })
    });
    heaviest(loads)
}

fn heaviest(loads: impl Iterator<Item = Load>) -> Option<Load> {
    loads.max_by(|one, other| one.share().total_cmp(&other.share()))
}

fn is_too_much(load: &Load) -> bool {
    load.share() > 1.0 + TREMBLING
}
