//! The ways in which an object shows little of itself.

use nalgebra::{Point3, Vector3};

use crate::object::LibraryObject;
use crate::samples::direction;

/// The room that an object takes in some orientation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stance {
    /// Length and width seen from above, in metres.
    pub(crate) length_m: f64,
    pub(crate) width_m: f64,
    /// Height, in metres.
    pub(crate) height_m: f64,
    /// The area that it covers seen from above, in square metres.
    pub(crate) area_m2: f64,
}

/// Number of directions that are looked from.
const DIRECTIONS: usize = 64;

/// Gives the object at rest in each pose that is searched, and as it covers least: a pen may stand
/// in a gap.
pub(crate) fn stances(object: &LibraryObject) -> Vec<Stance> {
    let resting = object.poses.iter().map(|pose| {
        let outline = &pose.outline;
        // The covered area of an even shape is its length times its width; the spread along the
        // length tells that.
        let length_m = 12.0_f64.sqrt() * outline.spreads_m[0].max(1e-6);
        let area_m2 = outline.width_m * outline.width_m;
        Stance {
            length_m,
            width_m: (area_m2 / length_m).min(outline.width_m),
            height_m: outline.height_m,
            area_m2,
        }
    });
    resting.chain(slimmest(object)).collect()
}

/// Gives the orientation in which the object covers least.
fn slimmest(object: &LibraryObject) -> Option<Stance> {
    let corners = object.model.mesh.corners();
    let doubled_m2 = corners.map(|[a, b, c]: [Point3<f64>; 3]| (b - a).cross(&(c - a)).norm());
    let each_m2 = doubled_m2.sum::<f64>() / 2.0 / object.points.len().max(1) as f64;
    let resting = object.model.resting_poses.iter();
    let resting = resting.map(|pose| pose.rotation.inverse() * Vector3::z());
    let spread = (0..DIRECTIONS).map(|number| direction(number, DIRECTIONS));
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let downs = resting.chain(spread).chain(axes);
    let stances = downs.map(|down| {
        let (mut area_m2, mut low_m, mut high_m) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
        for point in &object.points {
            // Half of a closed surface faces up.
            area_m2 += 0.5 * each_m2 * point.normal.dot(&down).abs();
            let along_m = point.point.coords.dot(&down);
            (low_m, high_m) = (along_m.min(low_m), along_m.max(high_m));
        }
        Stance {
            length_m: area_m2.sqrt(),
            width_m: area_m2.sqrt(),
            height_m: high_m - low_m,
            area_m2,
        }
    });
    stances.min_by(|a, b| a.area_m2.total_cmp(&b.area_m2))
}
