//! Resting heights of all placements of an item, for those who need them as maps.

use crate::grid::{Grid, Units};
use crate::heightmap::Heightmap;
use crate::item::Item;
use crate::proposals::YawRange;
use crate::resting_maps::{RestingMap, RestingMaps};

/// Computes resting heights; keeps those of the last items, and computes again only what a change affects.
#[derive(Debug)]
pub struct RestingHeights {
    maps: RestingMaps,
}

/// The resting heights of one view's placements.
#[derive(Debug, Clone, Copy)]
pub struct ViewRestingHeights<'a>(&'a RestingMap);

impl ViewRestingHeights<'_> {
    /// Placements along x; 0 where the view is larger than the container.
    pub fn nx(&self) -> usize {
        self.0.nx
    }

    /// Placements along y; 0 where the view is larger than the container.
    pub fn ny(&self) -> usize {
        self.0.ny
    }

    /// Per x: the resting heights along y, in units.
    pub fn rows(&self) -> impl Iterator<Item = &[Units]> {
        self.0.rows().map(|row| row.get(..self.0.ny).unwrap_or(&[]))
    }
}

impl RestingHeights {
    /// For containers of this grid.
    pub fn new(grid: &Grid) -> Self {
        Self {
            maps: RestingMaps::new(grid),
        }
    }

    /// Takes over the container's content, of the grid's size, and the items whose maps to keep.
    pub fn update<'a>(&mut self, heightmap: &Heightmap, items: impl Iterator<Item = &'a Item>) {
        self.maps.update(heightmap);
        self.maps.keep(items);
    }

    /// The resting heights of an item, one map per yaw.
    pub fn of(&mut self, item: &Item) -> impl Iterator<Item = ViewRestingHeights<'_>> {
        self.maps.prepare(item, YawRange::all(item), None);
        self.maps.views(item.shape()).iter().map(ViewRestingHeights)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::item::ViewSurfaces;

    #[test]
    fn maps_hold_the_greatest_height_below_the_footprint() {
        let grid = Grid::reference();
        let view = ViewSurfaces {
            nx: 2,
            ny: 1,
            top: vec![5, 5],
            bottom: vec![0, 3],
            underside: None,
            origin_from_corner_m: Vector3::zeros(),
            centre_of_mass_m: None,
        };
        let yaws = grid.resolution().yaws().count();
        let item = Item::new("step", vec![view; yaws], 0.0).unwrap();
        let mut heightmap = Heightmap::empty(&grid);
        heightmap.raise(7, 9, 10);
        let mut resting = RestingHeights::new(&grid);
        resting.update(&heightmap, std::iter::once(&item));
        let maps: Vec<_> = resting.of(&item).collect();
        assert_eq!(maps.len(), yaws);
        assert_eq!((maps[0].nx(), maps[0].ny()), (31, 32));
        let rows: Vec<_> = maps[0].rows().collect();
        assert_eq!((rows[7][9], rows[6][9], rows[8][9]), (10, 7, 0));
    }
}
