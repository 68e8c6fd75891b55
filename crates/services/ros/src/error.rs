//! Faults in talking to ROS.

use std::fmt::Display;

use ppnpack_service::ServiceError;

use crate::rmw::messages::Message;

/// A reason why a cell is not seen in ROS.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RosError {
    /// A name is none that ROS has.
    #[error(
        "'{0}' is no name of ROS: parts of letters, digits and _ that begin with no digit, each after a /, such as /ppnpack/state"
    )]
    Name(String),
    /// A payload is no message of the type, or a message is no payload.
    #[error("no {name}: {reason}")]
    Message { name: &'static str, reason: String },
    /// Zenoh refused something.
    #[error("{key}: {reason}")]
    Zenoh {
        /// The key that was declared or sent to.
        key: String,
        reason: String,
    },
    /// The side of the stack failed.
    #[error(transparent)]
    Service(#[from] ServiceError),
}

impl RosError {
    /// Gives the reason why something is no message of a type.
    pub(crate) fn message<M: Message>(reason: impl Display) -> Self {
        let (name, reason) = (M::NAME, reason.to_string());
        Self::Message { name, reason }
    }

    pub(crate) fn zenoh(key: impl Display, error: &zenoh::Error) -> Self {
        let (key, reason) = (key.to_string(), error.to_string());
        Self::Zenoh { key, reason }
    }
}
