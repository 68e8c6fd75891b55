//! Heightmaps and items on a coarser grid, as they are on average: the fine grid decides what is
//! safe, and by greatest heights all would grow by up to a cell, which closes narrow gaps.

use std::ops::Range;

use super::{CoarseGrid, Coarsening};
use crate::kernel::grid::{ABSENT, Units};
use crate::kernel::heightmap::Heightmap;
use crate::kernel::item::{Item, ItemError, ItemView, ViewSurfaces};

impl CoarseGrid {
    /// The median height of each coarse cell, the lower of two; the last takes what is left over.
    pub fn pool(&self, heightmap: &Heightmap) -> Heightmap {
        let (nx, ny) = (self.coarse().nx(), self.coarse().ny());
        let mut pooled = Heightmap::flat(self.coarse());
        let mut heights = Vec::new();
        for x in 0..nx {
            for y in 0..ny {
                heights.clear();
                for row in self.fine_cells(x, nx, heightmap.nx()) {
                    let columns = self.fine_cells(y, ny, heightmap.ny());
                    heights.extend_from_slice(heightmap.row(row).get(columns).unwrap_or(&[]));
                }
                if let Some(middle) = heights.len().checked_sub(1) {
                    let (_, median, _) = heights.select_nth_unstable(middle / 2);
                    pooled.raise(x, y, *median);
                }
            }
        }
        pooled
    }

    fn fine_cells(&self, cell: usize, coarse: usize, fine: usize) -> Range<usize> {
        let first = cell * self.coarsening.cells;
        let end = first + self.coarsening.cells;
        first..if cell + 1 == coarse { fine } else { end }
    }

    /// An item's views at the coarse yaws: per coarse cell the highest upper and the lowest lower
    /// surface. Cells of which the item covers less than half are left out, unless all are such.
    ///
    /// # Errors
    /// [`ItemError`] where the item has no view at a yaw of the coarse grid.
    pub fn item(&self, item: &Item) -> Result<Item, ItemError> {
        let Coarsening { cells, yaws } = self.coarsening;
        let views = item.views().iter().step_by(yaws);
        let views = views.map(|view| pool_view(view, cells)).collect();
        Item::new(item.name(), views, item.mesh_volume_m3())
    }
}

#[derive(Debug, Clone, Copy)]
struct Column {
    top: Units,
    bottom: Units,
    covered: usize,
}

fn pool_view(view: &ItemView, cells: usize) -> ViewSurfaces {
    let (nx, ny) = (view.nx().div_ceil(cells), view.ny().div_ceil(cells));
    let nothing = Column {
        top: 0,
        bottom: Units::MAX,
        covered: 0,
    };
    let mut columns = vec![nothing; nx * ny];
    for (x, y, lower, upper) in view.cells() {
        if let Some(column) = columns.get_mut(x / cells * ny + y / cells) {
            column.top = column.top.max(upper);
            column.bottom = column.bottom.min(lower);
            column.covered += 1;
        }
    }
    let is_half = |column: &Column| 2 * column.covered >= cells * cells;
    let least = if columns.iter().any(is_half) {
        (cells * cells).div_ceil(2)
    } else {
        1
    };
    let kept = |column: &&Column| column.covered >= least;
    // Heights count from the lowest point that is left.
    let bottoms = columns.iter().filter(kept).map(|column| column.bottom);
    let lowest = bottoms.min().unwrap_or(0);
    let surfaces = columns.iter().map(|column| match kept(&column) {
        true => (column.top - lowest, column.bottom - lowest),
        false => (0, ABSENT),
    });
    let (top, bottom) = surfaces.unzip();
    ViewSurfaces {
        origin_from_corner_m: view.origin_from_corner_m(),
        ..ViewSurfaces::of_cells(nx, ny, top, bottom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::grid::Grid;

    fn grids(cells: usize) -> CoarseGrid {
        CoarseGrid::new(&Grid::reference(), Coarsening { cells, yaws: 1 }).unwrap()
    }

    #[test]
    fn a_coarse_cell_has_the_median_height_of_its_cells() {
        // 32 cells make 10 coarse ones of 3, of which the last has 5.
        let mut heightmap = Heightmap::empty(&Grid::reference());
        for (x, row) in [(3, 3..6), (4, 3..5), (6, 6..8), (7, 6..8)] {
            row.for_each(|y| heightmap.raise(x, y, 9));
        }
        heightmap.raise(4, 5, 7);
        let last = (27..32).flat_map(|x| (27..32).map(move |y| (x, y)));
        last.take(13).for_each(|(x, y)| heightmap.raise(x, y, 4));
        let pooled = grids(3).pool(&heightmap);
        assert_eq!((pooled.nx(), pooled.ny()), (10, 10));
        let found = [(1, 1), (2, 2), (9, 9)].map(|(x, y)| pooled.get(x, y));
        assert_eq!(found, [Some(9), Some(0), Some(4)]);
        // Of four heights the second.
        let pooled = grids(2).pool(&heightmap);
        let found = [(3, 3), (1, 2), (2, 1), (2, 2)].map(|(x, y)| pooled.get(x, y));
        assert_eq!(found, [Some(9), Some(0), Some(0), Some(0)]);
    }

    #[test]
    fn an_item_has_the_cells_of_which_it_covers_half_from_the_lowest_point_that_is_left() {
        const NO: Units = ABSENT;
        let pooled = |cells, ny: usize, top: &[Units], bottom: &[Units]| {
            let view = ViewSurfaces::of_cells(top.len() / ny, ny, top.to_vec(), bottom.to_vec());
            let item = Item::new("item", vec![view; 4], 0.0).unwrap();
            let pooled = grids(cells).item(&item).unwrap();
            let view = &pooled.views()[0];
            (view.ny(), view.top().to_vec(), view.bottom().to_vec())
        };
        // A bridge of two rows of five cells: coarse cells of 2 x 2 at y = 0, 1 and 2, the last
        // beyond the footprint by half.
        let bottom = [2, 1, NO, NO, NO, NO, 0, 0, 5, NO];
        let bridge = pooled(2, 5, &[5, 6, 0, 0, 0, 0, 9, 8, 7, 0], &bottom);
        assert_eq!(bridge, (3, vec![9, 8, 0], vec![0, 0, NO]));
        // A foot that covers a quarter of a cell.
        let foot = pooled(4, 4, &[9; 8], &[4, 4, 4, 4, 4, 4, 0, 0]);
        assert_eq!(foot, (1, vec![9], vec![0]));
        let needle = pooled(3, 3, &[3; 3], &[0, NO, 1]);
        assert_eq!(needle, (1, vec![3], vec![0]));
        let lamp = pooled(2, 3, &[9; 6], &[3, 3, 0, 3, 3, NO]);
        assert_eq!(lamp, (2, vec![6, 0], vec![0, NO]));
    }
}
