//! A step allocates nothing once its buffers have grown.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::sync::Arc;

use ppnpack_packing::check::BoxedCheck;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::objective::{Heuristic, Order};
use ppnpack_packing::plan::{Candidate, Planner, StepInput};
use ppnpack_packing::proposals::{Percent, ProposeAll, ProposeRandom, Proposer};
use ppnpack_packing::search::{Search, SearchSettings};
use ppnpack_packing::stability::{PhysicalStability, PublishedStability};

fn item(nx: usize, ny: usize, height: i16) -> Arc<Item> {
    let [top, bottom] = [height, 0].map(|height| vec![height; nx * ny]);
    let surfaces = ViewSurfaces::of_cells(nx, ny, top, bottom);
    Arc::new(Item::new("box", vec![surfaces; 4], 0.0).unwrap())
}

fn planner(
    grid: &Grid,
    proposer: Box<dyn Proposer>,
    is_bounded: bool,
    heuristic: Heuristic,
    order: Order,
) -> Planner {
    let settings = SearchSettings {
        heuristic,
        order,
        seed: 1,
        ..SearchSettings::default()
    };
    let mut search = Search::new(grid, &settings).unwrap();
    if is_bounded {
        search = search.bounded();
    }
    let checks: Vec<BoxedCheck> = vec![
        Box::new(PublishedStability::default()),
        Box::new(PhysicalStability::new(Default::default())),
    ];
    Planner::new(proposer, Box::new(search), checks, order, 1)
}

#[test]
fn a_step_allocates_nothing_after_warm_up() {
    let grid = Grid::reference();
    let share = Percent::new(5.0).unwrap();
    let mut half_full = Heightmap::empty(&grid);
    for (x, y, height) in (0..32).flat_map(|x| (0..32).map(move |y| (x, y, 10 * (x % 5 + y % 3)))) {
        half_full.raise(x, y, height as i16);
    }
    let mut changed = half_full.clone();
    changed.raise(3, 4, 60);
    let scenes = [Heightmap::empty(&grid), half_full, changed].map(Scene::from_heightmap);
    let kinds: Vec<Arc<Item>> = (3..12)
        .map(|size| item(size, size + 1, 4 * size as i16))
        .collect();
    type Source = fn(Percent) -> Box<dyn Proposer>;
    let all: Source = |_| Box::new(ProposeAll);
    let random: Source = |share| Box::new(ProposeRandom::new(share, 3));
    let sources = [(all, false), (all, true), (random, false)];
    for heuristic in [
        Heuristic::Sdfm,
        Heuristic::Dbl,
        Heuristic::Hm,
        Heuristic::Mta,
        Heuristic::Random,
    ] {
        for order in [Order::Balance, Order::BboxVolume, Order::Shuffled] {
            for (source, is_bounded) in sources {
                let mut planner = planner(&grid, source(share), is_bounded, heuristic, order);
                let steps: Vec<Vec<Candidate>> = (0..12)
                    .map(|step| {
                        let held = (0..5).map(|slot| kinds[(step + slot) % kinds.len()].clone());
                        let held = held.enumerate();
                        held.map(|(arrival, item)| Candidate::new(arrival, item))
                            .collect()
                    })
                    .collect();
                let mut play = || {
                    for (step, candidates) in steps.iter().enumerate() {
                        let scene = &scenes[step % scenes.len()];
                        let step = step as u64;
                        planner
                            .plan(&StepInput {
                                step,
                                ..StepInput::new(&grid, scene, candidates)
                            })
                            .unwrap();
                    }
                };
                play();
                play();
                let counted = allocation_counter::measure(play);
                assert_eq!(
                    counted.count_total, 0,
                    "{heuristic:?} {order:?}, bounded {is_bounded}: {counted:?}"
                );
            }
        }
    }
}
