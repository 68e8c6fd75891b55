//! The items of a session.

use nalgebra::Isometry3;
use ppnpack_packing::placement::RestingPlacement;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::{convert, v1};

/// What has to be respected when an item is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Rules {
    /// Nothing may be placed above it.
    pub(crate) is_fragile: bool,
    /// It must stand on the floor.
    pub(crate) is_bottom_only: bool,
    /// Its centre of mass has to be well inside what supports it.
    pub(crate) is_upright: bool,
}

/// An item as it is announced.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Announced {
    pub(crate) item_id: String,
    pub(crate) object: String,
    pub(crate) shape: ItemId,
    pub(crate) rules: Rules,
}

/// An item of a session.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SessionItem {
    pub(crate) item_id: String,
    pub(crate) object: String,
    pub(crate) shape: ItemId,
    pub(crate) rules: Rules,
    pub(crate) state: ItemState,
}

/// Where an item is on its way into the container.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum ItemState {
    Waiting,
    Decided,
    Packed {
        placement: RestingPlacement,
        /// Where it was planned to be, and where it is by what was reported.
        planned: Isometry3<f64>,
        container_from_item: Isometry3<f64>,
        /// The planned time of the arm's cycle, in seconds, where the cell has one.
        cycle_s: Option<f64>,
    },
    /// Lost, or in an unknown place.
    Gone,
    Withdrawn,
}

impl SessionItem {
    pub(crate) fn new(announced: Announced) -> Self {
        Self {
            item_id: announced.item_id,
            object: announced.object,
            shape: announced.shape,
            rules: announced.rules,
            state: ItemState::Waiting,
        }
    }

    pub(crate) fn is_same(&self, announced: &Announced) -> bool {
        self.shape == announced.shape && self.rules == announced.rules
    }
}

impl ItemState {
    /// The state of a decision's item after its outcome.
    pub(crate) fn after(decision: &v1::Decision, outcome: &v1::Outcome) -> Self {
        match outcome.kind() {
            v1::OutcomeKind::Placed => Self::packed(decision, outcome).unwrap_or(Self::Gone),
            v1::OutcomeKind::NotPlaced => Self::Waiting,
            _ => Self::Gone,
        }
    }

    fn packed(decision: &v1::Decision, outcome: &v1::Outcome) -> Option<Self> {
        let pose = |pose: Option<&v1::Pose>| convert::pose::read_required("pose", pose).ok();
        let planned = pose(decision.container_from_item.as_ref())?;
        Some(Self::Packed {
            placement: convert::placement::read_resting(decision.placement.as_ref()?).ok()?,
            planned,
            container_from_item: pose(outcome.container_from_item.as_ref()).unwrap_or(planned),
            cycle_s: decision.cycle.as_ref().map(|cycle| cycle.cycle_s),
        })
    }
}
