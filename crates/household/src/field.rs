//! Signed distance fields in millimetres: negative inside, positive outside.
//!
//! A field need not be the exact distance, but never changes faster than the distance does;
//! sampling relies on that to skip empty space.

use nalgebra::{Isometry3, Point2, Point3, Unit, UnitQuaternion, Vector2, Vector3};

use super::outline::Point;

type Distance = Box<dyn Fn(&Point3<f64>) -> f64 + Send + Sync>;

/// A shape that unites, blends and cuts freely, with a box that encloses it.
pub(crate) struct Field {
    distance_mm: Distance,
    lowest: Point3<f64>,
    highest: Point3<f64>,
}

impl Field {
    fn new(
        lowest: Point3<f64>,
        highest: Point3<f64>,
        distance_mm: impl Fn(&Point3<f64>) -> f64 + Send + Sync + 'static,
    ) -> Self {
        Self {
            distance_mm: Box::new(distance_mm),
            lowest,
            highest,
        }
    }

    fn centred(
        half: Vector3<f64>,
        distance_mm: impl Fn(&Point3<f64>) -> f64 + Send + Sync + 'static,
    ) -> Self {
        Self::new(Point3::from(-half), Point3::from(half), distance_mm)
    }

    /// The field's value at a point.
    pub(crate) fn distance_mm(&self, point: &Point3<f64>) -> f64 {
        (self.distance_mm)(point)
    }

    /// The corners of a box around the shape, in millimetres.
    pub(crate) fn bounds_mm(&self) -> (Point3<f64>, Point3<f64>) {
        (self.lowest, self.highest)
    }

    /// Both shapes.
    pub(crate) fn and(self, other: Self) -> Self {
        let (lowest, highest) = (
            self.lowest.inf(&other.lowest),
            self.highest.sup(&other.highest),
        );
        Self::new(lowest, highest, move |p| {
            self.distance_mm(p).min(other.distance_mm(p))
        })
    }

    /// Both shapes, with a fillet of about `radius_mm` where they meet.
    pub(crate) fn blended(self, other: Self, radius_mm: f64) -> Self {
        let margin = Vector3::repeat(radius_mm / 4.0);
        let lowest = self.lowest.inf(&other.lowest) - margin;
        let highest = self.highest.sup(&other.highest) + margin;
        Self::new(lowest, highest, move |p| {
            let (a, b) = (self.distance_mm(p), other.distance_mm(p));
            a.min(b) - fillet(a, b, radius_mm)
        })
    }

    /// This shape less the other.
    pub(crate) fn without(self, other: Self) -> Self {
        Self::new(self.lowest, self.highest, move |p| {
            self.distance_mm(p).max(-other.distance_mm(p))
        })
    }

    /// This shape less the other, the edges of the cut rounded by about `radius_mm`.
    pub(crate) fn hollowed(self, other: Self, radius_mm: f64) -> Self {
        Self::new(self.lowest, self.highest, move |p| {
            let (a, b) = (self.distance_mm(p), -other.distance_mm(p));
            a.max(b) + fillet(a, b, radius_mm)
        })
    }

    /// The shape grown on all sides, which rounds its edges.
    pub(crate) fn grown(self, margin_mm: f64) -> Self {
        let margin = Vector3::repeat(margin_mm);
        Self::new(self.lowest - margin, self.highest + margin, move |p| {
            self.distance_mm(p) - margin_mm
        })
    }

    /// The shape and its mirror image across the plane y = 0.
    pub(crate) fn mirrored(self) -> Self {
        let reach = self.lowest.y.abs().max(self.highest.y.abs());
        let lowest = Point3::new(self.lowest.x, -reach, self.lowest.z);
        let highest = Point3::new(self.highest.x, reach, self.highest.z);
        Self::new(lowest, highest, move |p| {
            let image = Point3::new(p.x, -p.y, p.z);
            self.distance_mm(p).min(self.distance_mm(&image))
        })
    }

    /// The shape moved, in millimetres.
    pub(crate) fn at(self, x: f64, y: f64, z: f64) -> Self {
        self.posed(Isometry3::translation(x, y, z))
    }

    /// The shape turned about the x axis.
    pub(crate) fn about_x(self, degrees: f64) -> Self {
        self.turned(Vector3::x_axis(), degrees)
    }

    /// The shape turned about the y axis.
    pub(crate) fn about_y(self, degrees: f64) -> Self {
        self.turned(Vector3::y_axis(), degrees)
    }

    fn turned(self, axis: Unit<Vector3<f64>>, degrees: f64) -> Self {
        let turn = UnitQuaternion::from_axis_angle(&axis, degrees.to_radians());
        self.posed(nalgebra::convert(turn))
    }

    fn posed(self, pose: Isometry3<f64>) -> Self {
        let middle = pose * nalgebra::center(&self.lowest, &self.highest);
        let half = (self.highest - self.lowest) / 2.0;
        let rotation = pose.rotation.to_rotation_matrix();
        let reach = rotation.matrix().map(f64::abs) * half;
        Self::new(middle - reach, middle + reach, move |p| {
            self.distance_mm(&pose.inverse_transform_point(p))
        })
    }
}

/// What a fillet adds to or takes from two surfaces at these distances.
fn fillet(a: f64, b: f64, radius_mm: f64) -> f64 {
    let overlap = (radius_mm - (a - b).abs()).max(0.0);
    overlap * overlap / (4.0 * radius_mm)
}

/// A ball around the origin.
pub(crate) fn ball(radius_mm: f64) -> Field {
    Field::centred(Vector3::repeat(radius_mm), move |p| {
        p.coords.norm() - radius_mm
    })
}

/// An ellipsoid around the origin.
pub(crate) fn ellipsoid(size_mm: [f64; 3]) -> Field {
    let half = Vector3::from(size_mm) / 2.0;
    let least = half.min();
    Field::centred(half, move |p| {
        (p.coords.component_div(&half).norm() - 1.0) * least
    })
}

/// A cuboid around the origin, its edges rounded.
pub(crate) fn block(size_mm: [f64; 3], rounding_mm: f64) -> Field {
    let half = Vector3::from(size_mm) / 2.0;
    let core = half - Vector3::repeat(rounding_mm);
    Field::centred(half, move |p| {
        let beyond = p.coords.abs() - core;
        beyond.sup(&Vector3::zeros()).norm() + beyond.max().min(0.0) - rounding_mm
    })
}

/// A rod with round ends, from `a` to `b`; its radius goes evenly from the first to the second.
pub(crate) fn rod(a: [f64; 3], b: [f64; 3], radii_mm: [f64; 2]) -> Field {
    let (a, b) = (Point3::from(a), Point3::from(b));
    let [radius_a, radius_b] = radii_mm;
    let axis = b - a;
    let taper = (radius_b - radius_a) / axis.norm();
    let steepness = taper.hypot(1.0);
    let reach = Vector3::repeat(radius_a.max(radius_b));
    Field::new(a.inf(&b) - reach, a.sup(&b) + reach, move |p| {
        let from_a = p - a;
        let along = (from_a.dot(&axis) / axis.norm_squared()).clamp(0.0, 1.0);
        let radius = radius_a + (radius_b - radius_a) * along;
        ((from_a - axis * along).norm() - radius) / steepness
    })
}

/// An upright cone's trunk standing on the origin; equal radii make a cylinder.
pub(crate) fn trunk(bottom_radius_mm: f64, top_radius_mm: f64, height_mm: f64) -> Field {
    let widening = (top_radius_mm - bottom_radius_mm) / height_mm;
    let steepness = widening.hypot(1.0);
    let reach = bottom_radius_mm.max(top_radius_mm);
    let lowest = Point3::new(-reach, -reach, 0.0);
    Field::new(lowest, Point3::new(reach, reach, height_mm), move |p| {
        let side = (p.x.hypot(p.y) - bottom_radius_mm - widening * p.z) / steepness;
        let end = (-p.z).max(p.z - height_mm);
        side.max(0.0).hypot(end.max(0.0)) + side.max(end).min(0.0)
    })
}

/// An upright cylinder standing on the origin.
pub(crate) fn cylinder(radius_mm: f64, height_mm: f64) -> Field {
    trunk(radius_mm, radius_mm, height_mm)
}

/// A ring about the z axis.
pub(crate) fn torus(ring_radius_mm: f64, tube_radius_mm: f64) -> Field {
    let reach = ring_radius_mm + tube_radius_mm;
    Field::centred(Vector3::new(reach, reach, tube_radius_mm), move |p| {
        (p.x.hypot(p.y) - ring_radius_mm).hypot(p.z) - tube_radius_mm
    })
}

/// A prism over a counter-clockwise outline, standing on the plane z = 0.
pub(crate) fn prism(outline: &[Point], height_mm: f64) -> Field {
    let corners: Vec<Point2<f64>> = outline.iter().copied().map(Point2::from).collect();
    let (mut lowest, mut highest) = (Vector2::repeat(f64::MAX), Vector2::repeat(f64::MIN));
    for corner in &corners {
        lowest = lowest.inf(&corner.coords);
        highest = highest.sup(&corner.coords);
    }
    let next = corners.iter().cycle().skip(1).copied();
    let edges: Vec<_> = corners.iter().copied().zip(next).collect();
    Field::new(
        Point3::new(lowest.x, lowest.y, 0.0),
        Point3::new(highest.x, highest.y, height_mm),
        move |p| {
            let point = p.xy();
            let mut squared = f64::INFINITY;
            let mut inside = false;
            for (a, b) in &edges {
                let (edge, offset) = (b - a, point - a);
                let along = (offset.dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0);
                squared = squared.min((offset - edge * along).norm_squared());
                // A ray towards +x crosses the outline an odd number of times from inside.
                if (a.y > point.y) != (b.y > point.y)
                    && offset.x < edge.x * (point.y - a.y) / edge.y
                {
                    inside = !inside;
                }
            }
            let side = if inside {
                -squared.sqrt()
            } else {
                squared.sqrt()
            };
            side.max(-p.z).max(p.z - height_mm)
        },
    )
}
