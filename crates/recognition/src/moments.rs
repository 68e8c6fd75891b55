//! The mean of points, and how they scatter about it.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

/// Gives the mean of points; `None` where there is none.
pub(crate) fn centroid(points: &[Point3<f64>]) -> Option<Point3<f64>> {
    let sum: Vector3<f64> = points.iter().map(|point| point.coords).sum();
    (!points.is_empty()).then(|| Point3::from(sum / points.len() as f64))
}

/// Gives the axes along which points scatter about their mean, and how far.
pub(crate) fn scatter(
    points: &[Point3<f64>],
    mean: &Point3<f64>,
) -> SymmetricEigen<f64, nalgebra::Const<3>> {
    let offsets = points.iter().map(|point| point - mean);
    let scatter: Matrix3<f64> = offsets.map(|offset| offset * offset.transpose()).sum();
    SymmetricEigen::new(scatter)
}
