//! The settling of a placed item, by a simulation.

use ppnpack_packing::checks::trial::Settling;

use crate::error::WireError;
use crate::limits::at_least_zero;
use crate::v1;

/// Reads the settling of an item.
///
/// # Errors
/// [`WireError`] where a number is not finite, or negative.
pub fn read(message: &v1::Settling) -> Result<Settling, WireError> {
    Ok(Settling {
        tilt_rad: at_least_zero("tilt_rad", message.tilt_rad)?,
        slide_m: at_least_zero("slide_m", message.slide_m)?,
        disturbance_m: at_least_zero("disturbance_m", message.disturbance_m)?,
        above_rim_m: at_least_zero("above_rim_m", message.above_rim_m)?,
        is_still: message.is_still,
    })
}

/// Writes the settling of an item.
pub fn write(settling: &Settling) -> v1::Settling {
    v1::Settling {
        tilt_rad: settling.tilt_rad,
        slide_m: settling.slide_m,
        disturbance_m: settling.disturbance_m,
        above_rim_m: settling.above_rim_m,
        is_still: settling.is_still,
    }
}
