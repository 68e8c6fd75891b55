//! What settings may be.

use ppnpack_numbers::{SettingError, require};

/// Checks a length.
pub(crate) fn length(name: &str, length_m: f64) -> Result<(), SettingError> {
    require(name, length_m, "0 to 1 m", |length_m| {
        (0.0..=1.0).contains(&length_m)
    })
}

/// Checks a share.
pub(crate) fn share(name: &str, share: f64) -> Result<(), SettingError> {
    require(name, share, "0 to 1", |share| (0.0..=1.0).contains(&share))
}
