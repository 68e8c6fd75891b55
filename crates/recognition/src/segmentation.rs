//! Items on a tray or a belt: points to clusters.

use nalgebra::{Isometry3, Point2, Point3, Vector3};
use ppnpack_catalogue::mesh::Bounds;
use ppnpack_numbers::{SettingError, within};
use serde::{Deserialize, Serialize};

use crate::groups::{Cells, joined};
use crate::support::Support;

/// A box of the world, in metres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// The corner with the lowest coordinates.
    pub lowest_m: Point3<f64>,
    /// The corner with the greatest coordinates.
    pub highest_m: Point3<f64>,
}

impl Region {
    /// Says whether a point lies within; never one with a coordinate that is not a number.
    pub fn contains(&self, point: &Point3<f64>) -> bool {
        // Points compare along every axis.
        *point >= self.lowest_m && *point <= self.highest_m
    }
}

/// Settings by which points become clusters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SegmentationSettings {
    /// The region of items, in the world. Keep the tray's walls out of it.
    pub region: Region,
    /// The plane that items stand on.
    #[serde(default)]
    pub support: Support,
    /// Minimum height of items over the support, in metres: four standard deviations of the noise.
    #[serde(default = "least_height_m")]
    pub least_height_m: f64,
    /// Maximum gap, seen from above, between points of one item, in metres.
    #[serde(default = "join_m")]
    pub join_m: f64,
    /// Minimum number of points of clusters; those of fewer are specks.
    #[serde(default = "least_points")]
    pub least_points: usize,
}

fn least_height_m() -> f64 {
    0.004
}

fn join_m() -> f64 {
    0.01
}

fn least_points() -> usize {
    30
}

impl SegmentationSettings {
    /// Gives the usual settings for a region.
    pub fn of(region: Region) -> Self {
        Self {
            region,
            support: Support::default(),
            least_height_m: least_height_m(),
            join_m: join_m(),
            least_points: least_points(),
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`SettingError`] names the first that is not possible.
    pub fn validate(&self) -> Result<(), SettingError> {
        let Region {
            lowest_m,
            highest_m,
        } = self.region;
        let side = within("0.001 to 100 m", 0.001..=100.0);
        for side_m in (highest_m - lowest_m).iter() {
            side("region.highest_m less region.lowest_m", *side_m)?;
        }
        within("0.0005 to 1 m", 0.0005..=1.0)("least_height_m", self.least_height_m)?;
        within("0 to 1 m", 0.0..=1.0)("join_m", self.join_m)?;
        within("at least 1", 1.0..)("least_points", self.least_points as f64)
    }
}

/// Points that are taken for one item, in the support frame: z up, the support at height 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Cluster {
    /// Its points, in metres.
    pub points_m: Vec<Point3<f64>>,
    /// Points around it that are not its own, in metres: the support, and other items.
    pub surroundings_m: Vec<Point3<f64>>,
    /// The place of the camera, in metres.
    pub eye_m: Point3<f64>,
    /// The support frame in the world.
    pub world_from_support: Isometry3<f64>,
}

/// Clusters of a cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct Segmentation {
    /// The items, those with the most points first.
    pub clusters: Vec<Cluster>,
    /// The support frame in the world; `None` where no support was found, and then there are no
    /// clusters.
    pub world_from_support: Option<Isometry3<f64>>,
    /// Number of clusters that were dropped as specks.
    pub specks: usize,
}

/// Maximum number of points that are looked at; of more, evenly spaced ones.
const MAX_POINTS: usize = 2_000_000;

/// Reach of the surroundings of a cluster, in metres.
const SURROUNDINGS_M: f64 = 0.015;

impl Cluster {
    /// Gives the least box around the points, along the support frame's axes, in metres; it starts
    /// at the support.
    pub fn extents_m(&self) -> Vector3<f64> {
        Bounds::of(&self.points_m).map_or_else(Vector3::zeros, |bounds| {
            let sides_m = bounds.extents_m();
            Vector3::new(sides_m.x, sides_m.y, bounds.highest.z)
        })
    }
}

/// Finds the clusters of a cloud in the world, in metres, seen from `eye_m`. Points that are not
/// finite are left out.
pub fn segment(
    points_m: impl IntoIterator<Item = Point3<f64>>,
    eye_m: &Point3<f64>,
    settings: &SegmentationSettings,
) -> Segmentation {
    let points_m = points_m.into_iter();
    let within = points_m.filter(|point| settings.region.contains(point));
    let mut within: Vec<Point3<f64>> = within.collect();
    if within.len() > MAX_POINTS {
        let stride = within.len().div_ceil(MAX_POINTS);
        within = within.into_iter().step_by(stride).collect();
    }
    let Some(world_from_support) = settings.support.world_from_support(&within) else {
        return Segmentation {
            clusters: Vec::new(),
            world_from_support: None,
            specks: 0,
        };
    };
    let support_from_world = world_from_support.inverse();
    let rotation = support_from_world.rotation.to_rotation_matrix();
    let shift = support_from_world.translation.vector;
    for point in &mut within {
        *point = rotation * *point + shift;
    }
    let eye_m = support_from_world * eye_m;
    let raised = within
        .iter()
        .filter(|point| point.z >= settings.least_height_m);
    let mut groups = joined(raised.copied().collect(), settings.join_m);
    let found = groups.len();
    groups.retain(|group| group.len() >= settings.least_points);
    let specks = found - groups.len();
    groups.sort_by_key(|group| std::cmp::Reverse(group.len()));
    let clusters = groups.into_iter().map(|points_m| Cluster {
        surroundings_m: surroundings(&points_m, &eye_m, &within, settings.least_height_m),
        points_m,
        eye_m,
        world_from_support,
    });
    Segmentation {
        clusters: clusters.collect(),
        world_from_support: Some(world_from_support),
        specks,
    }
}

/// Gives the points around those of a cluster that are not its own.
fn surroundings(
    points_m: &[Point3<f64>],
    eye_m: &Point3<f64>,
    all_m: &[Point3<f64>],
    least_height_m: f64,
) -> Vec<Point3<f64>> {
    let Some(bounds) = Bounds::of(points_m) else {
        return Vec::new();
    };
    let (lowest, highest, top_m) = (bounds.lowest.xy(), bounds.highest.xy(), bounds.highest.z);
    let cells = Cells::over(&bounds);
    let is_covered = cells.covered(points_m);
    let is_own = |point: &Point3<f64>| {
        let is_inside = point.xy() >= lowest && point.xy() <= highest;
        is_inside && is_covered.get(cells.at(point)).copied().unwrap_or(false)
    };
    // What an item hides lies away from the camera: the parallax of its top.
    let share = top_m / (eye_m.z - top_m).max(top_m).max(0.01);
    let reach = |side: Point2<f64>| {
        let away_m = (side - eye_m.xy()).abs();
        away_m.map(|away_m| SURROUNDINGS_M + share * away_m)
    };
    let (low, high) = (lowest - reach(lowest), highest + reach(highest));
    let is_near = |point: &&Point3<f64>| point.xy() >= low && point.xy() <= high;
    let is_other = |point: &&Point3<f64>| point.z < least_height_m || !is_own(point);
    let around = all_m.iter().filter(is_near).filter(is_other);
    around.copied().collect()
}
