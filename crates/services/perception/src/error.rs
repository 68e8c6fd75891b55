//! Why the service did not start.

use ppnpack_packing::grid::GridError;
use ppnpack_service::ServiceError;
use ppnpack_wire::keys::KeyError;

/// Why the service did not start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StartError {
    /// The process lacks something.
    #[error(transparent)]
    Service(#[from] ServiceError),
    /// A cell has an impossible name.
    #[error(transparent)]
    Cell(#[from] KeyError),
    /// A camera of ROS 2 cannot be as it is set.
    #[error("ros: {0}")]
    Ros(String),
    /// A grid is not possible.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// There are trays, but nothing is known that could lie there.
    #[error("trays: there are no objects to recognise")]
    NoLibrary,
}
