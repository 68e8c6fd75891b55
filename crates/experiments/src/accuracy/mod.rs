//! How accurate each part is, in simulated views: heightmaps, calibration, recognition, inspection.

pub(crate) mod calibration;
pub(crate) mod heightmap;
pub(crate) mod inspection;
pub(crate) mod recognition;

/// Containers before a simulated depth camera: the scenes of the tests of `perception`.
#[allow(
    clippy::unwrap_used,
    reason = "a scene that cannot be made should say so at once"
)]
#[path = "../../../perception/tests/simulated/mod.rs"]
mod simulated;
