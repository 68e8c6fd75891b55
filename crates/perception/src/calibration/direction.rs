//! The direction up: the one along which the heights of points concentrate on few levels.

use nalgebra::{Point3, Unit, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::error::CalibrationError;
use super::plane::Spread;
use super::settings::CalibrationSettings;

/// Number of directions that are tried.
const TRIALS: usize = 3000;

/// Number of points that a direction is judged by.
const JUDGES: usize = 3000;

/// Difference in height of points of one level, in metres, where the direction is not exact.
const LEVEL_M: f64 = 0.004;

/// Maximum distance of points, in metres.
const FARTHEST_M: f64 = 12.0;

/// Maximum angle of directions from straight against the view, as a cosine: else walls would be
/// floors.
const LEAST_COSINE: f64 = 0.55;

/// Distances within which points belong to the level that is refined, one round after another, in
/// metres.
const ROUNDS_M: [f64; 4] = [0.012, 0.008, 0.005, 0.004];

/// Finds the direction up, of unit length, in the frame of the points.
pub(super) fn find(
    points_m: &[Point3<f64>],
    settings: &CalibrationSettings,
) -> Result<Unit<Vector3<f64>>, CalibrationError> {
    let mut random = ChaCha8Rng::seed_from_u64(settings.seed);
    let judges = judges(points_m, &mut random);
    let view = judges
        .iter()
        .filter_map(|point| point.coords.try_normalize(1e-9))
        .sum::<Vector3<f64>>();
    let view = view
        .try_normalize(1e-9)
        .ok_or_else(CalibrationError::no_level)?;
    let mut levels = Levels::default();
    let mut best = None;
    for _ in 0..TRIALS {
        let [a, b, c] = [(); 3].map(|()| judges.get(random.random_range(0..judges.len().max(1))));
        let (Some(a), Some(b), Some(c)) = (a, b, c) else {
            return Err(CalibrationError::no_level());
        };
        // Points close together say little of a direction.
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.003) else {
            continue;
        };
        let up = if normal.dot(&view) > 0.0 {
            -normal
        } else {
            normal
        };
        if -up.dot(&view) < LEAST_COSINE {
            continue;
        }
        let score = levels.concentration(&judges, &up);
        if best.is_none_or(|(most, _)| score > most) {
            best = Some((score, up));
        }
    }
    let (_, up) = best.ok_or_else(CalibrationError::no_level)?;
    let up = refine(points_m, &judges, Unit::new_normalize(up), &mut levels)?;
    let angle_rad = (-up.dot(&view)).clamp(-1.0, 1.0).acos();
    if angle_rad > settings.largest_view_angle_rad {
        let [angle, limit] = [angle_rad, settings.largest_view_angle_rad].map(f64::to_degrees);
        return Err(CalibrationError::new(format_args!(
            "the sensor looks at the container {angle:.0} degrees from above, where {limit:.0} are possible: tilt it less"
        )));
    }
    Ok(up)
}

fn judges(points_m: &[Point3<f64>], random: &mut ChaCha8Rng) -> Vec<Point3<f64>> {
    let chosen = (0..JUDGES).filter_map(|_| points_m.get(random.random_range(0..points_m.len())));
    let is_near = |point: &&Point3<f64>| point.coords.norm() < FARTHEST_M;
    chosen.filter(is_near).copied().collect()
}

/// Gives the direction of the plane that most points at the heaviest level lie on.
fn refine(
    points_m: &[Point3<f64>],
    judges: &[Point3<f64>],
    mut up: Unit<Vector3<f64>>,
    levels: &mut Levels,
) -> Result<Unit<Vector3<f64>>, CalibrationError> {
    levels.concentration(judges, &up);
    let mut height_m = levels.heaviest_m();
    for within_m in ROUNDS_M {
        let level = points_m
            .iter()
            .filter(|point| (up.dot(&point.coords) - height_m).abs() <= within_m);
        let spread = Spread::of(level).ok_or_else(CalibrationError::no_level)?;
        up = spread.normal(&up);
        height_m = up.dot(&spread.mean.coords);
    }
    Ok(up)
}

/// Counts of points by height.
#[derive(Debug, Default)]
struct Levels {
    lowest_m: f64,
    counts: Vec<u32>,
}

impl Levels {
    /// Measures how much the heights of points along a direction concentrate.
    fn concentration(&mut self, points_m: &[Point3<f64>], up: &Vector3<f64>) -> u64 {
        let heights = points_m.iter().map(|point| up.dot(&point.coords));
        let [lowest_m, highest_m] = heights.clone().fold(
            [f64::INFINITY, f64::NEG_INFINITY],
            |[lowest, highest], height| [height.min(lowest), height.max(highest)],
        );
        self.lowest_m = lowest_m;
        self.counts.clear();
        self.counts
            .resize(((highest_m - lowest_m) / LEVEL_M) as usize + 1, 0);
        for height_m in heights {
            let level = ((height_m - lowest_m) / LEVEL_M) as usize;
            if let Some(count) = self.counts.get_mut(level) {
                *count += 1;
            }
        }
        let squares = self.counts.iter().map(|count| u64::from(*count).pow(2));
        squares.sum()
    }

    /// Gives the middle of the level with the most points.
    fn heaviest_m(&self) -> f64 {
        let counts = self.counts.iter().enumerate();
        let heaviest = counts.max_by_key(|(_, count)| **count);
        let level = heaviest.map_or(0, |(level, _)| level);
        self.lowest_m + (level as f64 + 0.5) * LEVEL_M
    }
}
