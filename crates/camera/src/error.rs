//! What can be wrong with a camera.

/// A camera or a noise model that is not possible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CameraError {
    /// A number is out of its range.
    #[error("{name} is {value} where {expected} is needed")]
    Setting {
        /// Which number.
        name: &'static str,
        /// What it is.
        value: f64,
        /// What is possible.
        expected: &'static str,
    },
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

/// Checks one number.
pub(crate) fn require(
    name: &'static str,
    value: f64,
    expected: &'static str,
    is_possible: impl Fn(f64) -> bool,
) -> Result<(), CameraError> {
    if value.is_finite() && is_possible(value) {
        Ok(())
    } else {
        Err(CameraError::Setting {
            name,
            value,
            expected,
        })
    }
}
