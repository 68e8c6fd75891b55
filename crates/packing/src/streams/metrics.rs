//! Figures of an episode.

use serde::{Deserialize, Serialize};

use crate::kernel::grid::{Grid, Units};
use crate::kernel::heightmap::Heightmap;

/// The volume of the items that ended inside the container.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PackedVolume {
    /// How many items.
    pub items: usize,
    /// Their voxels, in cubic metres: what the paper reports. Coarser grids inflate it more.
    pub voxels_m3: f64,
    /// The volume of their meshes, in cubic metres: what compares across grids.
    pub meshes_m3: f64,
}

/// Compactness and utilisation of a container.
///
/// The paper gives compactness in two ways. Its text divides the items' volume by that of their
/// minimum bounding box; its published code by floor times greatest height, of the scan before the
/// last placement. Both are the same once the content touches all walls.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Metrics {
    /// Items inside.
    pub packed: PackedVolume,
    /// Voxel volume over floor times greatest height, 0 to 1: after the paper's published code.
    pub floor_compactness: f64,
    /// Voxel volume over the minimum bounding box along the walls, 0 to 1: after the paper's text.
    pub box_compactness: f64,
    /// Mesh volume over the container's floor times the greatest height of the content, 0 to 1.
    pub mesh_floor_compactness: f64,
    /// Mesh volume over that of the whole container, 0 to 1.
    pub utilisation: f64,
}

impl Metrics {
    /// Gives `V / (X Y h)`, `V / (x y h)` and `V / (X Y Z)`: `V` the packed volume, `X Y Z` the
    /// container, `h` the greatest height, `x y` the rectangle around the content. Where walls lean
    /// or corners are round, `X Y h` and `X Y Z` are the volumes between them.
    pub fn new(grid: &Grid, heightmap: &Heightmap, packed: PackedVolume) -> Self {
        let container = grid.container();
        let content = Content {
            heightmap,
            empty: &Heightmap::empty(grid),
        };
        let height_m = f64::from(content.highest()) * grid.resolution().height_unit_m();
        let below_m3 = container.volume_below_m3(height_m);
        let share = |volume_m3: f64, of_m3: f64| if of_m3 > 0.0 { volume_m3 / of_m3 } else { 0.0 };
        Self {
            packed,
            floor_compactness: share(packed.voxels_m3, below_m3),
            box_compactness: share(packed.voxels_m3, content.covered_m2(grid) * height_m),
            mesh_floor_compactness: share(packed.meshes_m3, below_m3),
            utilisation: share(packed.meshes_m3, container.volume_m3()),
        }
    }
}

/// What stands above the inside surface of a container.
struct Content<'a> {
    heightmap: &'a Heightmap,
    empty: &'a Heightmap,
}

impl Content<'_> {
    /// The greatest height, in units; 0 where there is none.
    fn highest(&self) -> Units {
        let both = self.heightmap.heights().iter().zip(self.empty.heights());
        let content = both.filter_map(|(height, lowest)| (height > lowest).then_some(*height));
        content.max().unwrap_or(0)
    }

    /// The area of the smallest rectangle along the walls with all covered cells, in square metres.
    fn covered_m2(&self, grid: &Grid) -> f64 {
        let is_covered = |x: usize, y: usize| self.heightmap.get(x, y) > self.empty.get(x, y);
        let (nx, ny) = (self.heightmap.nx(), self.heightmap.ny());
        let rows = extent(nx, |x| (0..ny).any(|y| is_covered(x, y)));
        let columns = extent(ny, |y| (0..nx).any(|x| is_covered(x, y)));
        let cell_m = grid.resolution().cell_m();
        (rows * columns) as f64 * cell_m * cell_m
    }
}

/// How many of the first `count` numbers there are from the first that is covered to the last.
fn extent(count: usize, is_covered: impl Fn(usize) -> bool) -> usize {
    let first = (0..count).find(|at| is_covered(*at));
    let last = (0..count).rfind(|at| is_covered(*at));
    first.zip(last).map_or(0, |(first, last)| last + 1 - first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_in_the_middle_fills_its_box_and_a_part_of_what_is_above_the_floor() {
        let grid = Grid::reference();
        let mut heightmap = Heightmap::empty(&grid);
        for (x, y) in (10..14).flat_map(|x| (5..13).map(move |y| (x, y))) {
            heightmap.raise(x, y, 25);
        }
        let packed = PackedVolume {
            items: 1,
            voxels_m3: 0.04 * 0.08 * 0.05,
            meshes_m3: 0.02 * 0.08 * 0.05,
        };
        let metrics = Metrics::new(&grid, &heightmap, packed);
        let floor = 0.04 * 0.08 / (0.32 * 0.32);
        for (found, expected) in [
            (metrics.box_compactness, 1.0),
            (metrics.floor_compactness, floor),
            (metrics.mesh_floor_compactness, floor / 2.0),
            (metrics.utilisation, floor / 2.0 * 0.05 / 0.3),
        ] {
            assert!((found - expected).abs() < 1e-12, "{metrics:?}");
        }
        // A low piece at each of two opposite corners.
        heightmap.raise(0, 0, 1);
        heightmap.raise(31, 31, 1);
        let metrics = Metrics::new(&grid, &heightmap, packed);
        assert!((metrics.box_compactness - metrics.floor_compactness).abs() < 1e-12);
    }

    #[test]
    fn an_empty_container_is_not_compact() {
        let grid = Grid::reference();
        let empty = Heightmap::empty(&grid);
        let metrics = Metrics::new(&grid, &empty, PackedVolume::default());
        assert_eq!(metrics, Metrics::default());
    }
}
