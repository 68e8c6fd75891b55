//! Boxes for what a scene shows beside the solids that are known to lie there.

use nalgebra::{Isometry3, Point3};
use ppnpack_catalogue::mesh::{Bounds, Mesh};
use ppnpack_catalogue::raster::raise_surface;
use ppnpack_packing::kernel::grid::{Grid, Units};
use ppnpack_packing::kernel::heightmap::{HeightmapError, Surface};
use ppnpack_packing::scene::Scene;

/// Maximum height of a scene above a known solid, or above the floor, that is put down to error, in
/// metres: neither is known exactly.
const MARGIN_M: f64 = 0.004;

/// Gives the boxes that fill a scene up to what was seen, above known solids and beside them, in
/// the container frame. A cell as high as the rim is left out: it is blocked. What is only bounded
/// holds nothing up.
///
/// # Errors
/// [`HeightmapError`] where the scene is not of the grid.
pub(crate) fn unexplained<'a>(
    grid: &Grid,
    scene: &Scene,
    solids: impl Iterator<Item = (&'a Mesh, &'a Isometry3<f64>)>,
) -> Result<Vec<Bounds>, HeightmapError> {
    let mut known = Surface::empty(grid);
    for (mesh, container_from_item) in solids {
        raise_surface(mesh, container_from_item, &mut known);
    }
    let fine = scene.surface().map(Surface::supporting);
    let fine = fine.map(|seen| Scene::from_surface(grid, seen));
    let terrain = Terrain {
        grid,
        scene,
        fine: fine.transpose()?,
        known: Scene::from_surface(grid, known)?,
        margin: grid.resolution().units_above(MARGIN_M),
    };
    Ok((0..grid.nx()).flat_map(|x| terrain.row(x)).collect())
}

struct Terrain<'a> {
    grid: &'a Grid,
    scene: &'a Scene,
    /// Its fine surface, where there is one: nothing is blocked there.
    fine: Option<Scene>,
    /// The known solids alone.
    known: Scene,
    /// In units.
    margin: Units,
}

/// The part of a cell's column that known solids do not explain, in units.
#[derive(Clone, Copy)]
struct Gap {
    y: usize,
    bottom: Units,
    top: Units,
}

impl Terrain<'_> {
    /// Gives the boxes of the cells with this place along x.
    fn row(&self, x: usize) -> Vec<Bounds> {
        let gaps: Vec<Gap> = (0..self.grid.ny()).filter_map(|y| self.gap(x, y)).collect();
        let is_run = |one: &Gap, next: &Gap| {
            one.y + 1 == next.y && (one.bottom, one.top) == (next.bottom, next.top)
        };
        let resolution = self.grid.resolution();
        let corner = |x: usize, y: usize, height: Units| {
            let [x_m, y_m] = [x, y].map(|at| at as f64 * resolution.cell_m());
            Point3::new(x_m, y_m, f64::from(height) * resolution.height_unit_m())
        };
        let runs = gaps.chunk_by(is_run).filter_map(|run| {
            let (first, last) = (run.first()?, run.last()?);
            Some(Bounds {
                lowest: corner(x, first.y, first.bottom),
                highest: corner(x + 1, last.y + 1, last.top),
            })
        });
        runs.collect()
    }

    fn gap(&self, x: usize, y: usize) -> Option<Gap> {
        let top = self.seen(x, y);
        let known = self.known_around(x, y);
        let bottom = if known > 0 { known + self.margin } else { 0 };
        let is_more = top > bottom.saturating_add(self.margin) && top < self.grid.rim();
        is_more.then_some(Gap { y, bottom, top })
    }

    /// Gives the height of the scene there.
    fn seen(&self, x: usize, y: usize) -> Units {
        let height = |scene: &Scene| scene.heightmap().get(x, y).unwrap_or(0);
        let (coarse, fine) = (height(self.scene), self.fine.as_ref());
        fine.map_or(coarse, |fine| height(fine).min(coarse))
    }

    /// Gives the height of the known solids there or in a cell beside, as they may be a cell off.
    fn known_around(&self, x: usize, y: usize) -> Units {
        let near = |at: usize| at.saturating_sub(1)..=at + 1;
        let cells = near(x).flat_map(|x| near(y).map(move |y| (x, y)));
        let heights = cells.filter_map(|(x, y)| self.known.heightmap().get(x, y));
        heights.max().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use ppnpack_packing::kernel::grid::{ContainerSize, Resolution};
    use ppnpack_packing::kernel::heightmap::Heightmap;

    use super::*;

    /// A scene of 5 cm on ten cells a side.
    fn scene(grid: &Grid) -> Scene {
        let mut heightmap = Heightmap::empty(grid);
        for x in 0..10 {
            for y in 0..10 {
                heightmap.raise(x, y, 25);
            }
        }
        Scene::from_heightmap(heightmap)
    }

    fn is_in(boxes: &[Bounds], at: Point3<f64>) -> bool {
        let inside = |bounds: &Bounds| {
            (0..3).all(|axis| bounds.lowest[axis] <= at[axis] && at[axis] <= bounds.highest[axis])
        };
        boxes.iter().any(inside)
    }

    #[test]
    fn what_nothing_explains_is_full() {
        let grid = Grid::reference();
        let boxes = unexplained(&grid, &scene(&grid), std::iter::empty()).unwrap();
        assert_eq!(boxes.len(), 10);
        assert!(is_in(&boxes, Point3::new(0.05, 0.05, 0.025)));
        assert!(is_in(&boxes, Point3::new(0.099, 0.001, 0.049)));
        assert!(!is_in(&boxes, Point3::new(0.05, 0.05, 0.051)));
        assert!(!is_in(&boxes, Point3::new(0.101, 0.05, 0.025)));
    }

    #[test]
    fn known_solids_are_left_out_with_what_is_beside_them() {
        let grid = Grid::reference();
        let solid = Mesh::cuboid([0.0; 3], [0.1, 0.05, 0.05]);
        let of = |solid: &Mesh, z_m: f64| {
            let pose = Isometry3::translation(0.0, 0.0, z_m);
            unexplained(&grid, &scene(&grid), [(solid, &pose)].into_iter()).unwrap()
        };
        let boxes = of(&solid, 0.0);
        assert!(!is_in(&boxes, Point3::new(0.05, 0.03, 0.025)));
        assert!(!is_in(&boxes, Point3::new(0.05, 0.055, 0.025)));
        assert!(is_in(&boxes, Point3::new(0.05, 0.065, 0.025)));
        // Something lies on it.
        let boxes = of(&solid, -0.03);
        assert!(!is_in(&boxes, Point3::new(0.05, 0.03, 0.01)));
        assert!(is_in(&boxes, Point3::new(0.05, 0.03, 0.04)));
        // All is explained.
        let solid = Mesh::cuboid([0.0; 3], [0.1, 0.1, 0.05]);
        assert!(of(&solid, 0.0).is_empty());
    }

    #[test]
    fn leaning_walls_are_explained_and_what_lies_between_them_is_not() {
        let size = ContainerSize {
            draft_rad: 3.0_f64.to_radians(),
            corner_radius_m: 0.03,
            ..ContainerSize::REFERENCE
        };
        let grid = Grid::new(size, Resolution::reference()).unwrap();
        let empty = Scene::from_surface(&grid, Surface::empty(&grid)).unwrap();
        assert_eq!(
            unexplained(&grid, &empty, std::iter::empty()),
            Ok(Vec::new())
        );
        let boxes = unexplained(&grid, &scene(&grid), std::iter::empty()).unwrap();
        assert!(is_in(&boxes, Point3::new(0.05, 0.05, 0.025)));
        assert!(!is_in(&boxes, Point3::new(0.005, 0.05, 0.1)));
    }

    #[test]
    fn what_is_only_bounded_holds_nothing_up() {
        let grid = Grid::reference();
        let mut surface = Surface::empty(&grid);
        (0..40).for_each(|x| (0..40).for_each(|y| surface.raise(x, y, 0.05)));
        let held = surface.heights_m().iter().enumerate();
        let ny = surface.ny();
        let held = held.map(|(sample, height_m)| if sample / ny < 20 { *height_m } else { 0.0 });
        let held = held.collect();
        let scene = Scene::from_surface(&grid, surface.with_support(held).unwrap()).unwrap();
        let boxes = unexplained(&grid, &scene, std::iter::empty()).unwrap();
        assert!(is_in(&boxes, Point3::new(0.04, 0.05, 0.04)));
        assert!(!is_in(&boxes, Point3::new(0.06, 0.05, 0.04)));
    }

    #[test]
    fn what_is_blocked_or_was_not_seen_is_left_out() {
        let grid = Grid::reference();
        let mut heightmap = Heightmap::empty(&grid);
        heightmap.raise(3, 3, grid.rim());
        heightmap.raise(5, 5, grid.rim() + 1);
        heightmap.raise(7, 7, 2);
        let scene = Scene::from_heightmap(heightmap);
        let boxes = unexplained(&grid, &scene, std::iter::empty()).unwrap();
        assert!(boxes.is_empty());
    }
}
