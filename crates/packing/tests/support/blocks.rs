//! A small container, and blocks for it, where a test is about the order in which things are asked.

use std::iter::repeat_n;
use std::sync::Arc;

use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::step::Candidate;

/// The block may be at so many places along each side of the container of [`grid`].
pub(crate) const SIDE: usize = 13;

/// Its placements there.
pub(crate) const PLACES: usize = SIDE * SIDE;

/// 16 x 16 cells, 50 units high, one yaw.
pub(crate) fn grid() -> Grid {
    let resolution = Resolution::new(0.01, 0.002, Yaws::half_turn(1).unwrap());
    let container = ContainerSize {
        x_m: 0.16,
        y_m: 0.16,
        z_m: 0.1,
    };
    Grid::new(container, resolution.unwrap()).unwrap()
}

pub(crate) fn empty(grid: &Grid) -> Scene {
    Scene::from_heightmap(Heightmap::empty(grid))
}

/// Blocks of 4 x 4 cells, alike but for their arrival.
pub(crate) fn blocks(count: usize) -> Vec<Candidate> {
    let view = ViewSurfaces::of_cells(4, 4, vec![10; 16], vec![0; 16]);
    let block = Arc::new(Item::new("block", vec![view], 0.0).unwrap());
    Candidate::sequence(repeat_n(block, count))
}
