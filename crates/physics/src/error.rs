//! Errors of the simulated cell.

use ppnpack_camera::CameraError;
use ppnpack_numbers::SettingError;
use ppnpack_packing::kernel::grid::ContainerSize;
use ppnpack_packing::kernel::heightmap::HeightmapError;

/// Refusal of the simulated cell.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PhysicsError {
    /// A number is outside what is possible.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// A pose is not finite, not rigid, or far away from the container.
    #[error("the planned pose of {model} is {reason}")]
    Pose {
        /// The model to be placed.
        model: String,
        /// The fault of the pose.
        reason: &'static str,
    },
    /// A model has no body that can be simulated.
    #[error("the model {model} cannot be simulated: {reason}")]
    Model {
        /// The model's name.
        model: String,
        /// The fault of the model.
        reason: String,
    },
    /// The grid of a scan is not that of the cell's container.
    #[error("the grid is made for a container of {grid}, but the cell's is {cell}")]
    Grid {
        /// The grid's container.
        grid: ContainerSize,
        /// The cell's container.
        cell: ContainerSize,
    },
    /// The threads of the simulated check cannot be had.
    #[error("the threads that try placements cannot be had: {0}")]
    Threads(String),
    /// A try did not come to its end in time.
    #[error("the time limit passed while a placement was tried")]
    Late,
    /// A camera above the cell is impossible.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// A surface or a heightmap could not be made.
    #[error(transparent)]
    Heightmap(#[from] HeightmapError),
}
