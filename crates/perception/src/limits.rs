//! What settings may be.

/// A setting that is not possible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{name} is {value} where {expected} is possible")]
pub struct SettingError {
    name: &'static str,
    value: f64,
    expected: &'static str,
}

impl SettingError {
    pub(crate) fn new(name: &'static str, value: f64, expected: &'static str) -> Self {
        Self {
            name,
            value,
            expected,
        }
    }
}

/// Checks a length.
pub(crate) fn length(name: &'static str, length_m: f64) -> Result<(), SettingError> {
    if (0.0..=1.0).contains(&length_m) {
        Ok(())
    } else {
        Err(SettingError::new(name, length_m, "0 to 1 m"))
    }
}

/// Checks a share.
pub(crate) fn share(name: &'static str, share: f64) -> Result<(), SettingError> {
    if (0.0..=1.0).contains(&share) {
        Ok(())
    } else {
        Err(SettingError::new(name, share, "0 to 1"))
    }
}
