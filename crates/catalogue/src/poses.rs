//! The poses in which objects may be packed, by their numbers: pose 0 is that in which the
//! catalogue has an object, the others follow by falling probability.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use nalgebra::{Matrix3, Point2, Point3, Rotation3, UnitQuaternion, Vector3};
use ppnpack_packing::kernel::grid::Resolution;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::kernel::rectangle::least_rectangle_rad;

use crate::build::longer_side_along_x;
use crate::hull::hull;
use crate::mesh::Bounds;
use crate::object::{Model, PosedObject};
use crate::views;

/// Poses less likely than this are left out. All facets of a round object on which it lies alike
/// count together.
const MIN_PROBABILITY: f64 = 0.03;

/// Poses whose upward directions are within this angle are one, in radians.
const SAME_UP_RAD: f64 = PI / 90.0;

/// Greatest difference of lengths in poses that are one by symmetry, in metres.
const SAME_M: f64 = 0.001;

/// Greatest difference of moments of inertia in poses that are one by symmetry, as a share of their
/// sum.
const SAME_SHARE: f64 = 0.01;

/// The poses in which an object rests, without that in which it stands, whose item is given: at
/// most `most`, the most probable first, each with its footprint turned to fill the least
/// rectangle, the longer side along x.
///
/// Of poses that are the same but for a yaw or a symmetry of the object, there is one. Poses in
/// which the object has more cells or units than the engine represents are left out.
pub(crate) fn further(
    model: &Model,
    standing: &Item,
    most: usize,
    resolution: &Resolution,
) -> Vec<PosedObject> {
    let mut found: Vec<PosedObject> = Vec::new();
    if most == 0 {
        return found;
    }
    for pose in distinct(model) {
        let turned = model.turned(&pose.rotation);
        let Ok(item) = views::item(&turned, resolution) else {
            continue;
        };
        let mut others = found.iter().map(|posed| &*posed.item);
        if !is_alike(&item, standing) && !others.any(|other| is_alike(&item, other)) {
            found.push(PosedObject {
                model: Arc::new(turned),
                item: Arc::new(item),
                rotation: pose.rotation,
            });
        }
        if found.len() == most {
            break;
        }
    }
    found
}

/// Gives the probability that an object that falls comes to rest as it stands, between 0 and 1.
/// All facets on which it lies alike count together.
pub fn probability(model: &Model) -> f64 {
    let standing = all(model).into_iter().next();
    standing.map_or(0.0, |pose| pose.probability)
}

/// Whether two items have the same heightmaps at the first yaw.
fn is_alike(one: &Item, other: &Item) -> bool {
    let views = one.views().first().zip(other.views().first());
    views.is_some_and(|(one, other)| {
        let (top, bottom) = (other.top(), other.bottom());
        one.nx() == other.nx() && one.top() == top && one.bottom() == bottom
    })
}

/// The poses that are likely enough, the most probable first, without that in which a model stands.
fn distinct(model: &Model) -> Vec<DistinctPose> {
    let further = all(model).into_iter().skip(1);
    let likely = further.filter(|pose| pose.probability >= MIN_PROBABILITY);
    let mut likely: Vec<DistinctPose> = likely.collect();
    likely.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    likely
}

/// The poses of a model, that in which it stands first.
fn all(model: &Model) -> Vec<DistinctPose> {
    let Some(hull) = hull(&model.mesh.vertices) else {
        return Vec::new();
    };
    let of = |rotation: &UnitQuaternion<f64>, probability| {
        DistinctPose::new(model, &hull.vertices, rotation, probability)
    };
    let Some(standing) = of(&UnitQuaternion::identity(), 0.0) else {
        return Vec::new();
    };
    let mut poses = vec![standing];
    for resting in &model.resting_poses {
        let Some(pose) = of(&resting.rotation, resting.probability) else {
            continue;
        };
        match poses.iter_mut().find(|known| known.is_same(&pose)) {
            Some(known) => known.probability += pose.probability,
            None => poses.push(pose),
        }
    }
    poses
}

/// A pose, its footprint turned to fill the least rectangle, and what tells it from others.
struct DistinctPose {
    /// Turns the item frame into the pose.
    rotation: UnitQuaternion<f64>,
    probability: f64,
    /// The direction of the item frame that points up.
    up: Vector3<f64>,
    /// The box around the object.
    extents_m: Vector3<f64>,
    /// The centre of mass, seen from the middle of the box.
    centre_m: Vector3<f64>,
    /// The moments of inertia about the centre of mass, over the mass.
    inertia_m2: Matrix3<f64>,
}

impl DistinctPose {
    /// The pose that `laid` turns a model into, whose hull has these vertices; `None` where it has
    /// none.
    fn new(
        model: &Model,
        hull: &[Point3<f64>],
        laid: &UnitQuaternion<f64>,
        probability: f64,
    ) -> Option<Self> {
        let plan = hull.iter().map(|vertex| (laid * vertex).xy());
        let plan: Vec<Point2<f64>> = plan.collect();
        let yaw_rad = -least_rectangle_rad(plan.iter().copied())?;
        let yaw_rad = longer_side_along_x(&plan, yaw_rad);
        let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad) * laid;
        let matrix = rotation.to_rotation_matrix();
        let turned: Vec<Point3<f64>> = hull.iter().map(|vertex| matrix * vertex).collect();
        let bounds = Bounds::of(&turned)?;
        let middle = nalgebra::center(&bounds.lowest, &bounds.highest);
        let mass = &model.mass;
        Some(Self {
            rotation,
            probability,
            up: rotation.inverse() * Vector3::z(),
            extents_m: bounds.extents_m(),
            centre_m: matrix * mass.centre_of_mass_m - middle,
            inertia_m2: matrix * mass.inertia_kg_m2 * matrix.inverse() / mass.mass_kg,
        })
    }

    /// Whether an object looks the same in both, but for a yaw, as far as its box, its centre of
    /// mass and its inertia tell.
    fn is_same(&self, other: &Self) -> bool {
        let moment_m2 = SAME_SHARE * self.inertia_m2.trace();
        let is_same_at = |quarters: u8| {
            let angle_rad = f64::from(quarters) * FRAC_PI_2;
            let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle_rad);
            let extents_m = (turn * other.extents_m).abs();
            let inertia_m2 = turn * other.inertia_m2 * turn.inverse();
            (self.extents_m - extents_m).amax() < SAME_M
                && (self.centre_m - turn * other.centre_m).amax() < SAME_M
                && (self.inertia_m2 - inertia_m2).amax() < moment_m2
        };
        // The footprint's longer side is along x; it is turned by a half turn, or by any quarter
        // turn where it is square.
        self.up.angle(&other.up) < SAME_UP_RAD || (0..4).any(is_same_at)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;
    use std::iter::once;

    use nalgebra::Isometry3;

    use super::*;
    use crate::build::{ModelSettings, model};
    use crate::mesh::Mesh;
    use crate::shapes::cube;

    /// The further poses of a mesh, and its model.
    fn poses(mesh: Mesh, most: usize) -> (Model, Vec<PosedObject>) {
        let (model, _) = model("object", mesh, &ModelSettings::default()).unwrap();
        let resolution = Resolution::reference();
        let item = views::item(&model, &resolution).unwrap();
        let found = further(&model, &item, most, &resolution);
        (model, found)
    }

    /// Cells along x and y and units of height at the first yaw.
    fn sizes(poses: &[PosedObject]) -> Vec<[usize; 3]> {
        let views = poses.iter().map(|posed| &posed.item.views()[0]);
        views
            .map(|view| {
                [
                    view.nx(),
                    view.ny(),
                    usize::try_from(view.height()).unwrap(),
                ]
            })
            .collect()
    }

    #[test]
    fn a_box_has_three_poses_and_a_cube_one() {
        let mesh = Mesh::cuboid([0.0; 3], [0.05, 0.03, 0.02]);
        let (_, found) = poses(mesh.clone(), 5);
        assert_eq!(sizes(&found), [[5, 2, 15], [3, 2, 25]]);
        assert_eq!(sizes(&poses(mesh.clone(), 1).1), [[5, 2, 15]]);
        assert!(poses(mesh, 0).1.is_empty());
        assert!(poses(cube(0.05), 5).1.is_empty());
    }

    #[test]
    fn the_probabilities_of_a_boxs_poses_are_those_of_its_sides() {
        let (model, found) = poses(Mesh::cuboid([0.0; 3], [0.05, 0.03, 0.02]), 5);
        let turned = found.iter().map(|posed| &*posed.model);
        let all: Vec<f64> = once(&model).chain(turned).map(probability).collect();
        assert!((all.iter().sum::<f64>() - 1.0).abs() < 1e-6, "{all:?}");
        assert!(all.is_sorted_by(|one, next| one > next), "{all:?}");
    }

    #[test]
    fn an_object_that_stands_askew_by_yaw_has_the_same_poses() {
        let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.4);
        let mesh = Mesh::cuboid([-0.1, 0.2, 0.0], [-0.05, 0.23, 0.02]);
        let mesh = mesh.transformed(&nalgebra::convert::<_, Isometry3<f64>>(yaw));
        let (_, found) = poses(mesh, 5);
        assert_eq!(sizes(&found), [[5, 2, 15], [3, 2, 25]]);
    }

    #[test]
    fn the_side_of_a_can_is_one_pose_however_many_facets_it_has() {
        let corner = |step: u32, z| {
            let turn_rad = TAU * f64::from(step) / 48.0;
            Point3::new(0.03 * turn_rad.cos(), 0.03 * turn_rad.sin(), z)
        };
        let corners = (0..48).flat_map(|step| [corner(step, 0.0), corner(step, 0.1)]);
        let corners: Vec<Point3<f64>> = corners.collect();
        let (model, found) = poses(hull(&corners).unwrap(), 5);
        let mut sides = model.resting_poses.iter();
        assert!(sides.any(|pose| pose.probability < MIN_PROBABILITY));
        assert_eq!(sizes(&found), [[10, 6, 30]]);
    }

    #[test]
    fn what_tapers_stands_on_both_ends_and_lies_on_its_sides() {
        let corners = [(0.03, 0.0), (0.015, 0.05)].map(|(half_m, z)| {
            let corner = |x: f64, y: f64| Point3::new(x * half_m, y * half_m, z);
            [
                corner(-1.0, -1.0),
                corner(-1.0, 1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
            ]
        });
        let (_, found) = poses(hull(corners.as_flattened()).unwrap(), 5);
        let up_z = |posed: &PosedObject| (posed.rotation.inverse() * Vector3::z()).z;
        let [side, end] = &found[..] else {
            panic!("{} poses", found.len());
        };
        assert!(
            up_z(side).abs() < 0.5,
            "the four sides are one, and likelier"
        );
        assert!((up_z(end) + 1.0).abs() < 1e-9);
        assert_eq!(end.item.views()[0].height(), 25);
    }
}
