//! Poses as they are sent to pages.

use nalgebra::Isometry3;
use ppnpack_wire::{convert, v1};
use serde::Serialize;

/// A rigid transform: the origin of its second frame in the first, in metres, and the turn as a
/// unit quaternion x, y, z, w.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct PosePart {
    position_m: [f64; 3],
    orientation: [f64; 4],
}

impl From<&Isometry3<f64>> for PosePart {
    fn from(pose: &Isometry3<f64>) -> Self {
        Self {
            position_m: pose.translation.vector.into(),
            orientation: pose.rotation.coords.into(),
        }
    }
}

/// Reads a pose of a message; `None` where there is none, or an impossible one.
pub(super) fn read(pose: Option<&v1::Pose>) -> Option<Isometry3<f64>> {
    convert::pose::read_required("pose", pose).ok()
}
