//! Errors of estimated poses.

use nalgebra::Isometry3;

use crate::library::Library;

/// The error of a pose, over everything that looks the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseError {
    /// The distance between the centres of mass, in metres.
    pub position_m: f64,
    /// The angle between the orientations, modulo the object's near symmetry, in radians.
    pub angle_rad: f64,
}

impl PoseError {
    /// Says whether both errors are within limits.
    pub fn is_within(&self, position_m: f64, angle_rad: f64) -> bool {
        self.position_m <= position_m && self.angle_rad <= angle_rad
    }
}

impl Library {
    /// Gives the error of an estimate of an object's pose, where the estimate may be of a twin;
    /// `None` where it is of an object that looks different, or an index is none of the library's.
    ///
    /// Positions are compared at the point that every turn which looks the same leaves in place.
    /// The turns that a library lists are some of all that look the same: an object that is round
    /// but for details does after any. So the object in the estimated pose is also aligned with
    /// itself in the true one, and where the surfaces coincide then, the error is what the
    /// alignment moved it by.
    pub fn pose_error(
        &self,
        object: usize,
        world_from_item: &Isometry3<f64>,
        estimated_object: usize,
        world_from_estimated: &Isometry3<f64>,
    ) -> Option<PoseError> {
        let entry = self.objects.get(object)?;
        let mut estimated = *world_from_estimated;
        if object != estimated_object {
            let mut twins = entry.twins.iter();
            estimated *= twins
                .find(|twin| twin.object == estimated_object)?
                .twin_from_item;
        }
        let apart_m = |one: &Isometry3<f64>, other: &Isometry3<f64>| {
            nalgebra::distance(&(one * entry.centre_m), &(other * entry.centre_m))
        };
        let (found, truth) = (&estimated.rotation, &world_from_item.rotation);
        let listed = PoseError {
            position_m: apart_m(world_from_item, &estimated),
            angle_rad: entry.near_symmetry.angle_between(found, truth),
        };
        let same = &self.settings.same_surface;
        let turned = world_from_item.inverse() * estimated;
        let fitted = same.fitted(&entry.nearest, &entry.points, &turned);
        let fitted = fitted.map(|like| PoseError {
            position_m: apart_m(&like, &turned),
            angle_rad: like.rotation.angle_to(&turned.rotation),
        });
        let better = fitted.filter(|fitted| fitted.angle_rad < listed.angle_rad);
        Some(better.unwrap_or(listed))
    }
}
