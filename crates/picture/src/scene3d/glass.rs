//! The container's walls: clear sheets over the finished picture of what is behind and inside.

use nalgebra::{Point3, Vector3};

use crate::colour::Colour;

/// The four upright walls of a container whose inner corner is the origin.
pub(super) struct Glass {
    size: Vector3<f32>,
    tint: Vector3<f32>,
}

impl Glass {
    /// Walls around an inner volume of these dimensions, in metres.
    pub(super) fn new(size: [f32; 3]) -> Self {
        Self {
            size: Vector3::from(size),
            tint: Colour::hex(0xc3d5e2).to_linear(),
        }
    }

    /// Looks at `behind` through the walls nearer than `depth` along a ray from the eye.
    #[inline]
    pub(super) fn over(
        &self,
        behind: Vector3<f32>,
        eye: &Point3<f32>,
        ray: &Vector3<f32>,
        depth: f32,
    ) -> Vector3<f32> {
        // All walls have one tint, so their order does not matter.
        let clear = |across_x: bool, wall: f32| 1.0 - self.opacity(eye, ray, depth, across_x, wall);
        let clear = clear(true, 0.0)
            * clear(true, self.size.x)
            * clear(false, 0.0)
            * clear(false, self.size.y);
        self.tint + (behind - self.tint) * clear
    }

    /// How much one wall hides: the plane at `wall` across the x axis, or else across the y axis.
    #[inline]
    fn opacity(
        &self,
        eye: &Point3<f32>,
        ray: &Vector3<f32>,
        depth: f32,
        across_x: bool,
        wall: f32,
    ) -> f32 {
        let (x, y) = ((eye.x, ray.x), (eye.y, ray.y));
        let ((from, slope), (side, side_slope), extent) = if across_x {
            (x, y, self.size.y)
        } else {
            (y, x, self.size.x)
        };
        let distance = (wall - from) / slope;
        if !(distance > 0.0 && distance < depth) {
            return 0.0;
        }
        let along = side + side_slope * distance;
        let height = eye.z + ray.z * distance;
        if along < 0.0 || along > extent || height < 0.0 || height > self.size.z {
            return 0.0;
        }
        // The back walls, seen from inside, set the content off; the front ones must not veil it.
        let from_inside = (slope > 0.0) == (wall > 0.0);
        if from_inside { 0.32 } else { 0.06 }
    }
}
