//! The outcome of a placement, and the container's content.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Vector3};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_catalogue::object::Model;
use ppnpack_packing::kernel::grid::ContainerSize;
use serde::{Deserialize, Serialize};

/// Names a body of one cell; bodies are numbered in the order in which they were placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct BodyId(pub(crate) u32);

impl BodyId {
    /// Counts the bodies that were placed before this one.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A body that lies in or on the container.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyState {
    /// Its number.
    pub id: BodyId,
    /// Its geometry.
    pub model: Arc<Model>,
    /// Its pose.
    pub container_from_item: Isometry3<f64>,
    /// Whether its centre of mass is inside the container.
    pub inside: bool,
}

/// The load on a body, measured where it lies.
///
/// Every other body that touches it pushes it up or down, by the normal forces and the friction of
/// all contacts between the two taken together. The sum of those that push it down is its load,
/// which [`ppnpack_packing::checks::loads`] estimates. Floor and walls are no load; a body higher up counts
/// by the share that it hands down. Impacts are not measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BodyLoad {
    /// The number of the body.
    pub id: BodyId,
    /// The mass that rests on it, in kilograms.
    pub carried_kg: f64,
    /// The force that holds it up beyond its weight and its load, in kilograms; near 0 where it is
    /// at rest, and the measure is right.
    pub unbalanced_kg: f64,
}

/// Maximum slide of a placed item that stayed, in metres.
const SLIDE_LIMIT_M: f64 = 0.02;

/// Says whether a placed item did not stay where it was placed: it toppled, slid by more than 2 cm
/// or is not inside the container.
pub fn is_unsteady(toppled: bool, slide_m: f64, inside: bool) -> bool {
    toppled || !inside || slide_m > SLIDE_LIMIT_M
}

/// Measures how far a posed mesh sticks out above the rim, in metres; below 0 of one that ends lower.
pub fn above_rim_m(
    container: ContainerSize,
    mesh: &Mesh,
    container_from_mesh: &Isometry3<f64>,
) -> f64 {
    let heights_m = mesh.vertices.iter();
    let heights_m = heights_m.map(|vertex| (container_from_mesh * vertex).z);
    heights_m.fold(f64::NEG_INFINITY, f64::max) - container.z_m
}

/// The outcome of a placement by the end of its settling phase.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlacedReport {
    /// The new body.
    pub id: BodyId,
    /// Its pose at the end.
    pub container_from_item: Isometry3<f64>,
    /// Horizontal distance of its centre of mass from where it was planned, in metres.
    pub slide_m: f64,
    /// Height of its centre of mass above where it was planned, in metres; negative when it sank
    /// deeper.
    pub height_change_m: f64,
    /// Angle between its upward axis as planned and at the end, in radians; turns about the
    /// vertical do not count.
    pub tilt_rad: f64,
    /// Whether it tilted by more than the threshold.
    pub toppled: bool,
    /// Whether its centre of mass is inside the container: within the inner walls and below the
    /// rim.
    pub inside: bool,
    /// Whether it left the container and was taken out of the simulation.
    pub lost: bool,
    /// How far the centre of mass of the most disturbed other body moved, in metres; 0 where none
    /// moved.
    pub disturbance_m: f64,
    /// Earlier bodies that left the container in this phase and were taken out.
    pub others_lost: Vec<BodyId>,
    /// Whether every body was at rest at the end; where it is `false`, the next phase goes on from
    /// the motion.
    pub still: bool,
    /// How long the phase took, in seconds of simulated time.
    pub simulated_s: f64,
}

/// Says whether a point is within the inner walls, at or above the floor and at or below the rim.
pub(crate) fn is_inside(container: ContainerSize, point: &Point3<f64>) -> bool {
    (0.0..=container.x_m).contains(&point.x)
        && (0.0..=container.y_m).contains(&point.y)
        && (container.lowest_m(point.x, point.y)..=container.z_m).contains(&point.z)
}

/// Gives the angle between the vertical and what was vertical before `after * before^-1`, in
/// radians.
pub(crate) fn tilt_rad(before: &Isometry3<f64>, after: &Isometry3<f64>) -> f64 {
    let up = after.rotation * before.rotation.inverse_transform_vector(&Vector3::z());
    up.angle(&Vector3::z())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;
    use ppnpack_packing::checks::trial::TrialLimits;

    use crate::settings::CellSettings;

    #[test]
    fn tilt_ignores_yaw() {
        let turned = |roll, yaw| {
            Isometry3::from_parts(
                nalgebra::Translation3::identity(),
                UnitQuaternion::from_euler_angles(roll, 0.0, yaw),
            )
        };
        assert!(tilt_rad(&turned(0.7, 0.0), &turned(0.7, 2.0)) < 1e-7);
        assert!((tilt_rad(&turned(0.7, 1.0), &turned(1.2, 3.0)) - 0.5).abs() < 1e-7);
    }

    #[test]
    fn a_try_allows_less_than_what_counts_as_steady() {
        let limits = TrialLimits::default();
        assert!(limits.tilt_rad < CellSettings::robot().outcome.topple_rad);
        assert!(!is_unsteady(false, limits.slide_m.next_up(), true));
        assert!(!is_unsteady(false, 0.02, true));
        assert!(is_unsteady(false, 0.02_f64.next_up(), true));
    }

    #[test]
    fn inside_ends_at_the_walls_and_the_rim() {
        let container = ContainerSize::REFERENCE;
        assert!(is_inside(container, &Point3::new(0.16, 0.0, 0.3)));
        assert!(!is_inside(container, &Point3::new(0.16, 0.16, 0.301)));
        assert!(!is_inside(container, &Point3::new(-0.001, 0.16, 0.1)));
        let tote = ContainerSize {
            draft_rad: 0.1_f64.atan(),
            ..container
        };
        assert!(is_inside(tote, &Point3::new(0.01, 0.16, 0.21)));
        assert!(!is_inside(tote, &Point3::new(0.01, 0.16, 0.19)));
    }
}
