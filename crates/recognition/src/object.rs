//! An object that can be recognised, prepared once.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use ppnpack_catalogue::object::{Model, RestingPose};

use crate::nearest::NearestSurface;
use crate::outline::{Outline, UpperSurface};
use crate::samples::{SurfacePoint, surface_points};
use crate::symmetry::{SameSurface, Symmetry};
use ppnpack_numbers::settings;

settings! {
    /// Settings of the preparation of objects.
    #[derive(Copy)]
    pub struct LibrarySettings {
        /// Resting poses less likely than this are not searched, unless there is no other.
        pub least_probability: f64 = 0.003,
        /// Resting poses whose lower sides are within this angle are searched as one, in radians.
        pub same_pose_rad: f64 = 0.14,
        /// When surfaces count as the same: of twins, of views from above, of an object that is
        /// turned.
        pub same_surface: SameSurface = SameSurface::default(),
        /// When a turned object is nearly the same, where orientations are compared: a fruit is a
        /// ball to a packer.
        pub nearly_same: SameSurface = SameSurface {
                root_mean_square_m: 0.0015,
                nearly_all_m: 0.004,
            },
        /// Minimum height over the support of what is seen as part of an item, in metres; as in the
        /// segmentation.
        pub least_height_m: f64 = 0.004,
    }
}

/// Number of points that an object's surface is sampled at.
const SURFACE_POINTS: usize = 500;

/// Maximum number of resting poses between which symmetries are looked for.
const MAX_SYMMETRIC_POSES: usize = 8;

/// A resting pose as the search uses it.
#[derive(Debug, Clone)]
pub struct PoseTemplate {
    /// The object on the support: its lowest point at height 0, the middle of what is seen from
    /// above over the origin.
    pub support_from_item: Isometry3<f64>,
    pub(crate) surface: UpperSurface,
    pub(crate) outline: Outline,
}

/// Another object with the same surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Twin {
    /// Its index in the library.
    pub object: usize,
    /// The twin's item frame from that of the object it is a twin of, such that their surfaces
    /// coincide.
    pub twin_from_item: Isometry3<f64>,
}

/// An object that can be recognised.
#[derive(Debug, Clone)]
pub struct LibraryObject {
    /// Its geometry.
    pub model: Arc<Model>,
    /// Its surface, for lookups.
    pub nearest: NearestSurface,
    /// Points spread evenly over its surface, in the item frame.
    pub points: Vec<SurfacePoint>,
    /// Turns after which it looks the same to the search: resting poses that these join are one.
    pub symmetry: Symmetry,
    /// Turns after which it looks nearly the same: orientations are compared modulo these.
    pub near_symmetry: Symmetry,
    /// The point of the item frame that its near symmetry leaves in place, in metres: positions are
    /// compared there. The centre of mass of an object that looks the same after no turn.
    pub centre_m: Point3<f64>,
    /// The resting poses that are searched, the most probable first.
    pub poses: Vec<PoseTemplate>,
    /// Other objects with the same surface.
    pub twins: Vec<Twin>,
}

impl LibraryObject {
    /// Prepares a model; `None` where it has no surface or no resting pose. Its twins are not known
    /// yet.
    pub(crate) fn new(model: &Arc<Model>, settings: &LibrarySettings) -> Option<Self> {
        let nearest = NearestSurface::of(&model.mesh)?;
        let points = surface_points(&model.mesh, SURFACE_POINTS);
        let centre = model.mass.centre_of_mass_m;
        let as_it_is = Symmetry::Turns(vec![UnitQuaternion::identity()]);
        let distinct = grouped(model, settings, &as_it_is);
        let distinct = distinct.iter().take(MAX_SYMMETRIC_POSES);
        let downs: Vec<_> = distinct.map(|pose| down(&pose.rotation)).collect();
        let find = |same| Symmetry::of(&nearest, &points, &centre, &downs, same);
        let (symmetry, mut centre_m) = find(&settings.same_surface);
        let mut near_symmetry = symmetry.clone();
        if !matches!(symmetry, Symmetry::Ball) {
            (near_symmetry, centre_m) = find(&settings.nearly_same);
        }
        let poses = grouped(model, settings, &symmetry);
        let template = |pose: &RestingPose| PoseTemplate::new(model, pose, settings);
        let poses: Vec<PoseTemplate> = poses.iter().filter_map(template).collect();
        (!poses.is_empty()).then(|| Self {
            model: model.clone(),
            nearest,
            points,
            symmetry,
            near_symmetry,
            centre_m,
            poses,
            twins: Vec::new(),
        })
    }
}

/// Gives the direction of the item frame that points down.
fn down(support_from_item: &UnitQuaternion<f64>) -> Unit<Vector3<f64>> {
    Unit::new_unchecked(support_from_item.inverse() * -Vector3::z())
}

/// Gives the resting poses of a model by falling probability; of those searched as one, the
/// likeliest with the chance of all.
fn grouped(model: &Model, settings: &LibrarySettings, symmetry: &Symmetry) -> Vec<RestingPose> {
    let mut groups: Vec<RestingPose> = Vec::new();
    for pose in &model.resting_poses {
        let direction = down(&pose.rotation);
        let same = groups.iter_mut().find(|group| {
            symmetry.joins(&down(&group.rotation), &direction, settings.same_pose_rad)
        });
        match same {
            Some(group) => group.probability += pose.probability,
            None => groups.push(*pose),
        }
    }
    groups.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    let likely = groups.partition_point(|group| group.probability >= settings.least_probability);
    groups.truncate(likely.max(1));
    groups
}

impl PoseTemplate {
    fn new(model: &Model, group: &RestingPose, settings: &LibrarySettings) -> Option<Self> {
        let turned = model.mesh.transformed(&nalgebra::convert(group.rotation));
        let lowest_m = turned.bounds()?.lowest.z;
        let lift = Translation3::new(0.0, 0.0, -lowest_m);
        let standing = turned.transformed(&nalgebra::convert(lift));
        let seen = |mesh| UpperSurface::of_mesh(mesh, settings.least_height_m);
        let centre = seen(&standing)?.outline()?.centre;
        let shift = Translation3::new(-centre.x, -centre.y, 0.0);
        let surface = seen(&standing.transformed(&nalgebra::convert(shift)))?;
        Some(Self {
            support_from_item: shift * lift * group.rotation,
            outline: surface.outline()?,
            surface,
        })
    }
}
