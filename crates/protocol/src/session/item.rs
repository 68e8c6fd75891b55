//! The items of a session.

use nalgebra::Isometry3;
pub use ppnpack_packing::candidate::{Lying, Rules};
use ppnpack_packing::leaving::Stop;
use ppnpack_packing::loads::Load;
use ppnpack_packing::placement::RestingPlacement;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::{convert, v1};

use crate::message::read_pose;
use crate::placing::KnownPose;

/// An item of a session.
#[derive(Debug, Clone, PartialEq)]
pub struct SessionItem {
    /// Names the item.
    pub item_id: String,
    /// Its number in the order in which they were announced, which the session gives it.
    pub arrival: usize,
    /// What it is.
    pub object: String,
    /// Its heightmaps.
    pub shape: ItemId,
    /// What has to be respected.
    pub rules: Rules,
    /// What it belongs to.
    pub order_line: v1::OrderLine,
    /// As it was announced.
    pub lying: Lying,
    /// In how many resting poses it may be packed at most; at least one.
    pub poses: usize,
    /// The numbers of those in which it may be packed, by increasing number; where there are none, the first `poses`.
    pub allowed_poses: Vec<usize>,
    /// Where it is on its way.
    pub state: ItemState,
    /// How it was found after it was placed, where that was looked at.
    pub inspection: Option<v1::Inspection>,
}

/// Where an item is on its way into the container.
#[derive(Debug, Clone, PartialEq)]
pub enum ItemState {
    /// It can be chosen.
    Waiting,
    /// It is on its way by the pending decision.
    Decided,
    /// It is in the container.
    Packed {
        /// Where it was planned to be, on the grid.
        placement: RestingPlacement,
        /// In which of its resting poses.
        pose: usize,
        /// Where its own frame was planned to be.
        planned: Isometry3<f64>,
        /// Where it is, by what was reported and found.
        container_from_item: KnownPose,
        /// The planned time of the arm's cycle, in seconds, where the cell has one.
        cycle_s: Option<f64>,
        /// Of the items below with a limit, the one that it was expected to bring nearest to that.
        load: Option<Load>,
        /// The name of the container.
        container: String,
        /// Which of those that stand there one after another.
        sequence: u64,
    },
    /// Lost, or in an unknown place.
    Gone,
    /// It was taken out before it was decided on.
    Withdrawn,
    /// Left for the next container.
    SetAside {
        /// Why it had no valid placement.
        reason: v1::ItemReason,
        /// The number of the step at which it was set aside.
        step: u64,
    },
}

impl SessionItem {
    /// Enters how it was found: where it is, or that it is gone. Says whether it was packed.
    pub fn inspected(&mut self, inspection: v1::Inspection) -> bool {
        let found = read_pose(inspection.container_from_item.as_ref(), true);
        match &mut self.state {
            ItemState::Packed { .. } if inspection.kind() == v1::InspectionKind::Missing => {
                self.state = ItemState::Gone;
            }
            ItemState::Packed {
                container_from_item,
                ..
            } => *container_from_item = found.unwrap_or(*container_from_item),
            _ => return false,
        }
        self.inspection = Some(inspection);
        true
    }

    /// Has it wait again where it was set aside.
    pub fn wait_again(&mut self) {
        if let ItemState::SetAside { .. } = self.state {
            self.state = ItemState::Waiting;
        }
    }

    /// Whether it may be packed in one of its resting poses.
    pub fn may_be_in(&self, pose: usize) -> bool {
        match self.allowed_poses.as_slice() {
            [] => pose < self.poses,
            allowed => allowed.contains(&pose),
        }
    }

    /// Its mass in kilograms, where it was told.
    pub fn told_kg(&self) -> Option<f64> {
        Some(self.order_line.mass_kg).filter(|mass_kg| *mass_kg > 0.0)
    }

    /// At which stop it leaves the container.
    pub fn stop(&self) -> Stop {
        Stop::new(Some(self.order_line.stop).filter(|stop| *stop > 0))
    }

    /// Whether it was announced as the other is. In how many poses it may be packed is what the cell allowed when it was
    /// announced first; how many items there are of its order is not of the item.
    pub fn is_same(&self, other: &Self) -> bool {
        self.shape == other.shape
            && self.rules == other.rules
            && self.lying == other.lying
            && of_item(&self.order_line) == of_item(&other.order_line)
            && self.allowed_poses == other.allowed_poses
    }
}

/// An order line without what it says of the order.
fn of_item(line: &v1::OrderLine) -> v1::OrderLine {
    v1::OrderLine {
        order_items: 0,
        ..line.clone()
    }
}

impl ItemState {
    /// The state of a decision's item after its outcome; `sequence` says which container it was that it was decided for.
    pub fn after(decision: &v1::Decision, outcome: &v1::Outcome, sequence: u64) -> Self {
        match outcome.kind() {
            v1::OutcomeKind::Placed => {
                Self::packed(decision, outcome, sequence).unwrap_or(Self::Gone)
            }
            v1::OutcomeKind::NotPlaced => Self::Waiting,
            _ => Self::Gone,
        }
    }

    fn packed(decision: &v1::Decision, outcome: &v1::Outcome, sequence: u64) -> Option<Self> {
        let planned = decision.container_from_item.as_ref();
        let planned = convert::pose::read_required("pose", planned).ok()?;
        let told = read_pose(outcome.container_from_item.as_ref(), outcome.is_found);
        Some(Self::Packed {
            placement: convert::placement::read_resting(decision.placement.as_ref()?).ok()?,
            pose: usize::try_from(decision.pose).unwrap_or(usize::MAX),
            planned,
            container_from_item: told.unwrap_or(KnownPose::Assumed(planned)),
            cycle_s: decision.cycle.as_ref().map(|cycle| cycle.cycle_s),
            load: decision
                .load
                .as_deref()
                .and_then(|load| convert::load::read(load).ok()),
            container: decision.container.clone(),
            sequence,
        })
    }
}
