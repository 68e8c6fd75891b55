//! Faults of cameras.

use ppnpack_numbers::SettingError;

/// A camera or a noise model that is not possible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CameraError {
    /// A number is out of its range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The pose is no rigid transform of finite numbers.
    #[error("the camera's pose is not a rigid transform of finite numbers")]
    Pose,
    /// There are more triangles than pixels can name.
    #[error("the scene has more than {limit} triangles")]
    SceneTooLarge {
        /// The greatest number possible.
        limit: usize,
    },
}
