//! What a tried placement would load the items below with.

use nalgebra::Isometry3;
use ppnpack_packing::loads::{Burden, Load};
use ppnpack_packing::refusal::Refusal;

use super::Place;
use crate::error::PhysicsError;
use crate::twin::{Solid, Twin};

/// Simulated loads tremble by less than this, as a share of them.
const TREMBLING: f64 = 0.02;

/// Lighter loads count as none, in kilograms: what leans on an item's side presses it down by some tenths of a gram.
const LEAST_KG: f64 = 0.002;

/// Holds what items carry, where a placement was tried, against what they may.
pub(super) struct LoadTries {
    /// Loads count this many times, but never more than all that is above.
    margin: f64,
    /// Of this step.
    refused: Vec<(Place, Refusal)>,
}

impl LoadTries {
    pub(super) fn new(margin: f64) -> Self {
        Self {
            margin,
            refused: Vec::new(),
        }
    }

    /// A step begins.
    pub(super) fn begin(&mut self) {
        self.refused.clear();
    }

    /// What was refused at a place that `is_near`.
    pub(super) fn refused(&self, is_near: impl Fn(&Place) -> bool) -> Option<&Refusal> {
        let mut refused = self.refused.iter();
        let near = refused.find(|(place, _)| is_near(place));
        near.map(|(_, refusal)| refusal)
    }

    /// The item that would be loaded most for what it may carry, where one has a limit.
    pub(super) fn greatest(
        &self,
        twin: &Twin,
        solid: &Solid,
        mass_kg: Option<f64>,
        pose: &Isometry3<f64>,
    ) -> Result<Option<Load>, PhysicsError> {
        let has_limit = |burden: &Burden| burden.carries_kg.is_some();
        let has_limits = twin.burdens().any(has_limit);
        // An item of unknown mass loads nothing.
        let Some(mass_kg) = mass_kg.filter(|_| has_limits) else {
            return Ok(None);
        };
        let loads_kg = twin.try_loads_kg(solid, mass_kg, pose, self.margin)?;
        let loads = twin
            .burdens()
            .zip(loads_kg)
            .filter_map(|(burden, load_kg)| {
                let carries_kg = burden.carries_kg?;
                (load_kg > LEAST_KG).then(|| Load {
                    item: burden.name.to_string(),
                    estimated_kg: load_kg,
                    carries_kg,
                })
            });
        Ok(loads.max_by(|one, other| one.share().total_cmp(&other.share())))
    }

    /// Refuses a placement that loads an item with more than it may carry, and remembers that.
    pub(super) fn refuse(&mut self, place: Place, load: &Load) -> Option<Refusal> {
        if load.share() <= 1.0 + TREMBLING {
            return None;
        }
        let refusal = load.refusal();
        self.refused.push((place, refusal.clone()));
        Some(refusal)
    }
}
