//! Shapes that collide, and distances between them. All in one frame with z up, in metres.

use nalgebra::{Point2, Point3, Vector3};

/// Halvings of a segment when its point nearest to a solid is sought.
const HALVINGS: u32 = 14;

/// A convex solid of which the nearest point is easily told.
pub(crate) trait Solid {
    /// Gives the offset from the solid's nearest point to a point; zero inside.
    fn offset_to(&self, point: &Point3<f64>) -> Vector3<f64>;
}

/// All points within a radius of a segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capsule {
    /// One end of the axis, in metres.
    pub from: Point3<f64>,
    /// The other end of the axis, in metres.
    pub to: Point3<f64>,
    /// The radius, in metres.
    pub radius_m: f64,
}

impl Capsule {
    /// Bounds the distance to a solid from below, tight to some micrometres; negative where they
    /// overlap.
    ///
    /// The squared distance along the axis is convex, and its slope is twice the product of the
    /// offset and the axis; the least distance is bracketed by halving on the slope's sign.
    pub(crate) fn distance_m(&self, solid: &impl Solid) -> f64 {
        let axis = self.to - self.from;
        let offset_at = |share: f64| solid.offset_to(&(self.from + axis * share));
        let (at_from, at_to) = (offset_at(0.0), offset_at(1.0));
        if at_from.dot(&axis) >= 0.0 {
            return at_from.norm() - self.radius_m;
        }
        if at_to.dot(&axis) <= 0.0 {
            return at_to.norm() - self.radius_m;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if offset_at(middle).dot(&axis) < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        let nearest_m = offset_at(0.5 * (low + high)).norm();
        nearest_m - 0.5 * (high - low) * axis.norm() - self.radius_m
    }

    /// Gives the box around the axis.
    pub(crate) fn axis_box(&self) -> AxisBox {
        AxisBox {
            lowest: self.from.inf(&self.to),
            highest: self.from.sup(&self.to),
        }
    }

    /// Measures the distance to all that lies below a height, in metres; negative where they
    /// overlap.
    pub(crate) fn distance_above_m(&self, height_m: f64) -> f64 {
        (self.from.z.min(self.to.z) - height_m).max(0.0) - self.radius_m
    }

    /// Measures the distance to another capsule, in metres; negative where they overlap.
    ///
    /// Source: Ericson, *Real-Time Collision Detection*, 2005, section 5.1.9.
    pub(crate) fn distance_to_capsule_m(&self, other: &Self) -> f64 {
        let (d1, d2) = (self.to - self.from, other.to - other.from);
        let between = self.from - other.from;
        let (a, e) = (d1.norm_squared(), d2.norm_squared());
        let (b, c, f) = (d1.dot(&d2), d1.dot(&between), d2.dot(&between));
        let share = |numerator: f64, denominator: f64| match denominator > f64::EPSILON {
            true => (numerator / denominator).clamp(0.0, 1.0),
            false => 0.0,
        };
        let mut s = share(b * f - c * e, a * e - b * b);
        let t = b * s + f;
        let t = if t < 0.0 || e <= f64::EPSILON {
            s = share(-c, a);
            0.0
        } else if t > e {
            s = share(b - c, a);
            1.0
        } else {
            t / e
        };
        let gap = (self.from + d1 * s) - (other.from + d2 * t);
        gap.norm() - self.radius_m - other.radius_m
    }
}

/// A box along the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisBox {
    /// The corner with the lowest coordinates, in metres.
    pub lowest: Point3<f64>,
    /// The corner with the greatest coordinates, in metres.
    pub highest: Point3<f64>,
}

impl AxisBox {
    /// Measures the distance to another box, in metres; 0 where they overlap.
    pub(crate) fn distance_to_box_m(&self, other: &Self) -> f64 {
        let gap = (self.lowest - other.highest).sup(&(other.lowest - self.highest));
        gap.sup(&Vector3::zeros()).norm()
    }

    /// Measures the distance to an upright cylinder, in metres; 0 where they overlap.
    pub(crate) fn distance_to_cylinder_m(&self, cylinder: &UprightCylinder) -> f64 {
        let axis = cylinder.axis_m;
        let beside = |at: f64, low: f64, high: f64| (low - at).max(at - high).max(0.0);
        let x = beside(axis.x, self.lowest.x, self.highest.x);
        let y = beside(axis.y, self.lowest.y, self.highest.y);
        let across = (x.hypot(y) - cylinder.radius_m).max(0.0);
        let above = (cylinder.lowest_m - self.highest.z).max(self.lowest.z - cylinder.highest_m);
        across.hypot(above.max(0.0))
    }

    /// Moves the box.
    #[must_use]
    pub(crate) fn moved(mut self, by: &Vector3<f64>) -> Self {
        self.lowest += by;
        self.highest += by;
        self
    }

    /// Gives the smallest cylinder around the z axis that holds the box.
    pub(crate) fn around_axis(&self) -> UprightCylinder {
        let corner = self.lowest.coords.abs().sup(&self.highest.coords.abs());
        UprightCylinder {
            axis_m: Point2::origin(),
            radius_m: corner.xy().norm(),
            lowest_m: self.lowest.z,
            highest_m: self.highest.z,
        }
    }
}

impl Solid for AxisBox {
    fn offset_to(&self, point: &Point3<f64>) -> Vector3<f64> {
        point - point.sup(&self.lowest).inf(&self.highest)
    }
}

/// A cylinder with a vertical axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UprightCylinder {
    /// The place of the axis.
    pub axis_m: Point2<f64>,
    /// The radius, in metres.
    pub radius_m: f64,
    /// The height of the lower end, in metres.
    pub lowest_m: f64,
    /// The height of the upper end, in metres.
    pub highest_m: f64,
}

impl UprightCylinder {
    /// Moves the cylinder.
    #[must_use]
    pub(crate) fn moved(mut self, by: &Vector3<f64>) -> Self {
        self.axis_m += by.xy();
        self.lowest_m += by.z;
        self.highest_m += by.z;
        self
    }
}

impl Solid for UprightCylinder {
    fn offset_to(&self, point: &Point3<f64>) -> Vector3<f64> {
        let across = point.xy() - self.axis_m;
        let distance_m = across.norm();
        let is_beside = distance_m > self.radius_m;
        let across = across
            * if is_beside {
                1.0 - self.radius_m / distance_m
            } else {
                0.0
            };
        let above = point.z - point.z.clamp(self.lowest_m, self.highest_m);
        Vector3::new(across.x, across.y, above)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn point() -> impl Strategy<Value = Point3<f64>> {
        (-1.0..1.0, -1.0..1.0, -1.0..1.0).prop_map(|(x, y, z)| Point3::new(x, y, z))
    }

    fn capsule() -> impl Strategy<Value = Capsule> {
        let parts = (point(), point(), 0.01..0.2);
        parts.prop_map(|(from, to, radius_m)| Capsule { from, to, radius_m })
    }

    fn solid_box() -> impl Strategy<Value = AxisBox> {
        capsule().prop_map(|capsule| capsule.axis_box())
    }

    /// The distance by dense sampling of the axis, which is at most half a step too large.
    fn sampled_m(capsule: &Capsule, solid: &impl Solid) -> f64 {
        let axis = capsule.to - capsule.from;
        let samples = (0..=2000).map(|step| capsule.from + axis * (f64::from(step) / 2000.0));
        let nearest = samples.map(|at| solid.offset_to(&at).norm());
        nearest.fold(f64::INFINITY, f64::min) - capsule.radius_m
    }

    proptest! {
        #[test]
        fn distances_to_solids_are_tight_lower_bounds(
            capsule in capsule(),
            solid in solid_box(),
            axis in point(),
            radius_m in 0.0..0.5,
        ) {
            let cylinder = UprightCylinder {
                axis_m: axis.xy(),
                radius_m,
                lowest_m: solid.lowest.z,
                highest_m: solid.highest.z,
            };
            let pairs = [
                (capsule.distance_m(&solid), sampled_m(&capsule, &solid)),
                (capsule.distance_m(&cylinder), sampled_m(&capsule, &cylinder)),
            ];
            for (bound, sampled) in pairs {
                prop_assert!(bound <= sampled + 1e-9, "{bound} <= {sampled}");
                prop_assert!(bound >= sampled - 2e-3, "{bound} is near {sampled}");
            }
        }

        #[test]
        fn distances_between_capsules_are_those_of_samples(a in capsule(), b in capsule()) {
            let axis = b.to - b.from;
            let nearest = (0..=500)
                .map(|step| {
                    let at = b.from + axis * (f64::from(step) / 500.0);
                    sampled_m(&a, &AxisBox { lowest: at, highest: at })
                })
                .fold(f64::INFINITY, f64::min)
                - b.radius_m;
            let found = a.distance_to_capsule_m(&b);
            prop_assert!(found <= nearest + 1e-9 && found >= nearest - 0.01, "{found} {nearest}");
        }
    }
}
