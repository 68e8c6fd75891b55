//! Why the service did not start.

use ppnpack_service::ServiceError;
use ppnpack_wire::keys::KeyError;

use crate::store::StoreError;

/// Why the service did not start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StartError {
    /// The process lacks something.
    #[error(transparent)]
    Service(#[from] ServiceError),
    /// The sessions cannot be had.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A cell has an impossible name.
    #[error(transparent)]
    Name(#[from] KeyError),
    /// A cell's settings are not possible.
    #[error("{0}")]
    Cell(String),
}
