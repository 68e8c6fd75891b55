//! The camera that a scene is seen by.

use nalgebra::{Point3, Vector3};

use super::geometry::box_corners;
use super::scene::Scene3d;

/// Across the smaller side of the picture. Narrow, so that boxes do not look distorted.
const FIELD_OF_VIEW_RAD: f64 = 0.48;

/// The share of the field of view that the framed box fills at most.
const FILLED: f64 = 0.93;

/// From the framed box to the eye: in front, to the left and above.
const THREE_QUARTER: Vector3<f64> = Vector3::new(-0.50, -0.78, 0.80);

/// A perspective camera, in the scene's frame; upright, that is z points up in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// The position of the camera, in metres.
    pub eye: Point3<f64>,
    /// The point in the middle of the picture, in metres.
    pub target: Point3<f64>,
    /// The angle across the smaller side of the picture, in radians, above 0 and below pi.
    pub field_of_view_rad: f64,
}

impl Camera {
    /// Looks from above, in a three-quarter view, on the container of a scene and what stands out
    /// above it, or on all items without one.
    pub fn overlooking(scene: &Scene3d<'_>) -> Self {
        let mut lowest = Point3::from([f64::INFINITY; 3]);
        let mut highest = Point3::from([f64::NEG_INFINITY; 3]);
        for item in &scene.items {
            for vertex in item.mesh.vertices {
                let point = item.world_from_item * vertex;
                if point.iter().all(|value| value.is_finite()) {
                    lowest = lowest.inf(&point);
                    highest = highest.sup(&point);
                }
            }
        }
        match scene.container_m {
            Some([x, y, z]) => {
                // An item that was flung out must not shrink the picture: at most half the height
                // is added.
                let top = highest.z.max(z).min(1.5 * z);
                Self::framing(Point3::origin(), Point3::new(x, y, top))
            }
            None => Self::framing(lowest, highest),
        }
    }

    /// Looks in the same way on a box between two corners, in metres. Whatever the picture's shape,
    /// the box is inside it.
    pub fn framing(lowest: Point3<f64>, highest: Point3<f64>) -> Self {
        let sound = |extent: &f64| (0.0..1e6).contains(extent);
        let (lowest, highest) = if (highest - lowest).iter().all(sound) {
            (lowest, highest)
        } else {
            (Point3::origin(), Point3::new(1.0, 1.0, 1.0))
        };
        let backward = THREE_QUARTER.normalize();
        let right = Vector3::z().cross(&backward).normalize();
        let up = backward.cross(&right);
        let tangent = (FIELD_OF_VIEW_RAD / 2.0).tan() * FILLED;

        let corners = box_corners(&lowest, &highest);
        // Perspective makes the near corners spread further than the far ones: shift the target
        // until the box is centred, which settles within a few rounds.
        let mut target = nalgebra::center(&lowest, &highest);
        let mut distance = 0.0_f64;
        for _ in 0..8 {
            let from_target = |corner: &Point3<f64>| {
                let offset = corner - target;
                (offset.dot(&right), offset.dot(&up), offset.dot(&backward))
            };
            distance = corners
                .iter()
                .map(from_target)
                .fold(1e-3, |distance, (x, y, z)| {
                    distance.max(x.abs().max(y.abs()) / tangent + z)
                });
            let (mut left, mut rightmost) = (f64::INFINITY, f64::NEG_INFINITY);
            let (mut bottom, mut top) = (f64::INFINITY, f64::NEG_INFINITY);
            for (x, y, z) in corners.iter().map(from_target) {
                let depth = (distance - z).max(1e-6);
                left = left.min(x / depth);
                rightmost = rightmost.max(x / depth);
                bottom = bottom.min(y / depth);
                top = top.max(y / depth);
            }
            target += (right * (left + rightmost) + up * (bottom + top)) * (distance / 2.0);
        }
        Self {
            eye: target + backward * distance,
            target,
            field_of_view_rad: FIELD_OF_VIEW_RAD,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_framed_box_is_inside_the_view() {
        let (lowest, highest) = (Point3::new(-0.2, 0.1, 0.0), Point3::new(0.3, 0.2, 0.7));
        let camera = Camera::framing(lowest, highest);
        let forward = (camera.target - camera.eye).normalize();
        let limit = camera.field_of_view_rad / 2.0 * 2f64.sqrt();
        for corner in [
            lowest,
            highest,
            Point3::new(0.3, 0.1, 0.0),
            Point3::new(-0.2, 0.2, 0.7),
        ] {
            assert!(forward.angle(&(corner - camera.eye)) < limit);
        }
    }
}
