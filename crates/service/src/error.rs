//! Errors of a process.

use std::net::SocketAddr;

use ppnpack_wire::keys::KeyError;

/// An error in running a process.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServiceError {
    /// Zenoh refused something, as it does where the session is closed.
    #[error("{action}: {reason}")]
    Zenoh {
        /// The action that was tried.
        action: String,
        /// The reason, by Zenoh.
        reason: String,
    },
    /// A name is not possible.
    #[error(transparent)]
    Key(#[from] KeyError),
    /// A setting is not possible.
    #[error(transparent)]
    Configuration(#[from] crate::configuration::ConfigurationError),
    /// The admin port cannot be opened.
    #[error(
        "the admin port {address} cannot be opened: {source}; set admin.listen to a free one, or to \"off\""
    )]
    Admin {
        /// The address.
        address: SocketAddr,
        /// The reason, by the system.
        source: std::io::Error,
    },
    /// The service cannot start as it is set, or with what it was given.
    #[error("{0}")]
    Start(String),
    /// The system gives no thread, or none of its means.
    #[error("{what}: {source}")]
    System {
        /// The action that was tried.
        what: &'static str,
        /// The reason.
        source: std::io::Error,
    },
}

impl ServiceError {
    /// Makes an error that keeps a service from its start.
    pub fn start(reason: impl std::fmt::Display) -> Self {
        Self::Start(reason.to_string())
    }

    pub(crate) fn zenoh(action: impl Into<String>, error: &zenoh::Error) -> Self {
        Self::Zenoh {
            action: action.into(),
            reason: error.to_string(),
        }
    }
}
