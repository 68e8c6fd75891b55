//! The loads on items.

use ppnpack_packing::checks::loads::Load;

use crate::error::WireError;
use crate::limits::at_least_zero;
use crate::v1;

/// Reads the load on an item.
///
/// # Errors
/// [`WireError`] where a number is not finite, or negative.
pub fn read(message: &v1::Load) -> Result<Load, WireError> {
    Ok(Load {
        item: message.item_id.clone(),
        estimated_kg: at_least_zero("load.estimated_kg", message.estimated_kg)?,
        carries_kg: at_least_zero("load.carries_kg", message.carries_kg)?,
    })
}

/// Writes the load on an item.
pub fn write(load: &Load) -> v1::Load {
    v1::Load {
        item_id: load.item.clone(),
        estimated_kg: load.estimated_kg,
        carries_kg: load.carries_kg,
    }
}
