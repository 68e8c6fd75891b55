//! The items of a session.

use nalgebra::Isometry3;
use ppnpack_packing::kernel::placement::RestingPlacement;
use ppnpack_packing::scene::leaving::Stop;
use ppnpack_wire::convert::pose::read_required;
use ppnpack_wire::v1::{self, ItemState};
use ppnpack_wire::{WireError, convert};

use crate::message::read_pose;
use crate::placing::KnownPose;

/// The place of a packed item.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Packed {
    /// Its planned place on the grid.
    pub placement: RestingPlacement,
    /// The index of its resting pose.
    pub pose: usize,
    /// The planned pose of its own frame.
    pub planned: Isometry3<f64>,
    /// The pose of its own frame, by reports and findings.
    pub container_from_item: KnownPose,
}

impl Packed {
    /// Reads the place of an item; `None` where it is not packed.
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
        let found = item.container_from_item.as_ref();
        let container_from_item = read_required("items.container_from_item", found)?;
        Ok(Some(Self {
            placement: convert::placement::read_resting(placement)?,
            pose: usize::try_from(item.pose).unwrap_or(usize::MAX),
            planned: read_required("items.planned", item.planned.as_ref())?,
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
    u32::try_from(pose).is_ok_and(|pose| match item.allowed_poses.as_slice() {
        [] => pose < item.poses.max(1),
        allowed => allowed.contains(&pose),
    })
}

/// Says whether an item was announced as the other is. The number of its poses is what the cell
/// allowed when it was announced first; that of its order's items is none of its own.
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

/// Enters the state of an item, and keeps nothing of the state before.
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

/// Enters the outcome of an item's decision; `sequence` is the number of the container that it was
/// decided for.
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
    // Nobody knows where it is.
    if Packed::read(item).is_err() {
        enter(item, ItemState::Gone);
    }
}

/// Enters an inspection of an item: where it is, or that it is gone. Says whether it was packed.
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
