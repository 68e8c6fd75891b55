//! Why an arm's parameters or a cell's settings are not possible.

/// What is wrong with a parameter file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ParameterError {
    /// The text is no TOML of the known fields.
    #[error("the arm's parameters cannot be read: {0}")]
    Format(#[from] toml::de::Error),
    /// A number is outside what is possible.
    #[error("{field} must be {expected}, but is {value}")]
    Value {
        /// The field, as a path into the file.
        field: String,
        /// What is possible.
        expected: &'static str,
        /// What was given.
        value: f64,
    },
    /// A parameter file cannot be read.
    #[error("the arm's parameter file {path} cannot be read: {reason}")]
    File {
        /// The file.
        path: String,
        /// What went wrong.
        reason: String,
    },
    /// No arm of this name is built in.
    #[error("there is no built-in arm '{name}'; there are {}", crate::arms::names().collect::<Vec<_>>().join(", "))]
    UnknownArm {
        /// The name that was asked for.
        name: String,
    },
}

/// Refuses a number that is not finite or fails a condition.
pub(crate) fn require(
    field: impl FnOnce() -> String,
    value: f64,
    expected: &'static str,
    holds: impl FnOnce(f64) -> bool,
) -> Result<f64, ParameterError> {
    if value.is_finite() && holds(value) {
        Ok(value)
    } else {
        Err(ParameterError::Value {
            field: field(),
            expected,
            value,
        })
    }
}
