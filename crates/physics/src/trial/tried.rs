//! Placements that were tried, and what the tries say.

use nalgebra::Isometry3;
use ppnpack_packing::checks::trial::{Settling, TrialLimits};
use ppnpack_packing::kernel::item::ShapeId;
use ppnpack_packing::kernel::placement::RestingPlacement;
use ppnpack_packing::ranking::refusal::{Cause, Refusal};
use ppnpack_packing::ranking::step::Candidate;

use crate::error::PhysicsError;
use crate::twin::{Solid, Twin};

/// An item at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Place {
    pub(super) arrival: usize,
    pub(super) shape: ShapeId,
    /// Whether no more is known of the item than the shape that was seen.
    pub(super) is_seen: bool,
    pub(super) resting: RestingPlacement,
}

/// A placement that was refused, and why.
pub(super) struct Refused {
    pub(super) place: Place,
    pub(super) tried: Tried,
    pub(super) why: &'static str,
}

impl Refused {
    /// Refuses it, or one like it.
    pub(super) fn refusal(&self) -> Refusal {
        Refusal::because(Cause::Unsteady, self.why)
    }
}

/// The outcome for a solid at a place.
#[derive(Clone)]
pub(super) struct Tried {
    pub(super) solid: Solid,
    pub(super) container_from_item: Isometry3<f64>,
    pub(super) settling: Settling,
}

impl Tried {
    pub(super) fn now(
        twin: &Twin,
        solid: Solid,
        container_from_item: Isometry3<f64>,
        limits: &TrialLimits,
    ) -> Result<Self, PhysicsError> {
        let settling = twin.try_placement(&solid, &container_from_item, limits)?;
        Ok(Self {
            solid,
            container_from_item,
            settling,
        })
    }

    /// Says what keeps it from being accepted as long as another placement is valid.
    pub(super) fn beyond(&self, limits: &TrialLimits) -> Option<&'static str> {
        self.settling.beyond(&self.solid.limits(limits))
    }
}

impl Place {
    pub(super) fn of(candidate: &Candidate, resting: &RestingPlacement) -> Self {
        Self {
            arrival: candidate.arrival,
            shape: candidate.item.shape(),
            is_seen: candidate.model.is_none(),
            resting: *resting,
        }
    }
}
