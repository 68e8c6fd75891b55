//! The grids that benchmarks measure on, and the objects prepared for them.

use ppnpack_catalogue::catalogue::{Catalogue, Settings};
use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Yaws};

/// A grid of the reference container: cell in metres, yaws and a name.
pub(crate) type NamedGrid = (f64, usize, &'static str);

/// The paper's grid and two finer ones.
pub(crate) const GRIDS: [NamedGrid; 3] = [
    (0.01, 4, "1 cm, 4 yaws"),
    (0.005, 8, "5 mm, 8 yaws"),
    (0.0025, 16, "2.5 mm, 16 yaws"),
];

pub(crate) fn grid((cell_m, yaws, _): NamedGrid) -> Grid {
    let resolution = Resolution::new(cell_m, 0.002, Yaws::half_turn(yaws).unwrap()).unwrap();
    Grid::new(ContainerSize::REFERENCE, resolution).unwrap()
}

/// The objects, as they are packed on a grid: the built-in ones, or those of the folder in
/// `PPNPACK_BENCH_OBJECTS`.
pub(crate) fn catalogue(grid: &Grid) -> Catalogue {
    let named = std::env::var("PPNPACK_BENCH_OBJECTS");
    let name = named.as_deref().unwrap_or(ppnpack_household::BUILTIN);
    let settings = Settings::default();
    let source = ppnpack_household::source(name);
    Catalogue::load(&source, &settings, grid.resolution(), &|_, _| {}).unwrap()
}
