//! Calibration: the pose and the size of a container before a sensor, from a cloud of it empty.
//!
//! The sensor looks at the container from above, tilted by 30 degrees or so at most, and sees its
//! whole rim; table or ground may be around it. Nothing else is assumed of the pose. How it is
//! found:
//!
//! 1. Floor, rim and ground are parallel: up is where the heights of points concentrate on few
//!    levels (`direction.rs`).
//! 2. The rim is the highest level whose points enclose a hole with something deep in it
//!    (`opening.rs`). The floor is the level in the hole that has the most points.
//! 3. Each side of the hole is the inner face of its wall where the sensor sees it, and the rim's
//!    inner edge where not (`sides.rs`). The four are adjusted to a rectangle (`rectangle.rs`).
//! 4. With the floor and the rim so bounded, up is fitted anew, and the steps from 2 are done
//!    again; so is how far the walls lean outwards, all alike.
//! 5. What does not fit a container of four plane walls that is empty is refused (`checks.rs`).
//!
//! The sensor's optical centre is the origin of its frame. The result is that of the seed, for
//! equal clouds.

mod checks;
mod direction;
mod error;
mod found;
mod frame;
mod levelled;
mod mask;
mod opening;
mod plane;
mod rectangle;
mod settings;
mod sides;

use nalgebra::{Isometry3, Point3};
use ppnpack_packing::kernel::grid::ContainerSize;
use serde::{Deserialize, Serialize};

pub use checks::Residuals;
pub use error::CalibrationError;
pub use settings::CalibrationSettings;

use found::Found;
use plane::median;

/// Number of looks at the cloud, with up fitted anew between them.
const ROUNDS: usize = 3;

/// Minimum number of points.
const LEAST_POINTS: usize = 2000;

/// Range of the points' median distance from the sensor, in metres; others are of another unit.
const MEDIAN_DISTANCE_M: std::ops::RangeInclusive<f64> = 0.1..=10.0;

/// A container that was found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// The pose: takes points of the sensor's frame to the container's.
    pub container_from_sensor: Isometry3<f64>,
    /// The inner size, in metres: the one that was given, where it was.
    pub size: ContainerSize,
    /// The inner size as it was measured, in metres.
    pub measured_size: ContainerSize,
    /// Residuals of the points.
    pub residuals: Residuals,
}

/// Finds the container in a cloud of it empty, given in metres in the sensor's frame. Points with a
/// coordinate that is not finite are left out.
///
/// The frame of the container has its origin at an inner bottom corner, of a tote below a corner of
/// its opening, z up, right-handed. Its x axis is that along a side nearest to the sensor's x axis
/// seen from above; see
/// [`CalibrationSettings::quarter_turns`].
///
/// # Errors
/// [`CalibrationError`] says why no container is found, or why what is found is not trusted.
pub fn calibrate(
    points_m: impl IntoIterator<Item = Point3<f32>>,
    settings: &CalibrationSettings,
) -> Result<Calibration, CalibrationError> {
    settings.validate()?;
    let points_m = measured(points_m)?;
    let mut up = direction::find(&points_m, settings)?;
    let known = settings.size.map(|size| size.draft_rad.tan());
    let mut found = Found::look(&points_m, &up, known.unwrap_or(0.0), settings)?;
    for _ in 1..ROUNDS {
        up = found.surfaces.up(&found.levelled);
        let lean = known.unwrap_or_else(|| leaning(&found, settings));
        found = Found::look(&points_m, &up, lean, settings)?;
    }
    checks::has_rim(&found)?;
    let residuals = checks::residuals(&found, settings)?;
    checks::is_empty(&found, residuals.floor_rms_m)?;
    let placed = frame::place(&found, settings)?;
    Ok(Calibration {
        container_from_sensor: placed.container_from_levelled * found.levelled.levelled_from_sensor,
        size: placed.size,
        measured_size: placed.measured_size,
        residuals,
    })
}

/// Gives how far the walls of a container of unknown size lean outwards, per metre of height; 0
/// where that is no more than walls may be bent.
fn leaning(found: &Found, settings: &CalibrationSettings) -> f64 {
    let lean = found.lean();
    let between_halves_m = lean * found.surfaces.depth_m() / 2.0;
    match between_halves_m > settings.largest_bow_m {
        true => lean,
        false => 0.0,
    }
}

/// Gives the points that were measured; refuses too few, and those of another unit.
fn measured(
    points_m: impl IntoIterator<Item = Point3<f32>>,
) -> Result<Vec<Point3<f64>>, CalibrationError> {
    let points_m = points_m.into_iter();
    let points_m: Vec<Point3<f64>> = points_m
        .filter(|point| point.iter().all(|side_m| side_m.is_finite()))
        .map(|point| point.cast())
        .collect();
    if points_m.len() < LEAST_POINTS {
        return Err(CalibrationError::new(format_args!(
            "the cloud has {} measured points where {LEAST_POINTS} are needed",
            points_m.len()
        )));
    }
    let mut distances_m: Vec<f64> = points_m.iter().map(|point| point.coords.norm()).collect();
    let median_m = median(&mut distances_m);
    if !MEDIAN_DISTANCE_M.contains(&median_m) {
        return Err(CalibrationError::new(format_args!(
            "points are {median_m:.3} m from the sensor in the median, where 0.1 to 10 m are possible: is the cloud in \
             millimetres, or not in the sensor's frame?"
        )));
    }
    Ok(points_m)
}
