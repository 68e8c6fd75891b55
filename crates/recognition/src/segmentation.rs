//! Items on a tray or a belt: points to clusters.

use nalgebra::{Isometry3, Point2, Point3, Vector3};
use ppnpack_numbers::{SettingError, require};
use serde::{Deserialize, Serialize};

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
    /// Whether a point lies within; never one with a coordinate that is not a number.
    pub fn contains(&self, point: &Point3<f64>) -> bool {
        let axes = point
            .iter()
            .zip(self.lowest_m.iter().zip(self.highest_m.iter()));
        axes.into_iter()
            .all(|(value, (lowest, highest))| (lowest..=highest).contains(&value))
    }
}

/// How points become clusters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SegmentationSettings {
    /// Where items may be, in the world. Keep the tray's walls out of it.
    pub region: Region,
    /// The plane that they stand on.
    #[serde(default)]
    pub support: Support,
    /// What is lower than this over the support is not part of an item, in metres; four standard deviations of the
    /// noise keep the support itself out.
    #[serde(default = "least_height_m")]
    pub least_height_m: f64,
    /// Points with a gap of up to this between them, seen from above, belong to one item, in metres.
    #[serde(default = "join_m")]
    pub join_m: f64,
    /// Clusters of fewer points are specks.
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
    /// The usual settings for a region.
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
        for side_m in (highest_m - lowest_m).iter() {
            let name = "region.highest_m less region.lowest_m";
            require(name, *side_m, "0.001 to 100 m", |side_m| {
                (0.001..=100.0).contains(&side_m)
            })?;
        }
        require(
            "least_height_m",
            self.least_height_m,
            "0.0005 to 1 m",
            |height_m| (0.0005..=1.0).contains(&height_m),
        )?;
        require("join_m", self.join_m, "0 to 1 m", |join_m| {
            (0.0..=1.0).contains(&join_m)
        })?;
        let least_points = self.least_points as f64;
        require("least_points", least_points, "at least 1", |least| {
            least >= 1.0
        })
    }
}

/// What is taken for one item, in the support frame: z up, the support at height 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Cluster {
    /// Its points, in metres.
    pub points_m: Vec<Point3<f64>>,
    /// Points around it that are not its own, in metres: the support, and other items.
    pub surroundings_m: Vec<Point3<f64>>,
    /// Where the camera is, in metres.
    pub eye_m: Point3<f64>,
    /// The support frame in the world.
    pub world_from_support: Isometry3<f64>,
}

/// What a cloud shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Segmentation {
    /// The items, those with the most points first.
    pub clusters: Vec<Cluster>,
    /// The support frame in the world; `None` where no support was found, and then there are no clusters.
    pub world_from_support: Option<Isometry3<f64>>,
    /// How many clusters were dropped as specks.
    pub specks: usize,
}

/// The edge of a cell of the grid that points are joined on, in metres.
const CELL_M: f64 = 0.004;

/// The most cells along a side; larger regions have larger cells.
const MAX_CELLS: f64 = 1024.0;

/// The most points that are looked at; of more, evenly spaced ones.
const MAX_POINTS: usize = 2_000_000;

/// How far the surroundings of a cluster reach, in metres.
const SURROUNDINGS_M: f64 = 0.015;

impl Cluster {
    /// The least box around the points, along the support frame's axes, in metres; it starts at the support.
    pub fn extents_m(&self) -> Vector3<f64> {
        let Some((lowest, highest)) = bounds(&self.points_m) else {
            return Vector3::zeros();
        };
        Vector3::new(highest.x - lowest.x, highest.y - lowest.y, highest.z)
    }
}

/// The clusters of a cloud: points in the world, in metres, seen by a camera at `eye_m`. Points that are not finite are
/// left out.
pub fn segment(
    points_m: impl IntoIterator<Item = Point3<f64>>,
    eye_m: &Point3<f64>,
    settings: &SegmentationSettings,
) -> Segmentation {
    let mut within: Vec<Point3<f64>> = points_m
        .into_iter()
        .filter(|point| settings.region.contains(point))
        .collect();
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
    within
        .iter_mut()
        .for_each(|point| *point = rotation * *point + shift);
    let eye_m = support_from_world * eye_m;
    let (groups, specks) = groups(&within, settings);
    let mut clusters: Vec<Cluster> = groups
        .into_iter()
        .map(|points_m| Cluster {
            surroundings_m: Vec::new(),
            points_m,
            eye_m,
            world_from_support,
        })
        .collect();
    clusters.sort_by_key(|cluster| std::cmp::Reverse(cluster.points_m.len()));
    let all: Vec<Point3<f64>> = within;
    for cluster in &mut clusters {
        cluster.surroundings_m = surroundings(cluster, &all, settings.least_height_m);
    }
    Segmentation {
        clusters,
        world_from_support: Some(world_from_support),
        specks,
    }
}

fn bounds(points: &[Point3<f64>]) -> Option<(Point3<f64>, Point3<f64>)> {
    let first = *points.first()?;
    Some(
        points
            .iter()
            .fold((first, first), |(lowest, highest), point| {
                (lowest.inf(point), highest.sup(point))
            }),
    )
}

/// A grid over the support.
struct Cells {
    origin: Point2<f64>,
    edge_m: f64,
    nx: usize,
    ny: usize,
}

impl Cells {
    fn over(points: &[Point3<f64>]) -> Option<Self> {
        let (lowest, highest) = bounds(points)?;
        let extents = highest - lowest;
        let edge_m = CELL_M.max(extents.x.max(extents.y) / MAX_CELLS);
        let count = |extent: f64| (extent / edge_m).floor() as usize + 1;
        Some(Self {
            origin: lowest.xy(),
            edge_m,
            nx: count(extents.x),
            ny: count(extents.y),
        })
    }

    /// The cell of a point within the grid.
    fn at(&self, point: &Point3<f64>) -> usize {
        let offset = (point.xy() - self.origin) / self.edge_m;
        let (x, y) = (offset.x as usize, offset.y as usize);
        x.min(self.nx - 1) * self.ny + y.min(self.ny - 1)
    }

    /// The cells within a distance in cells.
    fn around(&self, cell: usize, reach: usize) -> impl Iterator<Item = usize> + '_ {
        let (x, y) = (cell / self.ny, cell % self.ny);
        let xs = x.saturating_sub(reach)..(x + reach + 1).min(self.nx);
        xs.flat_map(move |x| {
            (y.saturating_sub(reach)..(y + reach + 1).min(self.ny)).map(move |y| x * self.ny + y)
        })
    }
}

/// Stands for a cell of no group.
const NO_GROUP: u32 = u32::MAX;

/// The points above the support in groups that hang together seen from above, and the number of specks.
fn groups(
    points: &[Point3<f64>],
    settings: &SegmentationSettings,
) -> (Vec<Vec<Point3<f64>>>, usize) {
    let raised: Vec<Point3<f64>> = points
        .iter()
        .filter(|point| point.z >= settings.least_height_m)
        .copied()
        .collect();
    let mut groups = joined(raised, settings.join_m);
    let found = groups.len();
    groups.retain(|group| group.len() >= settings.least_points);
    let specks = found - groups.len();
    (groups, specks)
}

/// Points in groups: seen from above, no gap within a group is wider than `join_m`.
pub(crate) fn joined(raised: Vec<Point3<f64>>, join_m: f64) -> Vec<Vec<Point3<f64>>> {
    let Some(cells) = Cells::over(&raised) else {
        return Vec::new();
    };
    let mut is_covered = vec![false; cells.nx * cells.ny];
    for point in &raised {
        if let Some(cell) = is_covered.get_mut(cells.at(point)) {
            *cell = true;
        }
    }
    let reach = (join_m / cells.edge_m).floor().clamp(1.0, 16.0) as usize;
    let group_of = labels(&cells, &is_covered, reach);
    let count = group_of
        .iter()
        .filter(|group| **group != NO_GROUP)
        .max()
        .map_or(0, |last| *last as usize + 1);
    let mut groups = vec![Vec::new(); count];
    for point in raised {
        let group = group_of.get(cells.at(&point)).map(|group| *group as usize);
        if let Some(group) = group.and_then(|group| groups.get_mut(group)) {
            group.push(point);
        }
    }
    groups
}

/// The group of each covered cell.
fn labels(cells: &Cells, is_covered: &[bool], reach: usize) -> Vec<u32> {
    let mut group_of = vec![NO_GROUP; is_covered.len()];
    let mut next_group = 0;
    let mut queue = Vec::new();
    let is_free = |cell: usize, group_of: &[u32]| {
        is_covered.get(cell).copied().unwrap_or(false) && group_of.get(cell) == Some(&NO_GROUP)
    };
    for start in 0..is_covered.len() {
        if !is_free(start, &group_of) {
            continue;
        }
        queue.push(start);
        if let Some(group) = group_of.get_mut(start) {
            *group = next_group;
        }
        while let Some(cell) = queue.pop() {
            for other in cells.around(cell, reach) {
                if is_free(other, &group_of)
                    && let Some(group) = group_of.get_mut(other)
                {
                    *group = next_group;
                    queue.push(other);
                }
            }
        }
        next_group += 1;
    }
    group_of
}

/// The points around a cluster that are not its own.
fn surroundings(cluster: &Cluster, all: &[Point3<f64>], least_height_m: f64) -> Vec<Point3<f64>> {
    let Some(own) = Cells::over(&cluster.points_m) else {
        return Vec::new();
    };
    let Some((lowest, highest)) = bounds(&cluster.points_m) else {
        return Vec::new();
    };
    let mut is_own = vec![false; own.nx * own.ny];
    for point in &cluster.points_m {
        if let Some(cell) = is_own.get_mut(own.at(point)) {
            *cell = true;
        }
    }
    let is_inside = |point: &Point3<f64>| {
        point.x >= lowest.x && point.x <= highest.x && point.y >= lowest.y && point.y <= highest.y
    };
    let is_near = |point: &&Point3<f64>| {
        // What an item hides lies away from the camera: the parallax of its top.
        let share = highest.z / (cluster.eye_m.z - highest.z).max(highest.z).max(0.01);
        let reach = |from: f64, to: f64| SURROUNDINGS_M + share * (from - to).abs();
        let low = |axis: usize| lowest[axis] - reach(cluster.eye_m[axis], lowest[axis]);
        let high = |axis: usize| highest[axis] + reach(cluster.eye_m[axis], highest[axis]);
        point.x >= low(0) && point.x <= high(0) && point.y >= low(1) && point.y <= high(1)
    };
    let is_other = |point: &&Point3<f64>| {
        point.z < least_height_m
            || !(is_inside(point) && is_own.get(own.at(point)).copied().unwrap_or(false))
    };
    all.iter()
        .filter(is_near)
        .filter(is_other)
        .copied()
        .collect()
}
