//! What is wrong with a setting.

/// A setting is not possible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{name} is {value} where {possible} is possible")]
pub struct SettingError {
    /// Its name.
    pub name: &'static str,
    /// What it is.
    pub value: f64,
    /// What it may be.
    pub possible: &'static str,
}

/// Checks a setting.
pub(crate) fn require(
    name: &'static str,
    value: f64,
    possible: &'static str,
    is_possible: impl Fn(f64) -> bool,
) -> Result<(), SettingError> {
    if is_possible(value) {
        Ok(())
    } else {
        Err(SettingError {
            name,
            value,
            possible,
        })
    }
}
