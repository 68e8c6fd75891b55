//! Sessions as messages: on the wire, and on disk.

use nalgebra::Isometry3;
use ppnpack_packing::blocked::BlockedRegion;
use ppnpack_wire::error::WireError;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::{convert, header, v1};

use super::{Container, End, ItemState, Lying, Rules, Session, SessionItem, Stand};
use crate::placing::KnownPose;

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
        let first = self.containers.first();
        v1::Session {
            session_id: self.id.clone(),
            items: self.items.iter().map(write_item).collect(),
            pending: self.pending.clone(),
            step: self.step,
            is_automatic: self.is_automatic,
            keep_out: first.map_or_else(Vec::new, |first| first.keep_out.clone()),
            buffer: number(buffer),
            end: end.into(),
            reasons,
            failure,
            least_state_number: first.map_or(0, |first| first.least_state_number),
            settled: self.settled.clone(),
            mean_cycle_s: self.mean_cycle_s().unwrap_or_default(),
            set_aside_limit: number(self.set_aside_limit),
            set_aside: self.reasons_set_aside().cloned().collect(),
            past_session_ids: self.past.clone(),
            containers: self.containers.iter().map(write_container).collect(),
            closed: self.closed.clone(),
            forgotten_items: self.forgotten as u64,
        }
    }

    /// The session of a message.
    pub fn from_message(message: v1::Session) -> Result<Self, WireError> {
        let known = v1::SessionEnd::try_from(message.end);
        let end = known.map_err(|_| is_newer("end"))?;
        let end = match end {
            v1::SessionEnd::Unspecified => None,
            v1::SessionEnd::AllPacked => Some(End::AllPacked),
            v1::SessionEnd::OthersSetAside => Some(End::OthersSetAside),
            v1::SessionEnd::NothingFits => Some(End::NothingFits(message.reasons)),
            v1::SessionEnd::Failed => Some(End::Failed(message.failure)),
        };
        let is_unknown =
            |closed: &v1::ClosedContainer| closed.reason() == v1::ClosingReason::Unspecified;
        if message.closed.iter().any(is_unknown) {
            return Err(is_newer("closed.reason"));
        }
        let items = message.items.iter().map(read_item);
        Ok(Self {
            items: items.collect::<Result<_, _>>()?,
            containers: message.containers.iter().map(read_container).collect(),
            closed: message.closed,
            forgotten: usize::try_from(message.forgotten_items).unwrap_or_default(),
            id: message.session_id,
            pending: message.pending,
            step: message.step,
            is_automatic: message.is_automatic,
            end,
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

fn write_container(container: &Container) -> v1::SessionContainer {
    v1::SessionContainer {
        container: container.name.clone(),
        sequence: container.sequence,
        is_open: container.is_open(),
        renewal_id: container.renewal_id().unwrap_or_default().to_owned(),
        keep_out: container.keep_out.clone(),
        least_state_number: container.least_state_number,
    }
}

fn read_container(message: &v1::SessionContainer) -> Container {
    Container {
        name: message.container.clone(),
        sequence: message.sequence,
        stand: read_stand(message),
        keep_out: message.keep_out.clone(),
        least_state_number: message.least_state_number,
    }
}

fn read_stand(message: &v1::SessionContainer) -> Stand {
    match message.renewal_id.as_str() {
        _ if message.is_open => Stand::Open,
        "" => Stand::Closed,
        id => Stand::Renewing(id.to_owned()),
    }
}

/// Refuses an enum's value that this version does not know.
fn is_newer(field: &'static str) -> WireError {
    let reason = "it is none that this version knows: a newer one wrote it";
    WireError::invalid(field, reason)
}

/// Regions of a message.
pub fn read_regions(regions: &[v1::Region]) -> Vec<BlockedRegion> {
    regions.iter().map(read_region).collect()
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

/// The heaviest that an item can be, and the most that it can carry, in kilograms.
const MOST_KG: f64 = 10_000.0;

/// The rules of a message; none where it has none.
///
/// # Errors
/// [`WireError`] where no item can carry so much.
pub fn read_rules(rules: Option<&v1::ItemRules>) -> Result<Rules, WireError> {
    let Some(rules) = rules else {
        return Ok(Rules::default());
    };
    if let Some(carries_kg) = rules.carries_kg {
        mass("items.rules.carries_kg", carries_kg)?;
    }
    Ok(Rules {
        is_fragile: rules.is_fragile,
        is_bottom_only: rules.is_bottom_only,
        is_upright: rules.is_upright,
        carries_kg: rules.carries_kg,
    })
}

/// Rules as a message; `None` where there are none.
pub fn write_rules(rules: &Rules) -> Option<v1::ItemRules> {
    (*rules != Rules::default()).then_some(v1::ItemRules {
        is_fragile: rules.is_fragile,
        is_bottom_only: rules.is_bottom_only,
        is_upright: rules.is_upright,
        carries_kg: rules.carries_kg,
    })
}

/// Checks a mass in kilograms.
fn mass(field: &'static str, mass_kg: f64) -> Result<f64, WireError> {
    if (0.0..=MOST_KG).contains(&mass_kg) {
        return Ok(mass_kg);
    }
    let reason = format_args!("{mass_kg} kg where 0 to {MOST_KG} are possible");
    Err(WireError::invalid(field, reason))
}

/// Checks what an item belongs to; that is nothing where the message is not there.
pub fn read_order_line(message: Option<&v1::OrderLine>) -> Result<v1::OrderLine, WireError> {
    let line = message.cloned().unwrap_or_default();
    for (field, name) in [
        ("items.order_line.order", &line.order),
        ("items.order_line.group", &line.group),
    ] {
        if !name.is_empty() {
            header::id(field, name)?;
        }
    }
    if !line.bundle.is_empty() || line.urgency > 0 {
        let reason = "bundle and urgency are known no more: give groups of rules.together, and announce first what is urgent";
        return Err(WireError::invalid("items.order_line", reason));
    }
    mass("items.order_line.mass_kg", line.mass_kg)?;
    if line.order_items > 0 && line.order.is_empty() {
        let reason = "of which order they are has to be said: give order, too";
        return Err(WireError::invalid("items.order_line.order_items", reason));
    }
    Ok(line)
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
    let frame = |pose: &Option<Isometry3<f64>>| pose.as_ref().map(convert::pose::write);
    let mut message = v1::SessionItem {
        item_id: item.item_id.clone(),
        arrival: item.arrival as u64,
        object: item.object.clone(),
        order_line: (item.order_line != v1::OrderLine::default())
            .then(|| Box::new(item.order_line.clone())),
        rules: write_rules(&item.rules),
        shape: item.shape.to_bytes(),
        heightmap_from_item: frame(&item.lying.heightmap_from_item),
        waits_at: frame(&item.lying.waits_at).map(Box::new),
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
    let state = match &item.state {
        ItemState::Waiting => v1::ItemState::Waiting,
        ItemState::Decided => v1::ItemState::Decided,
        ItemState::Gone => v1::ItemState::Gone,
        ItemState::Withdrawn => v1::ItemState::Withdrawn,
        ItemState::Packed {
            placement,
            pose,
            planned,
            container_from_item,
            cycle_s,
            load,
            container,
            sequence,
        } => {
            let load = load.as_ref().map(convert::load::write);
            message.load = load.map(Box::new);
            message.container.clone_from(container);
            message.container_sequence = *sequence;
            message.pose = number(*pose);
            message.cycle_s = cycle_s.unwrap_or_default();
            message.placement = Some(convert::placement::write_resting(placement));
            message.planned = Some(convert::pose::write(planned));
            let pose = convert::pose::write(container_from_item.isometry());
            message.container_from_item = Some(pose);
            message.is_found = container_from_item.is_found();
            v1::ItemState::Packed
        }
        ItemState::SetAside { reason, step } => {
            message.set_aside = Some(reason.clone());
            message.set_aside_step = *step;
            v1::ItemState::SetAside
        }
    };
    message.set_state(state);
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
        v1::ItemState::Unspecified => return Err(is_newer("items.state")),
    };
    Ok(SessionItem {
        item_id: message.item_id.clone(),
        arrival: usize::try_from(message.arrival).unwrap_or(usize::MAX),
        object: message.object.clone(),
        shape: ItemId::from_bytes("items.shape", &message.shape)?,
        rules: read_rules(message.rules.as_ref())?,
        order_line: read_order_line(message.order_line.as_deref())?,
        lying: read_lying(
            message.heightmap_from_item.as_ref(),
            message.waits_at.as_deref(),
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
    let container_from_item = pose("items.container_from_item", &message.container_from_item)?;
    Ok(ItemState::Packed {
        placement: convert::placement::read_resting(placement)?,
        pose: count(message.pose),
        planned: pose("items.planned", &message.planned)?,
        container_from_item: KnownPose::new(container_from_item, message.is_found),
        // No cycle takes no time.
        cycle_s: Some(message.cycle_s).filter(|cycle_s| *cycle_s > 0.0),
        load: message
            .load
            .as_deref()
            .map(convert::load::read)
            .transpose()?,
        container: message.container.clone(),
        sequence: message.container_sequence,
    })
}
