//! How far an estimated pose is from the true one.

use nalgebra::{Isometry3, Point3};

use crate::library::{Library, LibraryObject};
use crate::outline::UpperSurface;
use crate::samples::SurfacePoint;

/// The error of a pose, over everything that looks the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseError {
    /// The distance between the centres of mass, in metres.
    pub position_m: f64,
    /// The angle between the orientations, modulo the object's near symmetry, in radians.
    pub angle_rad: f64,
}

impl PoseError {
    /// Whether both errors are within limits.
    pub fn is_within(&self, position_m: f64, angle_rad: f64) -> bool {
        self.position_m <= position_m && self.angle_rad <= angle_rad
    }
}

impl Library {
    /// The error of an estimate of an object's pose, where the estimate may be of a twin; `None` where it is of an
    /// object that looks different, or an index is none of the library's.
    ///
    /// Positions are compared at the point that every turn which looks the same leaves in place. The turns that a library
    /// lists are some of all that look the same: an object that is round but for details does after any. So the object in
    /// the estimated pose is also aligned with itself in the true one, and where the surfaces coincide then, the error is
    /// what the alignment moved it by.
    pub fn pose_error(
        &self,
        object: usize,
        world_from_item: &Isometry3<f64>,
        estimated_object: usize,
        world_from_estimated: &Isometry3<f64>,
    ) -> Option<PoseError> {
        let entry = self.objects.get(object)?;
        let estimated = if object == estimated_object {
            *world_from_estimated
        } else {
            let twin = entry
                .twins
                .iter()
                .find(|twin| twin.object == estimated_object)?;
            world_from_estimated * twin.twin_from_item
        };
        let apart_m = |one: &Isometry3<f64>, other: &Isometry3<f64>| {
            nalgebra::distance(&(one * entry.centre_m), &(other * entry.centre_m))
        };
        let listed = PoseError {
            position_m: apart_m(world_from_item, &estimated),
            angle_rad: entry
                .near_symmetry
                .angle_between(&estimated.rotation, &world_from_item.rotation),
        };
        let same = &self.settings.same_surface;
        let turned = world_from_item.inverse() * estimated;
        let fitted = same.fitted(&entry.nearest, &entry.points, &turned);
        let fitted = fitted.map(|like| PoseError {
            position_m: apart_m(&like, &turned),
            angle_rad: like.rotation.angle_to(&turned.rotation),
        });
        Some(match fitted {
            Some(fitted) if fitted.angle_rad < listed.angle_rad => fitted,
            _ => listed,
        })
    }
}

/// How far below the upper surface a point may be that is seen, in metres.
const SEEN_BELOW_M: f64 = 0.002;

impl Library {
    /// Whether what can be seen from above of an object in two poses is the same within the library's tolerance: no camera
    /// above could tell them apart. The support frame has z up.
    ///
    /// This is the idea of the visible surface discrepancy (Hodan et al. 2016): hidden sides do not count.
    pub fn looks_same_from_above(
        &self,
        object: usize,
        support_from_item: &Isometry3<f64>,
        estimated_object: usize,
        support_from_estimated: &Isometry3<f64>,
    ) -> bool {
        let (Some(one), Some(other)) =
            (self.objects.get(object), self.objects.get(estimated_object))
        else {
            return false;
        };
        let same = &self.settings.same_surface;
        let other_from_one = support_from_estimated.inverse() * support_from_item;
        let one_seen = seen_from_above(one, support_from_item);
        same.holds(&other.nearest, &one_seen, &other_from_one) && {
            let other_seen = seen_from_above(other, support_from_estimated);
            same.holds(&one.nearest, &other_seen, &other_from_one.inverse())
        }
    }
}

/// The sampled points of an object that nothing of it covers.
fn seen_from_above(
    object: &LibraryObject,
    support_from_item: &Isometry3<f64>,
) -> Vec<SurfacePoint> {
    let posed = object.model.mesh.transformed(support_from_item);
    let lowest_m = posed.bounds().map_or(0.0, |bounds| bounds.lowest.z);
    let lift = Isometry3::translation(0.0, 0.0, -lowest_m);
    let Some(surface) = UpperSurface::of_mesh(&posed.transformed(&lift), 0.0) else {
        return Vec::new();
    };
    let is_seen = |point: &&SurfacePoint| {
        let place: Point3<f64> = lift * support_from_item * point.point;
        let up = (support_from_item.rotation * point.normal).z;
        // The surface is the greatest height in a cell: what leans lies lower at the cell's other side.
        let slack_m = SEEN_BELOW_M + 0.002 * (1.0 - up * up).max(0.0).sqrt() / up.max(0.2);
        up > 0.1 && place.z > f64::from(surface.at(&place.xy())) - slack_m
    };
    object.points.iter().filter(is_seen).copied().collect()
}
