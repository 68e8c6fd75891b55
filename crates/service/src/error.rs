//! Why something of the process did not work.

use std::net::SocketAddr;

use ppnpack_wire::keys::KeyError;

/// What went wrong in running a process.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServiceError {
    /// Zenoh refused something.
    #[error("{action}: {reason}")]
    Zenoh {
        /// What was tried.
        action: String,
        /// What Zenoh says.
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
        /// What the system says.
        source: std::io::Error,
    },
    /// Logs or traces cannot be set up.
    #[error("{what} cannot be set up: {reason}")]
    Observability {
        /// Logs, traces or metrics.
        what: &'static str,
        /// Why.
        reason: String,
    },
    /// The service cannot start as it is set, or with what it was given: says why.
    #[error("{0}")]
    Start(String),
    /// The system gives no thread, or none of its means.
    #[error("{what}: {source}")]
    System {
        /// What was asked of it.
        what: &'static str,
        /// What it says.
        source: std::io::Error,
    },
}

impl ServiceError {
    /// What keeps a service from its start.
    pub fn start(reason: impl std::fmt::Display) -> Self {
        Self::Start(reason.to_string())
    }

    /// What Zenoh refused.
    pub(crate) fn zenoh(action: impl Into<String>, error: &zenoh::Error) -> Self {
        Self::Zenoh {
            action: action.into(),
            reason: error.to_string(),
        }
    }

    /// Logs or traces that cannot be set up.
    pub(crate) fn observability(what: &'static str, error: &dyn std::fmt::Display) -> Self {
        let reason = error.to_string();
        Self::Observability { what, reason }
    }
}
