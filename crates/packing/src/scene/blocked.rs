//! Parts of the container that must stay free of items.

use crate::kernel::grid::Grid;
use crate::kernel::heightmap::Heightmap;
use crate::scene::Scene;

/// A rectangle of the floor, in metres in the container frame, above which nothing may be placed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlockedRegion {
    /// The side with the least x.
    pub x_min_m: f64,
    /// The side with the least y.
    pub y_min_m: f64,
    /// The side with the greatest x.
    pub x_max_m: f64,
    /// The side with the greatest y.
    pub y_max_m: f64,
}

impl BlockedRegion {
    pub(crate) fn cells_of(&self, grid: &Grid) -> impl Iterator<Item = (usize, usize)> {
        let cell_m = grid.resolution().cell_m();
        let along_x = Self::cells(self.x_min_m, self.x_max_m, cell_m, grid.nx());
        let along_y = Self::cells(self.y_min_m, self.y_max_m, cell_m, grid.ny());
        along_x.flat_map(move |x| along_y.clone().map(move |y| (x, y)))
    }

    fn cells(min_m: f64, max_m: f64, cell_m: f64, count: usize) -> std::ops::Range<usize> {
        // Conversions saturate, so a region beyond the container is cut to it.
        let first = (min_m / cell_m).floor().max(0.0) as usize;
        let end = (max_m / cell_m).ceil().max(0.0) as usize;
        first..end.min(count)
    }
}

/// Raises these regions to the rim: an item with material above any cell of them would stick out.
///
/// The search then leaves such placements out unvalued, and the network sees walls.
#[must_use]
pub fn block(scene: &Scene, grid: &Grid, regions: &[BlockedRegion]) -> Scene {
    let mut heightmap: Heightmap = scene.heightmap().clone();
    for region in regions {
        for (x, y) in region.cells_of(grid) {
            heightmap.raise(x, y, grid.rim());
        }
    }
    scene.clone().with_heightmap(heightmap)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_that_a_region_meets_is_as_high_as_the_rim() {
        let grid = Grid::reference();
        let scene = Scene::from_heightmap(Heightmap::empty(&grid));
        let high = |(x_min_m, x_max_m), (y_min_m, y_max_m)| {
            let region = BlockedRegion {
                x_min_m,
                y_min_m,
                x_max_m,
                y_max_m,
            };
            let blocked = block(&scene, &grid, &[region]);
            let cells = (0..32).flat_map(|x| (0..32).map(move |y| (x, y)));
            let is_high = |(x, y): &_| blocked.heightmap().get(*x, *y) == Some(grid.rim());
            cells.filter(is_high).collect::<Vec<(usize, usize)>>()
        };
        assert_eq!(high((0.015, 0.03), (-1.0, 0.001)), [(1, 0), (2, 0)]);
        let everywhere = (f64::NEG_INFINITY, f64::INFINITY);
        assert_eq!(high(everywhere, everywhere).len(), 32 * 32);
    }
}
