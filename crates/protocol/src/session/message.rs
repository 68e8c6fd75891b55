//! Sessions as messages: on the wire, and on disk.

use nalgebra::Isometry3;
use ppnpack_packing::blocked::BlockedRegion;
use ppnpack_wire::error::WireError;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::{convert, v1};

use super::{End, ItemState, Lying, Rules, Session, SessionItem};

impl Session {
    /// The session as a message; `buffer` is how many of its waiting items may be chosen from.
    pub fn to_message(&self, buffer: usize) -> v1::Session {
        let (end, reasons, failure) = match &self.end {
            None => (v1::SessionEnd::Unspecified, Vec::new(), String::new()),
            Some(End::AllPacked) => (v1::SessionEnd::AllPacked, Vec::new(), String::new()),
            Some(End::OthersSetAside) => {
                (v1::SessionEnd::OthersSetAside, Vec::new(), String::new())
            }
            Some(End::NothingFits(reasons)) => {
                (v1::SessionEnd::NothingFits, reasons.clone(), String::new())
            }
            Some(End::Failed(failure)) => (v1::SessionEnd::Failed, Vec::new(), failure.clone()),
        };
        v1::Session {
            session_id: self.id.clone(),
            items: self.items.iter().map(write_item).collect(),
            pending: self.pending.clone(),
            step: self.step,
            is_automatic: self.is_automatic,
            keep_out: self.keep_out.iter().map(write_region).collect(),
            buffer: number(buffer),
            end: end.into(),
            reasons,
            failure,
            least_state_number: self.least_state_number,
            settled: self.settled.clone(),
            mean_cycle_s: self.mean_cycle_s().unwrap_or_default(),
            set_aside_limit: number(self.set_aside_limit),
            set_aside: self.reasons_set_aside().cloned().collect(),
            past_session_ids: self.past.clone(),
        }
    }

    /// The session of a message.
    pub fn from_message(message: v1::Session) -> Result<Self, WireError> {
        let known = v1::SessionEnd::try_from(message.end);
        let end = known.map_err(|_| {
            let reason = "it is none that this version knows: a newer one wrote it";
            WireError::invalid("end", reason)
        })?;
        let end = match end {
            v1::SessionEnd::Unspecified => None,
            v1::SessionEnd::AllPacked => Some(End::AllPacked),
            v1::SessionEnd::OthersSetAside => Some(End::OthersSetAside),
            v1::SessionEnd::NothingFits => Some(End::NothingFits(message.reasons)),
            v1::SessionEnd::Failed => Some(End::Failed(message.failure)),
        };
        let items = message.items.iter().map(read_item);
        Ok(Self {
            items: items.collect::<Result<_, _>>()?,
            keep_out: message.keep_out.iter().map(read_region).collect(),
            id: message.session_id,
            pending: message.pending,
            step: message.step,
            is_automatic: message.is_automatic,
            end,
            least_state_number: message.least_state_number,
            settled: message.settled,
            set_aside_limit: count(message.set_aside_limit),
            past: message.past_session_ids,
        })
    }
}

/// A count or index as it is written.
fn number(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

/// A count or index as it is read.
fn count(number: u32) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}

/// A region of a message.
pub fn read_region(region: &v1::Region) -> BlockedRegion {
    BlockedRegion {
        x_min_m: region.x_min_m,
        y_min_m: region.y_min_m,
        x_max_m: region.x_max_m,
        y_max_m: region.y_max_m,
    }
}

fn write_region(region: &BlockedRegion) -> v1::Region {
    v1::Region {
        x_min_m: region.x_min_m,
        y_min_m: region.y_min_m,
        x_max_m: region.x_max_m,
        y_max_m: region.y_max_m,
    }
}

/// The rules of a message; none where it has none.
pub fn read_rules(rules: Option<&v1::ItemRules>) -> Rules {
    rules.map_or_else(Rules::default, |rules| Rules {
        is_fragile: rules.is_fragile,
        is_bottom_only: rules.is_bottom_only,
        is_upright: rules.is_upright,
    })
}

/// Origins that are nearer to each other than this are the same, in metres.
const SAME_ORIGIN_M: f64 = 1e-6;

/// How an item lies, by the poses of its announcement.
pub fn read_lying(
    heightmap_from_item: Option<&v1::Pose>,
    waits_at: Option<&v1::Pose>,
) -> Result<Lying, WireError> {
    let read = |field, pose: Option<&v1::Pose>| match pose {
        Some(pose) => convert::pose::read_required(field, Some(pose)).map(Some),
        None => Ok(None),
    };
    let field = "items.heightmap_from_item";
    let heightmap_from_item = read(field, heightmap_from_item)?;
    let shift_m = heightmap_from_item.map_or(0.0, |frame| frame.translation.vector.norm());
    if shift_m > SAME_ORIGIN_M {
        return Err(WireError::invalid(
            field,
            "only a rotation is possible: both frames have the same origin",
        ));
    }
    Ok(Lying {
        heightmap_from_item,
        waits_at: read("items.waits_at", waits_at)?,
    })
}

fn write_item(item: &SessionItem) -> v1::SessionItem {
    let rules = (item.rules != Rules::default()).then_some(v1::ItemRules {
        is_fragile: item.rules.is_fragile,
        is_bottom_only: item.rules.is_bottom_only,
        is_upright: item.rules.is_upright,
    });
    let frame = |pose: &Option<Isometry3<f64>>| pose.as_ref().map(convert::pose::write);
    let state = match &item.state {
        ItemState::Waiting => v1::ItemState::Waiting,
        ItemState::Decided => v1::ItemState::Decided,
        ItemState::Packed { .. } => v1::ItemState::Packed,
        ItemState::Gone => v1::ItemState::Gone,
        ItemState::Withdrawn => v1::ItemState::Withdrawn,
        ItemState::SetAside { .. } => v1::ItemState::SetAside,
    };
    let mut message = v1::SessionItem {
        item_id: item.item_id.clone(),
        object: item.object.clone(),
        state: state.into(),
        rules,
        shape: item.shape.to_bytes(),
        heightmap_from_item: frame(&item.lying.heightmap_from_item),
        waits_at: frame(&item.lying.waits_at),
        poses: match item.poses {
            ..=1 => 0,
            poses => number(poses),
        },
        allowed_poses: item
            .allowed_poses
            .iter()
            .map(|pose| number(*pose))
            .collect(),
        inspection: item.inspection.clone(),
        ..v1::SessionItem::default()
    };
    match &item.state {
        ItemState::Packed {
            placement,
            pose,
            planned,
            container_from_item,
            cycle_s,
        } => {
            message.pose = number(*pose);
            message.cycle_s = cycle_s.unwrap_or_default();
            message.placement = Some(convert::placement::write_resting(placement));
            message.planned = Some(convert::pose::write(planned));
            message.container_from_item = Some(convert::pose::write(container_from_item));
        }
        ItemState::SetAside { reason, step } => {
            message.set_aside = Some(reason.clone());
            message.set_aside_step = *step;
        }
        ItemState::Waiting | ItemState::Decided | ItemState::Gone | ItemState::Withdrawn => {}
    }
    message
}

fn read_item(message: &v1::SessionItem) -> Result<SessionItem, WireError> {
    let state = match message.state() {
        v1::ItemState::Waiting => ItemState::Waiting,
        v1::ItemState::Decided => ItemState::Decided,
        v1::ItemState::Withdrawn => ItemState::Withdrawn,
        v1::ItemState::Packed => read_packed(message)?,
        v1::ItemState::SetAside => read_set_aside(message)?,
        v1::ItemState::Gone => ItemState::Gone,
        v1::ItemState::Unspecified => {
            let reason = "it is none that this version knows: a newer one wrote it";
            return Err(WireError::invalid("items.state", reason));
        }
    };
    Ok(SessionItem {
        item_id: message.item_id.clone(),
        object: message.object.clone(),
        shape: ItemId::from_bytes("items.shape", &message.shape)?,
        rules: read_rules(message.rules.as_ref()),
        lying: read_lying(
            message.heightmap_from_item.as_ref(),
            message.waits_at.as_ref(),
        )?,
        poses: count(message.poses).max(1),
        allowed_poses: message
            .allowed_poses
            .iter()
            .map(|pose| count(*pose))
            .collect(),
        state,
        inspection: message.inspection.clone(),
    })
}

fn read_set_aside(message: &v1::SessionItem) -> Result<ItemState, WireError> {
    let reason = message.set_aside.clone().ok_or(WireError::Missing {
        field: "items.set_aside",
    })?;
    Ok(ItemState::SetAside {
        reason,
        step: message.set_aside_step,
    })
}

fn read_packed(message: &v1::SessionItem) -> Result<ItemState, WireError> {
    let placement = message.placement.as_ref().ok_or(WireError::Missing {
        field: "items.placement",
    })?;
    let pose = |field, pose: &Option<v1::Pose>| convert::pose::read_required(field, pose.as_ref());
    Ok(ItemState::Packed {
        placement: convert::placement::read_resting(placement)?,
        pose: count(message.pose),
        planned: pose("items.planned", &message.planned)?,
        container_from_item: pose("items.container_from_item", &message.container_from_item)?,
        // No cycle takes no time.
        cycle_s: Some(message.cycle_s).filter(|cycle_s| *cycle_s > 0.0),
    })
}
