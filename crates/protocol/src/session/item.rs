//! The items of a session.

use nalgebra::Isometry3;
use ppnpack_packing::leaving::Stop;
use ppnpack_packing::placement::RestingPlacement;
use ppnpack_wire::v1::{self, ItemState};
use ppnpack_wire::{WireError, convert};

use crate::message::read_pose;
use crate::placing::KnownPose;

/// Where an item is packed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Packed {
    /// Where it was planned to be, on the grid.
    pub placement: RestingPlacement,
    /// In which of its resting poses.
    pub pose: usize,
    /// Where its own frame was planned to be.
    pub planned: Isometry3<f64>,
    /// Where it is, by what was reported and found.
    pub container_from_item: KnownPose,
}

impl Packed {
    /// Reads where an item is packed; `None` where it is not.
    ///
    /// # Errors
    /// [`WireError`] where that cannot be read.
    pub fn read(item: &v1::SessionItem) -> Result<Option<Self>, WireError> {
        if item.state() != ItemState::Packed {
            return Ok(None);
        }
        let missing = WireError::Missing {
            field: "items.placement",
        };
        let placement = item.placement.as_ref().ok_or(missing)?;
        let pose =
            |field, pose: &Option<v1::Pose>| convert::pose::read_required(field, pose.as_ref());
        let container_from_item = pose("items.container_from_item", &item.container_from_item)?;
        Ok(Some(Self {
            placement: convert::placement::read_resting(placement)?,
            pose: usize::try_from(item.pose).unwrap_or(usize::MAX),
            planned: pose("items.planned", &item.planned)?,
            container_from_item: KnownPose::new(container_from_item, item.is_found),
        }))
    }
}

/// Gives the number of an item in the order in which items were announced.
pub fn arrival(item: &v1::SessionItem) -> usize {
    usize::try_from(item.arrival).unwrap_or(usize::MAX)
}

/// Gives the mass of an item in kilograms, where it was told.
pub fn told_kg(item: &v1::SessionItem) -> Option<f64> {
    let told_kg = item.order_line.as_ref()?.mass_kg;
    Some(told_kg).filter(|mass_kg| *mass_kg > 0.0)
}

/// Gives the stop at which an item leaves the container.
pub fn stop(item: &v1::SessionItem) -> Stop {
    let stop = item.order_line.as_ref().map(|line| line.stop);
    Stop::new(stop.filter(|stop| *stop > 0))
}

/// Says whether an item may be packed in one of its resting poses.
pub fn may_be_in(item: &v1::SessionItem, pose: usize) -> bool {
    let Ok(pose) = u32::try_from(pose) else {
        return false;
    };
    match item.allowed_poses.as_slice() {
        [] => pose < item.poses.max(1),
        allowed => allowed.contains(&pose),
    }
}

/// Says whether an item was announced as the other is. In how many poses it may be packed is what the cell allowed when it was
/// announced first; how many items there are of its order is not of the item.
pub(super) fn is_same(item: &v1::SessionItem, other: &v1::SessionItem) -> bool {
    let line = |item: &v1::SessionItem| v1::OrderLine {
        order_items: 0,
        ..item.order_line.as_deref().cloned().unwrap_or_default()
    };
    item.shape == other.shape
        && item.rules == other.rules
        && item.heightmap_from_item == other.heightmap_from_item
        && item.waits_at == other.waits_at
        && line(item) == line(other)
        && item.allowed_poses == other.allowed_poses
}

/// Has an item wait again where it was set aside.
pub(super) fn wait_again(item: &mut v1::SessionItem) {
    if item.state() == ItemState::SetAside {
        enter(item, ItemState::Waiting);
    }
}

/// Enters where an item is on its way, without what was of the state before.
pub(super) fn enter(item: &mut v1::SessionItem, state: ItemState) {
    let before = std::mem::take(item);
    *item = v1::SessionItem {
        item_id: before.item_id,
        arrival: before.arrival,
        object: before.object,
        shape: before.shape,
        rules: before.rules,
        order_line: before.order_line,
        heightmap_from_item: before.heightmap_from_item,
        waits_at: before.waits_at,
        poses: before.poses,
        allowed_poses: before.allowed_poses,
        inspection: before.inspection,
        state: state.into(),
        ..v1::SessionItem::default()
    };
}

/// Enters what became of an item's decision; `sequence` says which container it was that it was decided for.
pub(super) fn enter_outcome(
    item: &mut v1::SessionItem,
    decision: &v1::Decision,
    outcome: &v1::Outcome,
    sequence: u64,
) {
    match outcome.kind() {
        v1::OutcomeKind::Placed => enter_packed(item, decision, outcome, sequence),
        v1::OutcomeKind::NotPlaced => enter(item, ItemState::Waiting),
        _ => enter(item, ItemState::Gone),
    }
}

fn enter_packed(
    item: &mut v1::SessionItem,
    decision: &v1::Decision,
    outcome: &v1::Outcome,
    sequence: u64,
) {
    enter(item, ItemState::Packed);
    let told = outcome.container_from_item.as_ref();
    let told = told.filter(|told| read_pose(Some(told), true).is_some());
    item.placement = decision.placement;
    item.pose = decision.pose;
    item.planned = decision.container_from_item;
    item.container_from_item = told.copied().or(decision.container_from_item);
    item.is_found = told.is_some() && outcome.is_found;
    let cycle = decision.cycle.as_ref();
    item.cycle_s = cycle.map_or(0.0, |cycle| cycle.cycle_s);
    let load = decision.load.clone();
    item.load = load.filter(|load| convert::load::read(load).is_ok());
    item.container.clone_from(&decision.container);
    item.container_sequence = sequence;
    // Nobody could say where it is.
    if Packed::read(item).is_err() {
        enter(item, ItemState::Gone);
    }
}

/// Enters how an item was found: where it is, or that it is gone. Says whether it was packed.
pub(super) fn inspected(item: &mut v1::SessionItem, inspection: v1::Inspection) -> bool {
    if item.state() != ItemState::Packed {
        return false;
    }
    let found = inspection.container_from_item;
    if inspection.kind() == v1::InspectionKind::Missing {
        enter(item, ItemState::Gone);
    } else if read_pose(found.as_ref(), true).is_some() {
        (item.container_from_item, item.is_found) = (found, true);
    }
    item.inspection = Some(inspection);
    true
}
