//! Refusals of an arm's parameters or a cell's settings.

use ppnpack_numbers::SettingError;

/// The fault of a parameter file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ParameterError {
    /// The text is no TOML of the known fields.
    #[error("the arm's parameters cannot be read: {0}")]
    Format(#[from] toml::de::Error),
    /// A number is outside what is possible.
    #[error(transparent)]
    Value(#[from] SettingError),
    /// A parameter file cannot be read.
    #[error("the arm's parameter file {path} cannot be read: {reason}")]
    File {
        /// The file.
        path: String,
        /// The cause.
        reason: String,
    },
    /// No arm of this name is built in.
    #[error("there is no built-in arm '{name}'; there are {}", known.join(", "))]
    UnknownArm {
        /// The name that was asked for.
        name: String,
        /// The names that there are.
        known: Vec<&'static str>,
    },
}
