//! Refusals of a calibration.

use std::fmt::Display;

use ppnpack_numbers::SettingError;

/// Why no container was found in a cloud, or the one that was is not trusted, and what to do, in a
/// line for people.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CalibrationError(String);

impl CalibrationError {
    pub(super) fn new(reason: impl Display) -> Self {
        Self(reason.to_string())
    }

    /// Refuses a cloud without a direction along which heights concentrate.
    pub(super) fn no_level() -> Self {
        Self::new("the cloud shows no level surface from above")
    }

    pub(super) fn no_rim() -> Self {
        Self::new(
            "no raised rim encloses a hole with a floor: the whole rim must be seen, from above",
        )
    }

    /// Refuses a cloud in which this share of the floor is seen.
    pub(super) fn no_floor(share: f64) -> Self {
        let percent = 100.0 * share;
        Self(format!(
            "too little of a floor is seen within the rim ({percent:.0} %)"
        ))
    }

    pub(super) fn side_unseen() -> Self {
        Self::new(
            "a side of the container is not seen: neither the inner face of its wall nor its rim's inner edge",
        )
    }
}

impl From<SettingError> for CalibrationError {
    fn from(error: SettingError) -> Self {
        Self::new(error)
    }
}
