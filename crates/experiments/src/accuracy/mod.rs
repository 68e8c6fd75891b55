//! How accurate each part is, in simulated views: heightmaps, calibration, recognition, inspection.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a measurement that cannot run should say so at once"
)]

pub(crate) mod calibration;
pub(crate) mod heightmap;
pub(crate) mod inspection;
pub(crate) mod recognition;

/// Containers before a simulated depth camera: the scenes of the tests of `perception`.
#[path = "../../../perception/tests/simulated/mod.rs"]
mod simulated;

use std::path::PathBuf;
use std::time::Instant;

use ppnpack_cli::failure::Outcome;
use ppnpack_files::write_whole;
use ppnpack_recognition::evaluation::PoseError;

/// What `work` gives, and how long it takes, in milliseconds.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let done = work();
    (done, start.elapsed().as_secs_f64() * 1e3)
}

/// The error of a pose as two columns of a table, in millimetres and degrees.
fn columns_of(error: Option<PoseError>) -> String {
    let (position_mm, angle_deg) = error.map_or((f64::NAN, f64::NAN), |error| {
        (error.position_m * 1e3, error.angle_rad.to_degrees())
    });
    format!("{position_mm:.2},{angle_deg:.2}")
}

/// Writes a table, where one is wanted.
fn write_csv(path: Option<&PathBuf>, head: &str, lines: impl Iterator<Item = String>) -> Outcome {
    let Some(path) = path else {
        return Ok(());
    };
    let mut text = format!("{head}\n");
    for line in lines {
        text += &format!("{line}\n");
    }
    Ok(write_whole(path, text.as_bytes())?)
}
