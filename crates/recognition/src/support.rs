//! The plane that items stand on.

use nalgebra::{Isometry3, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::moments::{centroid, scatter};

/// The support plane.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Support {
    /// Known: the support frame in the world. Its z axis points up, items stand at its height 0.
    Known {
        /// The support frame in the world.
        world_from_support: Isometry3<f64>,
    },
    /// The plane that most points lie on, among those whose normal is near the world's z axis.
    Fitted {
        /// Maximum lean of the plane, in radians.
        greatest_lean_rad: f64,
        /// Maximum distance of points that lie on the plane, in metres; some standard deviations of
        /// the noise.
        tolerance_m: f64,
    },
}

impl Default for Support {
    fn default() -> Self {
        Self::Fitted {
            greatest_lean_rad: 0.2,
            tolerance_m: 0.003,
        }
    }
}

/// Number of points that a fit looks at.
const POINTS: usize = 3000;
/// Number of planes that it tries.
const TRIALS: usize = 150;
/// Number of times that the best is moved to the mean of the points on it.
const ROUNDS: usize = 3;
/// Minimum number of points that make a plane.
const LEAST_POINTS: usize = 20;

impl Support {
    /// Gives the support frame in the world; `None` where no plane is found.
    ///
    /// A fit is random sample consensus (Fischler and Bolles 1981) with a fixed seed, then least
    /// squares. The frame's origin is where the plane meets the world's z axis, and it is turned as
    /// little as possible.
    pub(crate) fn world_from_support(&self, points: &[Point3<f64>]) -> Option<Isometry3<f64>> {
        match self {
            Self::Known { world_from_support } => Some(*world_from_support),
            Self::Fitted {
                greatest_lean_rad,
                tolerance_m,
            } => fitted(points, *greatest_lean_rad, *tolerance_m),
        }
    }
}

/// A plane by a point and a normal that points up.
struct Plane {
    at: Point3<f64>,
    normal: Unit<Vector3<f64>>,
}

impl Plane {
    fn is_near(&self, point: &Point3<f64>, tolerance_m: f64) -> bool {
        (point - self.at).dot(&self.normal).abs() < tolerance_m
    }
}

fn fitted(
    points: &[Point3<f64>],
    greatest_lean_rad: f64,
    tolerance_m: f64,
) -> Option<Isometry3<f64>> {
    let stride = (points.len() / POINTS).max(1);
    let few: Vec<Point3<f64>> = points.iter().step_by(stride).copied().collect();
    if few.len() < LEAST_POINTS {
        return None;
    }
    let least_up = greatest_lean_rad.cos();
    let mut random = ChaCha8Rng::seed_from_u64(0);
    let mut best: Option<(usize, Plane)> = None;
    for _ in 0..TRIALS {
        let mut pick = || few.get(random.random_range(0..few.len())).copied();
        let (Some(a), Some(b), Some(c)) = (pick(), pick(), pick()) else {
            continue;
        };
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(1e-12) else {
            continue;
        };
        let normal = upwards(normal);
        if normal.z < least_up {
            continue;
        }
        let plane = Plane { at: a, normal };
        let near = few.iter().filter(|point| plane.is_near(point, tolerance_m));
        let count = near.count();
        if best.as_ref().is_none_or(|(most, _)| count > *most) {
            best = Some((count, plane));
        }
    }
    let (count, mut plane) = best?;
    if count < LEAST_POINTS {
        return None;
    }
    for _ in 0..ROUNDS {
        let near = few.iter().filter(|point| plane.is_near(point, tolerance_m));
        plane = least_squares(&near.copied().collect::<Vec<_>>())?;
    }
    if plane.normal.z < least_up {
        return None;
    }
    let origin_height_m = plane.at.coords.dot(&plane.normal) / plane.normal.z;
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &plane.normal)?;
    Some(Translation3::new(0.0, 0.0, origin_height_m) * turn)
}

fn least_squares(points: &[Point3<f64>]) -> Option<Plane> {
    if points.len() < LEAST_POINTS {
        return None;
    }
    let at = centroid(points)?;
    let scatter = scatter(points, &at);
    let flattest = scatter.eigenvectors.column(scatter.eigenvalues.imin());
    let normal = flattest.into_owned().try_normalize(1e-12)?;
    Some(Plane {
        at,
        normal: upwards(normal),
    })
}

/// Turns a unit normal up.
fn upwards(normal: Vector3<f64>) -> Unit<Vector3<f64>> {
    Unit::new_unchecked(if normal.z < 0.0 { -normal } else { normal })
}
