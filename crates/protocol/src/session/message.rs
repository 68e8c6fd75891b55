//! Sessions as messages: on the wire, and on disk.

use ppnpack_packing::ranking::candidate::{Lying, Rules};
use ppnpack_packing::scene::blocked::BlockedRegion;
use ppnpack_wire::error::WireError;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::{convert, header, v1};

use super::{Packed, Session};

impl Session {
    /// Writes the session as a message; `buffer` is the number of waiting items to choose from.
    pub fn to_message(&self, buffer: usize) -> v1::Session {
        let Self(own) = self;
        let first = own.containers.first();
        v1::Session {
            keep_out: first.map_or_else(Vec::new, |first| first.keep_out.clone()),
            buffer: u32::try_from(buffer).unwrap_or(u32::MAX),
            least_state_number: first.map_or(0, |first| first.least_state_number),
            mean_cycle_s: self.mean_cycle_s().unwrap_or_default(),
            set_aside: self.reasons_set_aside().cloned().collect(),
            failure_id: self.failure_id().unwrap_or_default(),
            ..own.clone()
        }
    }

    /// Reads the session of a message.
    ///
    /// # Errors
    /// [`WireError`] where it is none that this version knows.
    pub fn from_message(message: v1::Session) -> Result<Self, WireError> {
        v1::SessionEnd::try_from(message.end).map_err(|_| is_newer("end"))?;
        message.items.iter().try_for_each(check_item)?;
        let mut closed = message.closed.iter();
        if closed.any(|closed| closed.reason() == v1::ClosingReason::Unspecified) {
            return Err(is_newer("closed.reason"));
        }
        // These follow from the rest.
        Ok(Self(v1::Session {
            keep_out: Vec::new(),
            buffer: 0,
            least_state_number: 0,
            mean_cycle_s: 0.0,
            set_aside: Vec::new(),
            failure_id: String::new(),
            ..message
        }))
    }
}

fn check_item(item: &v1::SessionItem) -> Result<(), WireError> {
    match item.state() {
        v1::ItemState::Unspecified => return Err(is_newer("items.state")),
        v1::ItemState::SetAside if item.set_aside.is_none() => {
            let field = "items.set_aside";
            return Err(WireError::Missing { field });
        }
        _ => {}
    }
    Packed::read(item)?;
    ItemId::from_bytes("items.shape", &item.shape)?;
    read_rules(item.rules.as_ref())?;
    read_order_line(item.order_line.as_deref())?;
    read_lying(item.heightmap_from_item.as_ref(), item.waits_at.as_deref())?;
    Ok(())
}

/// Refuses an enum's value that this version does not know.
fn is_newer(field: &'static str) -> WireError {
    let reason = "it is none that this version knows: a newer one wrote it";
    WireError::invalid(field, reason)
}

/// Reads regions of a message.
pub fn read_regions(regions: &[v1::Region]) -> Vec<BlockedRegion> {
    let read = |region: &v1::Region| BlockedRegion {
        x_min_m: region.x_min_m,
        y_min_m: region.y_min_m,
        x_max_m: region.x_max_m,
        y_max_m: region.y_max_m,
    };
    regions.iter().map(read).collect()
}

/// Maximum mass of an item, and of the load on it, in kilograms.
const MOST_KG: f64 = 10_000.0;

/// Reads the rules of a message; none where it has none.
///
/// # Errors
/// [`WireError`] where no item can carry so much.
pub fn read_rules(rules: Option<&v1::ItemRules>) -> Result<Rules, WireError> {
    let Some(rules) = rules else {
        return Ok(Rules::default());
    };
    if let Some(carries_kg) = rules.carries_kg {
        check_mass("items.rules.carries_kg", carries_kg)?;
    }
    Ok(Rules {
        is_fragile: rules.is_fragile,
        is_bottom_only: rules.is_bottom_only,
        is_upright: rules.is_upright,
        carries_kg: rules.carries_kg,
    })
}

/// Writes rules as a message; `None` where there are none.
pub fn write_rules(rules: &Rules) -> Option<v1::ItemRules> {
    (*rules != Rules::default()).then_some(v1::ItemRules {
        is_fragile: rules.is_fragile,
        is_bottom_only: rules.is_bottom_only,
        is_upright: rules.is_upright,
        carries_kg: rules.carries_kg,
    })
}

/// Checks a mass in kilograms.
fn check_mass(field: &'static str, mass_kg: f64) -> Result<(), WireError> {
    if (0.0..=MOST_KG).contains(&mass_kg) {
        return Ok(());
    }
    let reason = format_args!("{mass_kg} kg where 0 to {MOST_KG} are possible");
    Err(WireError::invalid(field, reason))
}

/// Reads the order of an item; none where there is no message.
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
    check_mass("items.order_line.mass_kg", line.mass_kg)?;
    if line.order_items > 0 && line.order.is_empty() {
        let reason = "of which order they are has to be said: give order, too";
        return Err(WireError::invalid("items.order_line.order_items", reason));
    }
    Ok(line)
}

/// Maximum distance of origins that count as the same, in metres.
const SAME_ORIGIN_M: f64 = 1e-6;

/// Reads the lying of an item from the poses of its announcement.
pub fn read_lying(
    heightmap_from_item: Option<&v1::Pose>,
    waits_at: Option<&v1::Pose>,
) -> Result<Lying, WireError> {
    let read = |field, pose: Option<&v1::Pose>| {
        let pose = pose.map(|pose| convert::pose::read_required(field, Some(pose)));
        pose.transpose()
    };
    let field = "items.heightmap_from_item";
    let heightmap_from_item = read(field, heightmap_from_item)?;
    let shift_m = heightmap_from_item.map_or(0.0, |frame| frame.translation.vector.norm());
    if shift_m > SAME_ORIGIN_M {
        let reason = "only a rotation is possible: both frames have the same origin";
        return Err(WireError::invalid(field, reason));
    }
    Ok(Lying {
        heightmap_from_item,
        waits_at: read("items.waits_at", waits_at)?,
    })
}
