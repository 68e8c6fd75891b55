//! Why a message was refused.

/// What is wrong with a message.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WireError {
    /// It is too large to be looked at.
    #[error("a {message} of {bytes} bytes is too large: {limit} are possible")]
    TooLarge {
        /// The message.
        message: &'static str,
        /// Its size.
        bytes: usize,
        /// The greatest possible.
        limit: usize,
    },
    /// It has more parts than any sensible message of its size.
    #[error("a {message} of more than {limit} parts is not looked at")]
    TooManyParts {
        /// The message.
        message: &'static str,
        /// The most possible.
        limit: usize,
    },
    /// It is no protobuf message of its kind.
    #[error("not a {message}: {reason}")]
    Malformed {
        /// What was expected.
        message: &'static str,
        /// What the decoder says.
        reason: String,
    },
    /// A field that is needed is not there.
    #[error("{field} is missing")]
    Missing {
        /// The field.
        field: &'static str,
    },
    /// A field has a value that is not possible.
    #[error("{field}: {reason}")]
    Invalid {
        /// The field.
        field: &'static str,
        /// What is wrong, and what would be right.
        reason: String,
    },
}

impl WireError {
    /// A field with an impossible value.
    pub fn invalid(field: &'static str, reason: impl std::fmt::Display) -> Self {
        Self::Invalid {
            field,
            reason: reason.to_string(),
        }
    }
}

/// A field that has to be there.
///
/// # Errors
/// [`WireError::Missing`] where it is not.
pub fn needed<'a, T>(field: &'static str, value: Option<&'a T>) -> Result<&'a T, WireError> {
    value.ok_or(WireError::Missing { field })
}
