//! Reasons why cells cannot be viewed.

use std::net::SocketAddr;

/// A reason why cells cannot be viewed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// The address is not to be had.
    #[error("{address} cannot be listened on: {reason}; give another address")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// The cause.
        reason: String,
    },
    /// A stream cannot be read.
    #[error(transparent)]
    Service(#[from] ppnpack_service::ServiceError),
    /// A channel cannot be made.
    #[error("a channel cannot be made: {0}")]
    Channel(String),
    /// A thread cannot be had, or ended otherwise than it should.
    #[error("a thread of the view: {0}")]
    Thread(String),
}
