//! What goes wrong in talking to ROS.

/// What goes wrong in talking to ROS.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RosError {
    /// A name is none that ROS has.
    #[error(
        "'{0}' is no name of ROS: parts of letters, digits and _ that begin with no digit, each after a /, such as /ppnpack/state"
    )]
    Name(String),
    /// A payload is no message of the type.
    #[error("no {type_name}: {reason}")]
    Malformed {
        /// The type that is read.
        type_name: String,
        /// What is wrong.
        reason: String,
    },
    /// A payload is larger than it may be.
    #[error("{bytes} bytes of {type_name} where {limit} are possible")]
    TooLarge {
        /// The type that is read.
        type_name: String,
        /// How many bytes came.
        bytes: usize,
        /// How many may come.
        limit: usize,
    },
    /// Zenoh refused something.
    #[error("{action}: {reason}")]
    Zenoh {
        /// What was tried.
        action: String,
        /// What Zenoh says.
        reason: String,
    },
}

impl RosError {
    /// What Zenoh refused.
    pub(crate) fn zenoh(action: impl Into<String>, error: &zenoh::Error) -> Self {
        Self::Zenoh {
            action: action.into(),
            reason: error.to_string(),
        }
    }
}
