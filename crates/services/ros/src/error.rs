//! What keeps a cell from being seen in ROS.

use ppnpack_ros::RosError;
use ppnpack_service::ServiceError;

/// What keeps a cell from being seen in ROS.
#[derive(Debug, thiserror::Error)]
pub(crate) enum FaceError {
    /// Of the side of ROS.
    #[error(transparent)]
    Ros(#[from] RosError),
    /// Of the side of the stack.
    #[error(transparent)]
    Service(#[from] ServiceError),
}
