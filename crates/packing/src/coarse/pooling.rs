//! Heightmaps and items on a coarser grid.

use super::CoarseGrid;
use crate::grid::Units;
use crate::heightmap::Heightmap;
use crate::item::{ABSENT, Item, ItemError, ItemView, ViewSurfaces};

impl CoarseGrid {
    /// The greatest height of each coarse cell; cells beyond the last whole one count to it.
    pub fn pool(&self, heightmap: &Heightmap) -> Heightmap {
        let coarse = self.coarse();
        let (last_x, last_y) = (coarse.nx() - 1, coarse.ny() - 1);
        let mut pooled = Heightmap::empty(coarse);
        for x in 0..heightmap.nx() {
            let row = heightmap.row(x);
            let across = (x / self.cells()).min(last_x);
            for (y, heights) in row.chunks(self.cells()).enumerate() {
                let highest = heights.iter().copied().fold(0, Units::max);
                pooled.raise(across, y.min(last_y), highest);
            }
        }
        pooled
    }

    /// An item's views at the coarse yaws: per coarse cell of the footprint the highest upper and the lowest lower
    /// surface, counted from the footprint's corner.
    ///
    /// # Errors
    /// [`ItemError`] where the item has no view at a yaw of the coarse grid.
    pub fn item(&self, item: &Item) -> Result<Item, ItemError> {
        let views = item.views().iter().step_by(self.yaw_step());
        let views = views.map(|view| pool_view(view, self.cells())).collect();
        Item::new(item.name(), views, item.mesh_volume_m3())
    }
}

fn pool_view(view: &ItemView, cells: usize) -> ViewSurfaces {
    let (nx, ny) = (view.nx().div_ceil(cells), view.ny().div_ceil(cells));
    let mut top = vec![0; nx * ny];
    let mut bottom = vec![ABSENT; nx * ny];
    let surfaces = view.top().iter().zip(view.bottom());
    for (index, (upper, lower)) in surfaces.enumerate() {
        let (x, y) = (index / view.ny() / cells, index % view.ny() / cells);
        let cell = x * ny + y;
        let (Some(top), Some(bottom)) = (top.get_mut(cell), bottom.get_mut(cell)) else {
            continue;
        };
        if *lower != ABSENT {
            *top = Units::max(*top, *upper);
            *bottom = if *bottom == ABSENT {
                *lower
            } else {
                Units::min(*bottom, *lower)
            };
        }
    }
    ViewSurfaces {
        nx,
        ny,
        top,
        bottom,
        underside: None,
        origin_from_corner_m: view.origin_from_corner_m(),
        centre_of_mass_m: None,
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::coarse::Coarsening;
    use crate::grid::Grid;

    #[test]
    fn blocks_keep_their_highest_and_lowest_surfaces() {
        let grid = Grid::reference();
        let grids = CoarseGrid::new(&grid, Coarsening { cells: 3, yaws: 1 }).unwrap();
        let mut heightmap = Heightmap::empty(&grid);
        heightmap.raise(4, 5, 7);
        heightmap.raise(5, 3, 9);
        heightmap.raise(31, 31, 4);
        let pooled = grids.pool(&heightmap);
        assert_eq!((pooled.nx(), pooled.ny()), (10, 10));
        assert_eq!((pooled.get(1, 1), pooled.get(9, 9)), (Some(9), Some(4)));
        let total: i32 = pooled
            .heights()
            .iter()
            .map(|height| i32::from(*height))
            .sum();
        assert_eq!(total, 13);

        let view = ViewSurfaces {
            nx: 1,
            ny: 7,
            top: vec![5, 6, 0, 0, 0, 0, 9],
            bottom: vec![2, 1, ABSENT, ABSENT, ABSENT, ABSENT, 0],
            underside: None,
            origin_from_corner_m: Vector3::zeros(),
            centre_of_mass_m: None,
        };
        let item = Item::new("bridge", vec![view; 4], 0.0).unwrap();
        let pooled = grids.item(&item).unwrap();
        let view = &pooled.views()[0];
        assert_eq!((view.nx(), view.ny()), (1, 3));
        assert_eq!(view.bottom(), [1, ABSENT, 0]);
        assert_eq!((view.top()[0], view.top()[2]), (6, 9));
    }
}
