//! The reasons for which a message is refused.

use std::fmt::Display;

/// The fault of a message.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WireError {
    /// It is too large to be read.
    #[error("a {message} of {bytes} bytes is too large: {limit} are possible")]
    TooLarge {
        /// The message.
        message: &'static str,
        /// Its size.
        bytes: usize,
        /// The maximum.
        limit: usize,
    },
    /// It has more parts than any sensible message of its size.
    #[error("a {message} of more than {limit} parts is not looked at")]
    TooManyParts {
        /// The message.
        message: &'static str,
        /// The maximum.
        limit: usize,
    },
    /// It is no protobuf message of its kind.
    #[error("not a {message}: {reason}")]
    Malformed {
        /// The expected kind.
        message: &'static str,
        /// The reason, by the decoder.
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
        /// The fault, and the possible values.
        reason: String,
    },
}

impl WireError {
    /// Refuses the value of a field.
    pub fn invalid(field: &'static str, reason: impl Display) -> Self {
        let reason = reason.to_string();
        Self::Invalid { field, reason }
    }

    /// Refuses a message that is none of its kind.
    pub(crate) fn malformed(message: &'static str, reason: impl Display) -> Self {
        let reason = reason.to_string();
        Self::Malformed { message, reason }
    }
}

/// Checks the size of a message before it is put together.
///
/// # Errors
/// [`WireError::TooLarge`] where it has more than `limit` bytes.
pub fn check_size(message: &'static str, bytes: usize, limit: usize) -> Result<(), WireError> {
    if bytes <= limit {
        return Ok(());
    }
    Err(WireError::TooLarge {
        message,
        bytes,
        limit,
    })
}

/// Gives a field that has to be there.
///
/// # Errors
/// [`WireError::Missing`] where it is not.
pub fn needed<'a, T>(field: &'static str, value: Option<&'a T>) -> Result<&'a T, WireError> {
    value.ok_or(WireError::Missing { field })
}
