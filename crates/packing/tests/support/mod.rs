//! Random grids, containers and items for the tests.
#![allow(dead_code, reason = "each test file uses some of these")]

pub(crate) mod blocks;
pub(crate) mod ideal;
pub(crate) mod oracle;

use std::sync::Arc;

use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Units, Yaws};
use ppnpack_packing::heightmap::{Heightmap, Scene, Surface};
use ppnpack_packing::item::{ABSENT, Item, Underside, ViewSurfaces};
use ppnpack_packing::objective::Weights;
use ppnpack_packing::placement::Placement;
use ppnpack_packing::proposals::{Proposals, Proposer};
use ppnpack_packing::step::{StageResult, StepInput};
use proptest::prelude::*;

/// A grid of up to 14 x 14 cells with odd cell sizes and height units among them.
pub(crate) fn grids() -> impl Strategy<Value = Grid> {
    let cells = prop_oneof![Just(0.01), Just(0.005), Just(0.02), 0.004..0.03];
    let units = prop_oneof![Just(0.002), Just(0.001), Just(0.005), 0.0008..0.01];
    (
        1_usize..14,
        1_usize..14,
        5_i16..60,
        cells,
        units,
        1_usize..4,
    )
        .prop_map(|(nx, ny, rim, cell_m, unit_m, yaws)| {
            let resolution = Resolution::new(cell_m, unit_m, Yaws::half_turn(yaws).unwrap());
            let container = ContainerSize {
                x_m: nx as f64 * cell_m,
                y_m: ny as f64 * cell_m,
                z_m: f64::from(rim) * unit_m,
            };
            Grid::new(container, resolution.unwrap()).unwrap()
        })
}

/// A container whose content is steps, so that flat parts and cliffs both occur.
pub(crate) fn heightmaps(grid: &Grid) -> impl Strategy<Value = Heightmap> + use<> {
    let (nx, ny, rim) = (grid.nx(), grid.ny(), grid.rim());
    let steps = proptest::collection::vec((0..nx, 0..ny, 1..=nx, 1..=ny, 0..=rim), 0..6);
    let empty = Heightmap::empty(grid);
    steps.prop_map(move |steps| {
        let mut heightmap = empty.clone();
        for (x0, y0, width, depth, height) in steps {
            for x in x0..(x0 + width).min(nx) {
                for y in y0..(y0 + depth).min(ny) {
                    heightmap.raise(x, y, height);
                }
            }
        }
        heightmap
    })
}

/// A view with holes and an uneven underside.
pub(crate) fn views() -> impl Strategy<Value = ViewSurfaces> {
    (1_usize..7, 1_usize..7).prop_flat_map(|(nx, ny)| {
        let cell = (0_i16..6, 1_i16..20, 0_u8..5);
        proptest::collection::vec(cell, nx * ny).prop_map(move |cells| surfaces(nx, ny, &cells))
    })
}

fn surfaces(nx: usize, ny: usize, cells: &[(i16, i16, u8)]) -> ViewSurfaces {
    let is_absent = |index: usize| cells[index].2 == 0 && index != 0;
    let lowest = (0..cells.len())
        .filter(|index| !is_absent(*index))
        .map(|index| cells[index].0)
        .min()
        .unwrap();
    let mut bottom: Vec<Units> = Vec::new();
    let mut top: Vec<Units> = Vec::new();
    for (index, (low, thickness, _)) in cells.iter().enumerate() {
        let low = low - lowest;
        bottom.push(if is_absent(index) { ABSENT } else { low });
        top.push(if is_absent(index) { 0 } else { low + thickness });
    }
    ViewSurfaces::of_cells(nx, ny, top, bottom)
}

/// An item with this many yaws.
pub(crate) fn items(yaws: usize) -> impl Strategy<Value = Arc<Item>> {
    proptest::collection::vec(views(), yaws)
        .prop_map(|views| Arc::new(Item::new("random", views, 0.0).unwrap()))
}

/// The published weights, the dense ones, and some under which the height of the item's top counts more or less.
pub(crate) fn weights() -> impl Strategy<Value = Weights> {
    let topped = |(top_height, distance): (f64, f64)| Weights {
        top_height,
        distance,
        ..Weights::default()
    };
    prop_oneof![
        Just(Weights::default()),
        Just(Weights::dense()),
        (0.0_f64..3.0, 0.0_f64..6.0).prop_map(topped),
    ]
}

/// A grid, its content, and some items for it.
pub(crate) fn scenes(
    items_up_to: usize,
) -> impl Strategy<Value = (Grid, Heightmap, Vec<Arc<Item>>)> {
    grids().prop_flat_map(move |grid| {
        let yaws = grid.resolution().yaws().count();
        let held = proptest::collection::vec(items(yaws), 1..=items_up_to);
        (Just(grid.clone()), heightmaps(&grid), held)
    })
}

/// The same content and item with fine surfaces that lie up to 5 mm below and above those of the cells.
pub(crate) fn finely_sampled(
    grid: &Grid,
    heightmap: &Heightmap,
    item: &Item,
    seed: u16,
) -> (Scene, Arc<Item>) {
    let samples = grid.resolution().samples_per_cell();
    let unit_m = grid.resolution().height_unit_m() as f32;
    let mut drawn = u32::from(seed);
    let mut offset_m = || {
        drawn = drawn.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (drawn >> 16) as f32 % 6.0 * 0.001
    };
    let mut content = Surface::empty(grid);
    for x in 0..content.nx() {
        for y in 0..content.ny() {
            let height = heightmap.get(x / samples, y / samples).unwrap();
            content.raise(x, y, f32::from(height) * unit_m - offset_m());
        }
    }
    let views = item.views().iter().map(|view| {
        let (nx, ny) = (view.nx() * samples, view.ny() * samples);
        let heights_m = (0..nx * ny).map(|index| {
            let (x, y) = (index / ny / samples, index % ny / samples);
            match view.bottom()[x * view.ny() + y] {
                ABSENT => f32::INFINITY,
                bottom => f32::from(bottom) * unit_m + offset_m(),
            }
        });
        let underside = Underside {
            nx,
            ny,
            samples_per_cell: samples,
            heights_m: heights_m.collect(),
        };
        ViewSurfaces {
            underside: Some(underside),
            ..ViewSurfaces::of_cells(
                view.nx(),
                view.ny(),
                view.top().to_vec(),
                view.bottom().to_vec(),
            )
        }
    });
    let item = Item::new("fine", views.collect(), 0.0).unwrap();
    let scene = Scene::new(grid, heightmap.clone(), Some(content)).unwrap();
    (scene, Arc::new(item))
}

/// The placements of an item that lie within the container, by yaw, x, y.
pub(crate) fn possible_placements(grid: &Grid, item: &Item) -> impl Iterator<Item = Placement> {
    let views = item.views().iter().enumerate();
    views.flat_map(|(yaw, view)| {
        let nx = (grid.nx() + 1).saturating_sub(view.nx());
        let ny = (grid.ny() + 1).saturating_sub(view.ny());
        (0..nx).flat_map(move |x| (0..ny).map(move |y| Placement { yaw, x, y }))
    })
}

/// Proposes for each candidate the corner of the container alone.
pub(crate) struct ProposeCorner;

impl Proposer for ProposeCorner {
    fn propose(&mut self, input: &StepInput<'_>, proposals: &mut Proposals) -> StageResult {
        proposals.clear();
        for _ in input.candidates {
            proposals.push([Placement { yaw: 0, x: 0, y: 0 }]);
        }
        Ok(())
    }
}
