//! Points in rows.

use nalgebra::Point3;

/// Maximum number of points of a cloud.
pub const MAX_POINTS: usize = 64 << 20;

/// Points of a sensor, in metres in its frame.
///
/// An organised cloud has a row of points per row of the sensor's image, holes included. Any other
/// has one row.
#[derive(Debug, Clone, Default)]
pub struct Cloud {
    width: usize,
    points_m: Vec<Point3<f32>>,
}

/// Points that are no rows of one length, or too many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{points} points are no whole number of rows of {width}, or more than {MAX_POINTS}")]
pub struct CloudShapeError {
    points: usize,
    width: usize,
}

impl Cloud {
    /// Makes a cloud of points in rows of `width`. A point with a coordinate that is not finite is
    /// a hole: all three become NaN. So is one at the lens, with which many drivers fill holes.
    ///
    /// # Errors
    /// [`CloudShapeError`] where the last row is not complete, or there are more than
    /// [`MAX_POINTS`].
    pub fn organised(
        width: usize,
        mut points_m: Vec<Point3<f32>>,
    ) -> Result<Self, CloudShapeError> {
        let is_whole = points_m.len().is_multiple_of(width.max(1));
        if !is_whole || (width == 0 && !points_m.is_empty()) || points_m.len() > MAX_POINTS {
            return Err(CloudShapeError {
                points: points_m.len(),
                width,
            });
        }
        for point in &mut points_m {
            let is_measured = point.iter().all(|side_m| side_m.is_finite());
            if !is_measured || *point == Point3::origin() {
                *point = Point3::new(f32::NAN, f32::NAN, f32::NAN);
            }
        }
        Ok(Self { width, points_m })
    }

    /// Makes a cloud of points in no order.
    ///
    /// # Errors
    /// [`CloudShapeError`] where there are more than [`MAX_POINTS`].
    pub fn unorganised(points_m: Vec<Point3<f32>>) -> Result<Self, CloudShapeError> {
        Self::organised(points_m.len(), points_m)
    }

    /// Gives the same cloud where its numbers are of another unit, of so many metres.
    #[must_use]
    pub fn in_units_of(mut self, unit_m: f64) -> Self {
        for side_m in self.points_m.iter_mut().flat_map(|point| point.iter_mut()) {
            *side_m = (f64::from(*side_m) * unit_m) as f32;
        }
        self
    }

    /// Gives the points in metres, row by row; NaN in all three coordinates where there is a hole.
    pub fn points_m(&self) -> &[Point3<f32>] {
        &self.points_m
    }

    /// Gives the points that are no holes, in metres.
    pub fn measured_m(&self) -> impl Iterator<Item = Point3<f32>> + '_ {
        let points = self.points_m.iter().copied();
        points.filter(|point| !point.x.is_nan())
    }

    /// Gives the number of points in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Gives the number of rows: more than one for an organised cloud.
    pub fn height(&self) -> usize {
        self.points_m.len() / self.width.max(1)
    }
}

/// The same rows of the same points; holes are equal.
impl PartialEq for Cloud {
    fn eq(&self, other: &Self) -> bool {
        let are_same = |(one, two): (&Point3<f32>, &Point3<f32>)| {
            one == two || (one.x.is_nan() && two.x.is_nan())
        };
        self.width == other.width
            && self.points_m.len() == other.points_m.len()
            && self.points_m.iter().zip(&other.points_m).all(are_same)
    }
}
