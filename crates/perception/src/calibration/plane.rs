//! Planes through points, and medians.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Unit, Vector3};

/// Moments of points that a plane is fitted to: their number, their mean and their scatter about
/// it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spread {
    pub(super) count: usize,
    pub(super) mean: Point3<f64>,
    pub(super) scatter: Matrix3<f64>,
}

impl Spread {
    /// Gives the moments of points; `None` of fewer than three.
    pub(super) fn of<'a>(points: impl Iterator<Item = &'a Point3<f64>> + Clone) -> Option<Self> {
        let (mut count, mut sum) = (0, Vector3::zeros());
        for point in points.clone() {
            count += 1;
            sum += point.coords;
        }
        if count < 3 {
            return None;
        }
        let mean = Point3::from(sum / count as f64);
        let scatter = points.fold(Matrix3::zeros(), |scatter, point| {
            let from_mean = point - mean;
            scatter + from_mean * from_mean.transpose()
        });
        Some(Self {
            count,
            mean,
            scatter,
        })
    }

    /// Gives the normal of the plane, on the side of `up`.
    pub(super) fn normal(&self, up: &Vector3<f64>) -> Unit<Vector3<f64>> {
        normal_of(self.scatter, up)
    }

    /// Gives the root mean square distance of the points from the plane with this normal.
    pub(super) fn rms(&self, normal: &Vector3<f64>) -> f64 {
        let sum = normal.dot(&(self.scatter * normal));
        (sum / self.count as f64).max(0.0).sqrt()
    }
}

/// Gives the direction in which points spread least, on the side of `up`.
pub(super) fn normal_of(scatter: Matrix3<f64>, up: &Vector3<f64>) -> Unit<Vector3<f64>> {
    let eigen = SymmetricEigen::new(scatter);
    let least = eigen.eigenvalues.imin();
    let normal: Vector3<f64> = eigen.eigenvectors.column(least).into_owned();
    Unit::new_normalize(if normal.dot(up) < 0.0 {
        -normal
    } else {
        normal
    })
}

/// Gives the median of unsorted values; 0 of none.
pub(super) fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
