//! Shared by the tests: the crate's names, random grids, containers and items, and plain ones.

pub(crate) mod oracle;

pub(crate) use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Point3};
pub(crate) use ppnpack_packing::checks::check::{
    BoxedCheck, Cost, Evidence, ValidityCheck, Verdict,
};
pub(crate) use ppnpack_packing::checks::stability::PublishedStability;
pub(crate) use ppnpack_packing::kernel::grid::{
    ABSENT, ContainerSize, Grid, Resolution, Units, Yaws,
};
pub(crate) use ppnpack_packing::kernel::heightmap::{Heightmap, Surface};
pub(crate) use ppnpack_packing::kernel::item::{Item, Underside, ViewSurfaces};
pub(crate) use ppnpack_packing::kernel::objective::{Heuristic, Order, Weights};
pub(crate) use ppnpack_packing::kernel::placement::{Placement, RestingPlacement};
pub(crate) use ppnpack_packing::planning::plan::{Plan, Planner, Reason};
pub(crate) use ppnpack_packing::ranking::evaluator::Evaluator;
pub(crate) use ppnpack_packing::ranking::proposals::{
    CandidateProposals, Percent, Proposals, ProposeAll, ProposeRandom, Proposer, all_count,
};
pub(crate) use ppnpack_packing::ranking::refusal::{Cause, Refusal};
pub(crate) use ppnpack_packing::ranking::search::{Search, SearchSettings};
pub(crate) use ppnpack_packing::ranking::step::{
    Candidate, Evaluated, PlacementCounts, StageError, StageResult, StepInput,
};
pub(crate) use ppnpack_packing::scene::Scene;
pub(crate) use ppnpack_packing::scene::content::{Content, LyingBody, LyingSolid};
use ppnpack_packing::scene::model::mesh::Mesh;
pub(crate) use ppnpack_packing::scene::model::{MassProperties, Model};
pub(crate) use proptest::prelude::*;

pub(crate) const HEURISTICS: [Heuristic; 6] = [
    Heuristic::Sdfm,
    Heuristic::Dbl,
    Heuristic::Hm,
    Heuristic::Mta,
    Heuristic::FirstFit,
    Heuristic::Random,
];

/// So many cells along x and y of an edge in metres, so many units of 2 mm high, so many yaws.
pub(crate) fn grid_of(cells: [usize; 2], cell_m: f64, rim: Units, yaws: usize) -> Grid {
    let resolution = Resolution::new(cell_m, 0.002, Yaws::half_turn(yaws).unwrap());
    let [x_m, y_m] = cells.map(|count| count as f64 * cell_m);
    let z_m = f64::from(rim) * 0.002;
    Grid::new(ContainerSize::cuboid(x_m, y_m, z_m), resolution.unwrap()).unwrap()
}

pub(crate) fn empty(grid: &Grid) -> Scene {
    Scene::from_heightmap(Heightmap::empty(grid))
}

/// A placement at the first yaw, and its height in units.
pub(crate) fn resting([x, y]: [usize; 2], resting_height: Units) -> RestingPlacement {
    RestingPlacement {
        placement: Placement { yaw: 0, x, y },
        resting_height,
    }
}

/// A block of so many cells and units.
pub(crate) fn block_view([nx, ny]: [usize; 2], height: Units) -> ViewSurfaces {
    ViewSurfaces::of_cells(nx, ny, vec![height; nx * ny], vec![0; nx * ny])
}

/// The same at every yaw of a grid, with its volume.
pub(crate) fn block(grid: &Grid, cells: [usize; 2], height: Units) -> Arc<Item> {
    let resolution = grid.resolution();
    let views = vec![block_view(cells, height); resolution.yaws().count()];
    let floor_m2 = (cells[0] * cells[1]) as f64 * resolution.cell_m().powi(2);
    let volume_m3 = floor_m2 * f64::from(height) * resolution.height_unit_m();
    Arc::new(Item::new("block", views, volume_m3).unwrap())
}

/// Places of the [`blocks`] along each side of the container of [`small_grid`].
pub(crate) const SIDE: usize = 13;

/// Their placements there.
pub(crate) const PLACES: usize = SIDE * SIDE;

/// 16 x 16 cells, 50 units high, one yaw.
pub(crate) fn small_grid() -> Grid {
    grid_of([16, 16], 0.01, 50, 1)
}

/// Blocks of 4 x 4 cells, alike but for their arrival.
pub(crate) fn blocks(count: usize) -> Vec<Candidate> {
    Candidate::sequence(vec![block(&small_grid(), [4, 4], 10); count])
}

pub(crate) fn searching(
    grid: &Grid,
    heuristic: Heuristic,
    order: Order,
    is_bounded: bool,
) -> Search {
    let settings = SearchSettings {
        heuristic,
        order,
        seed: 7,
        ..SearchSettings::default()
    };
    let search = Search::new(grid, &settings).unwrap();
    if is_bounded { search.bounded() } else { search }
}

pub(crate) fn all(input: &StepInput<'_>) -> Proposals {
    let mut proposals = Proposals::default();
    ProposeAll.propose(input, &mut proposals).unwrap();
    proposals
}

/// The rest of a ranking.
pub(crate) fn rest(
    evaluator: &mut dyn Evaluator,
    input: &StepInput<'_>,
) -> impl Iterator<Item = Evaluated> {
    std::iter::from_fn(|| evaluator.next_best(input).unwrap())
}

/// The ranking of all candidates.
pub(crate) fn ranking(
    evaluator: &mut dyn Evaluator,
    input: &StepInput<'_>,
    proposals: &Proposals,
) -> Vec<Evaluated> {
    let group: Vec<usize> = (0..input.candidates.len()).collect();
    evaluator.rank(input, &group, proposals).unwrap();
    rest(evaluator, input).collect()
}

/// A planner over all placements by the bounded search, with these checks.
pub(crate) fn planner(grid: &Grid, checks: Vec<BoxedCheck>) -> Planner {
    let search = searching(grid, Heuristic::Sdfm, Order::Balance, true);
    Planner::new(
        Box::new(ProposeAll),
        Box::new(search),
        checks,
        Order::Balance,
        0,
    )
}

/// A box with sides in metres; its frame is at its lowest corner, its weight in its middle.
pub(crate) fn cuboid(name: &str, sides_m: [f64; 3], mass_kg: f64) -> Model {
    Model {
        name: name.to_owned(),
        mesh: Mesh::cuboid([0.0; 3], sides_m),
        volume_m3: sides_m.iter().product(),
        pieces: Vec::new(),
        mass: MassProperties {
            mass_kg,
            centre_of_mass_m: Point3::from(sides_m.map(|side_m| side_m / 2.0)),
            inertia_kg_m2: Matrix3::identity(),
        },
        carries_kg: None,
        resting_poses: Vec::new(),
    }
}

pub(crate) fn lies(model: Model, at_m: [f64; 3]) -> LyingSolid {
    let [x_m, y_m, z_m] = at_m;
    LyingSolid::new(Arc::new(model), Isometry3::translation(x_m, y_m, z_m))
}

/// Of a container that is no box the floor's setback and the corners' radius, in shares of what is
/// possible.
fn shapes() -> impl Strategy<Value = [f64; 2]> {
    prop_oneof![
        Just([0.0, 0.0]),
        Just([0.0, 1.0]),
        [0.0..0.9_f64, 0.0..1.0_f64]
    ]
}

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
        shapes(),
    )
        .prop_map(|(nx, ny, rim, cell_m, unit_m, yaws, [draft, radius])| {
            let resolution = Resolution::new(cell_m, unit_m, Yaws::half_turn(yaws).unwrap());
            let [x_m, y_m] = [nx, ny].map(|cells| cells as f64 * cell_m);
            let size = ContainerSize::cuboid(x_m, y_m, f64::from(rim) * unit_m);
            let half_m = 0.5 * x_m.min(y_m);
            let draft_rad = (draft * half_m / size.z_m).atan().min(0.7);
            let leaning = ContainerSize { draft_rad, ..size };
            let corner_radius_m = radius * (half_m - leaning.setback_m(0.0));
            let container = ContainerSize {
                corner_radius_m,
                ..leaning
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

/// The published weights, the dense ones, and some with other weights of the top's height.
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

/// The same content and item with fine surfaces up to 5 mm off those of the cells.
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
