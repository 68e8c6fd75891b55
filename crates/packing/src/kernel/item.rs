//! Items as the planner sees them: a pair of heightmaps per yaw.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use nalgebra::{Isometry3, Point2, Translation3, UnitQuaternion, Vector2, Vector3};

use crate::kernel::grid::{ABSENT, Grid, MAX_UNITS, Units};
use crate::kernel::layout::ViewLayout;
use crate::kernel::placement::{Placement, RestingPlacement};

/// Why an item could not be made, or does not have what it is asked for, for people.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ItemError(String);

/// An item that was made for another number of yaws than a grid has.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("item {item} has {found} yaws, but the grid {expected}")]
pub struct YawsMismatch {
    item: String,
    found: usize,
    expected: usize,
}

/// The item's finely sampled lower surface in metres, for contact that does not depend on the cell.
///
/// Row-major; samples start at the footprint's corner; `f32::INFINITY` where there is no material.
/// Heights are from the item's lowest point.
#[derive(Debug, Clone, PartialEq)]
pub struct Underside {
    /// Samples along x.
    pub nx: usize,
    /// Samples along y.
    pub ny: usize,
    /// Samples along a cell's edge.
    pub samples_per_cell: usize,
    /// The lowest height within each sample's square, in metres.
    pub heights_m: Vec<f32>,
}

/// Surfaces of an item at one yaw, from which an [`ItemView`] is made.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewSurfaces {
    /// Footprint cells along x.
    pub nx: usize,
    /// Footprint cells along y.
    pub ny: usize,
    /// Upper surface per cell in units from the lowest point, row-major; ignored without material.
    pub top: Vec<Units>,
    /// Lower surface per cell in units, or [`ABSENT`], row-major.
    pub bottom: Vec<Units>,
    /// The finely sampled lower surface, where it is known.
    pub underside: Option<Underside>,
    /// The item frame's origin, seen from the footprint's corner at the lowest point, in metres.
    pub origin_from_corner_m: Vector3<f64>,
    /// The centre of mass over the footprint, from its corner, in metres, where it is known.
    pub centre_of_mass_m: Option<Point2<f64>>,
}

impl ViewSurfaces {
    /// The surfaces of `nx` x `ny` cells, with the footprint's corner as the origin.
    pub fn of_cells(nx: usize, ny: usize, top: Vec<Units>, bottom: Vec<Units>) -> Self {
        Self {
            nx,
            ny,
            top,
            bottom,
            underside: None,
            origin_from_corner_m: Vector3::zeros(),
            centre_of_mass_m: None,
        }
    }
}

/// An item at one yaw: its heightmap pair and what follows from it.
#[derive(Debug, Clone, PartialEq)]
pub struct ItemView {
    surfaces: ViewSurfaces,
    height: Units,
    voxel_count: u64,
    centroid_cells: Point2<f64>,
    pub(crate) columns: Columns,
    pub(crate) layout: ViewLayout,
}

/// Sums over the footprint cells with material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Columns {
    pub(crate) cells: u64,
    pub(crate) top_sum: i64,
}

impl ItemView {
    fn new(item: &str, mut surfaces: ViewSurfaces) -> Result<Self, ItemError> {
        let (nx, ny) = (surfaces.nx, surfaces.ny);
        let sized = |map: &'static str, nx: usize, ny: usize, found: usize| {
            if found == nx * ny {
                return Ok(());
            }
            Err(ItemError(format!(
                "the {map} of item {item} has {found} values where its footprint of {nx} x {ny} needs {}",
                nx * ny
            )))
        };
        sized("upper surface", nx, ny, surfaces.top.len())?;
        sized("lower surface", nx, ny, surfaces.bottom.len())?;
        if let Some(underside) = &surfaces.underside {
            let (samples, found) = (underside.samples_per_cell, underside.heights_m.len());
            sized("underside", nx * samples, ny * samples, found)?;
        }
        let (mut height, mut lowest, mut voxel_count) = (0, Units::MAX, 0_u64);
        let mut sums = Columns::default();
        let mut moment = Vector2::zeros();
        let columns = surfaces.top.iter_mut().zip(&surfaces.bottom).enumerate();
        for (index, (top, bottom)) in columns {
            let (x, y) = (index / ny, index % ny);
            if *bottom == ABSENT {
                *top = 0;
                continue;
            }
            if *bottom < 0 || *top <= *bottom || *top > MAX_UNITS {
                return Err(ItemError(format!(
                    "cell ({x}, {y}) of item {item} has its upper surface at {top} and its lower one at {bottom}; \
                     0 <= lower < upper <= {MAX_UNITS} is needed, or a lower one of -1 where there is no material"
                )));
            }
            height = height.max(*top);
            lowest = lowest.min(*bottom);
            let column = (*top - *bottom) as u64;
            voxel_count += column;
            sums.cells += 1;
            sums.top_sum += i64::from(*top);
            moment += Vector2::new(x as f64 + 0.5, y as f64 + 0.5) * column as f64;
        }
        if lowest != 0 {
            let empty = format!("item {item} has no material at its lowest height");
            return Err(ItemError(empty));
        }
        let centroid_cells = Point2::from(moment / voxel_count as f64);
        let layout = ViewLayout::new(ny, &surfaces.top, &surfaces.bottom);
        Ok(Self {
            surfaces,
            height,
            voxel_count,
            centroid_cells,
            columns: sums,
            layout,
        })
    }

    /// The surfaces that it was made from; upper ones are 0 where there is no material.
    pub fn surfaces(&self) -> &ViewSurfaces {
        &self.surfaces
    }

    /// Footprint cells along x.
    pub fn nx(&self) -> usize {
        self.surfaces.nx
    }

    /// Footprint cells along y.
    pub fn ny(&self) -> usize {
        self.surfaces.ny
    }

    /// Upper surface per cell in units from the lowest point, row-major; 0 without material.
    pub fn top(&self) -> &[Units] {
        &self.surfaces.top
    }

    /// Lower surface per cell in units, or [`ABSENT`], row-major.
    pub fn bottom(&self) -> &[Units] {
        &self.surfaces.bottom
    }

    /// The finely sampled lower surface, where it is known.
    pub fn underside(&self) -> Option<&Underside> {
        self.surfaces.underside.as_ref()
    }

    /// Height from the lowest to the highest point, in units.
    pub fn height(&self) -> Units {
        self.height
    }

    /// The footprint's cells with material: indices along x and y, lower and upper surface in
    /// units.
    pub fn cells(&self) -> impl Iterator<Item = (usize, usize, Units, Units)> {
        let surfaces = self.bottom().iter().zip(self.top()).enumerate();
        surfaces
            .filter(|(_, (bottom, _))| **bottom != ABSENT)
            .map(|(index, (bottom, top))| (index / self.ny(), index % self.ny(), *bottom, *top))
    }

    /// How many placements along x and y lie within a container of so many cells.
    #[inline(always)]
    pub(crate) fn corners(&self, (nx, ny): (usize, usize)) -> (usize, usize) {
        if self.nx() > nx || self.ny() > ny {
            (0, 0)
        } else {
            (nx + 1 - self.nx(), ny + 1 - self.ny())
        }
    }

    /// Whether it stays at or below the rim where it rests at this height, in units.
    pub fn fits_at(&self, grid: &Grid, resting_height: Units) -> bool {
        i32::from(resting_height) + i32::from(self.height) <= i32::from(grid.rim())
    }

    /// `V`: how many voxels the item fills.
    pub fn voxel_count(&self) -> u64 {
        self.voxel_count
    }

    /// `B`: how many voxels the item's bounding box has.
    pub fn box_voxel_count(&self) -> u64 {
        (self.nx() * self.ny()) as u64 * self.height as u64
    }

    /// The mean of the item's voxels over the footprint, in cells from its corner.
    pub fn centroid_cells(&self) -> Point2<f64> {
        self.centroid_cells
    }

    /// The centre of mass from the footprint's corner, in metres; without it the voxels' mean.
    pub fn centre_of_mass_m(&self, cell_m: f64) -> Point2<f64> {
        self.surfaces
            .centre_of_mass_m
            .unwrap_or(self.centroid_cells * cell_m)
    }

    /// The centre of mass over the floor where the view is placed, in the container frame, in
    /// metres.
    pub(crate) fn placed_centre_of_mass_m(&self, at: &Placement, cell_m: f64) -> Point2<f64> {
        let corner = Vector2::new(at.x as f64, at.y as f64) * cell_m;
        self.centre_of_mass_m(cell_m) + corner
    }

    /// The item frame's origin, seen from the footprint's corner at the lowest point, in metres.
    pub fn origin_from_corner_m(&self) -> Vector3<f64> {
        self.surfaces.origin_from_corner_m
    }
}

/// Identifies an item's shape within this process; two items made separately never share one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ShapeId(u64);

/// An item that can be packed: its heightmap pairs, one view per yaw, and what the metrics need.
#[derive(Debug)]
pub struct Item {
    shape: ShapeId,
    name: Arc<str>,
    views: Vec<ItemView>,
    mesh_volume_m3: f64,
}

impl Item {
    /// An item from its surfaces at each yaw, and the volume of its mesh in cubic metres.
    ///
    /// # Errors
    /// [`ItemError`] where a map has the wrong size, a cell's surfaces are out of order, or there is no material.
    pub fn new(
        name: &str,
        views: Vec<ViewSurfaces>,
        mesh_volume_m3: f64,
    ) -> Result<Self, ItemError> {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        if views.is_empty() {
            return Err(ItemError(format!("item {name} has no yaw")));
        }
        let views = views
            .into_iter()
            .map(|view| ItemView::new(name, view))
            .collect::<Result<_, _>>()?;
        let shape = ShapeId(NEXT.fetch_add(1, Ordering::Relaxed));
        Ok(Self {
            shape,
            name: name.into(),
            views,
            mesh_volume_m3,
        })
    }

    /// The item's shape, for caches.
    pub fn shape(&self) -> ShapeId {
        self.shape
    }

    /// The item's name, unique within its catalogue.
    pub fn name(&self) -> &Arc<str> {
        &self.name
    }

    /// One view per yaw.
    pub fn views(&self) -> &[ItemView] {
        &self.views
    }

    /// Gives the view at the yaw of a placement.
    pub fn view(&self, yaw: usize) -> Result<&ItemView, ItemError> {
        self.views.get(yaw).ok_or_else(|| {
            let (item, found) = (&self.name, self.views.len());
            ItemError(format!(
                "broken invariant \"a placement's yaw is one of its item's\": {item} has {found} yaws, not yaw {yaw}"
            ))
        })
    }

    /// Whether it has a view for each yaw of a grid.
    pub fn check_yaws(&self, grid: &Grid) -> Result<(), YawsMismatch> {
        let (found, expected) = (self.views.len(), grid.resolution().yaws().count());
        if found == expected {
            return Ok(());
        }
        let item = self.name.to_string();
        Err(YawsMismatch {
            item,
            found,
            expected,
        })
    }

    /// The volume of the item's mesh, in cubic metres; voxels inflate it, more so on coarse grids.
    pub fn mesh_volume_m3(&self) -> f64 {
        self.mesh_volume_m3
    }

    /// Voxels of the bounding box at the first yaw, by which
    /// [`Order::BboxVolume`](crate::kernel::objective::Order) sorts.
    pub fn box_voxel_count(&self) -> u64 {
        self.views.first().map_or(0, ItemView::box_voxel_count)
    }

    /// Gives the item's frame in the container frame for a placement.
    ///
    /// `None` where the placement names a yaw that the item does not have.
    pub fn container_from_item(
        &self,
        grid: &Grid,
        resting: &RestingPlacement,
    ) -> Option<Isometry3<f64>> {
        let Placement { yaw, x, y } = resting.placement;
        let resolution = grid.resolution();
        let view = self.views.get(yaw)?;
        let yaw_rad = resolution.yaws().radians().get(yaw)?;
        let corner = Vector3::new(
            x as f64 * resolution.cell_m(),
            y as f64 * resolution.cell_m(),
            f64::from(resting.resting_height) * resolution.height_unit_m(),
        );
        let translation = Translation3::from(corner + view.origin_from_corner_m());
        let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), *yaw_rad);
        Some(Isometry3::from_parts(translation, rotation))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_counts_its_voxels_and_their_mean() {
        let surfaces = ViewSurfaces::of_cells(1, 2, vec![4, 2], vec![0, 1]);
        let item = Item::new("ell", vec![surfaces], 0.0).unwrap();
        let view = &item.views()[0];
        assert_eq!(
            (view.voxel_count(), view.box_voxel_count(), view.height()),
            (5, 8, 4)
        );
        assert!((view.centroid_cells() - Point2::new(0.5, 0.7)).norm() < 1e-12);
    }

    #[test]
    fn impossible_items_are_refused() {
        let refusal = |ny, top: &[Units], bottom: &[Units]| {
            let view = ViewSurfaces::of_cells(1, ny, top.to_vec(), bottom.to_vec());
            Item::new("bad", vec![view], 0.0).unwrap_err()
        };
        let no_view = Item::new("none", vec![], 0.0).unwrap_err();
        for (refused, expected) in [
            (
                refusal(2, &[1], &[0, 0]),
                "has 1 values where its footprint",
            ),
            (
                refusal(1, &[1], &[1]),
                "upper surface at 1 and its lower one at 1",
            ),
            (
                refusal(1, &[2], &[1]),
                "has no material at its lowest height",
            ),
            (
                refusal(1, &[0], &[ABSENT]),
                "has no material at its lowest height",
            ),
            (no_view, "has no yaw"),
        ] {
            assert!(refused.to_string().contains(expected), "{refused}");
        }
    }
}
