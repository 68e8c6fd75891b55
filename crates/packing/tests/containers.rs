//! Steps over several open containers, and streams that are packed into them.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

mod support;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use ppnpack_packing::candidate::Candidate;
use ppnpack_packing::closing::ClosingRules;
use ppnpack_packing::containers::{ContainerChoice, ContainersStep, OpenContainer, OpenContainers};
use ppnpack_packing::episode::{Ending, IdealCell, PackingCell, Play, play};
use ppnpack_packing::evaluator::Evaluator;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::objective::{Heuristic, Order};
use ppnpack_packing::orders::Orders;
use ppnpack_packing::placement::{Placement, RestingPlacement};
use ppnpack_packing::plan::{Planner, StepInput};
use ppnpack_packing::proposals::{Proposals, ProposeAll};
use ppnpack_packing::step::{Evaluated, PlacementCounts, StageResult};
use ppnpack_packing::stream::{StreamPlay, play_stream};
use proptest::prelude::*;
use support::ideal::{Ideal, planner};

const HEURISTICS: [Heuristic; 3] = [Heuristic::Sdfm, Heuristic::Dbl, Heuristic::Hm];

/// What a step over containers has to choose: of what each container alone would choose the best, or what the fullest one would
/// that has any choice. Container, arrival and value.
fn expected(
    grid: &Grid,
    heuristic: Heuristic,
    scenes: &[(Scene, f64)],
    candidates: &[Candidate],
    choice: ContainerChoice,
) -> Option<(usize, usize, f64)> {
    let mut offers = Vec::new();
    for (container, (scene, filled_percent)) in scenes.iter().enumerate() {
        let mut planner = planner(grid, heuristic);
        let plan = planner.plan(&StepInput::new(grid, scene, candidates));
        if let Some(at) = plan.unwrap().choice() {
            let arrival = candidates[at.candidate].arrival;
            offers.push((*filled_percent, (container, arrival, at.value)));
        }
    }
    // The first of equal ones.
    let best = match choice {
        ContainerChoice::Best => offers
            .iter()
            .min_by(|(_, (_, _, a)), (_, (_, _, b))| a.total_cmp(b)),
        ContainerChoice::Fullest => offers.iter().min_by(|(a, _), (b, _)| b.total_cmp(a)),
    };
    best.map(|(_, offer)| *offer)
}

/// A grid, items that arrive, and what three containers hold.
fn cases() -> impl Strategy<Value = (Grid, Vec<Arc<Item>>, Vec<Scene>)> {
    support::grids().prop_flat_map(|grid| {
        let items =
            proptest::collection::vec(support::items(grid.resolution().yaws().count()), 4..14);
        let scene = support::heightmaps(&grid).prop_map(Scene::from_heightmap);
        let scenes = proptest::collection::vec(scene, 3);
        (Just(grid), items, scenes)
    })
}

proptest! {
    #[test]
    fn the_choice_is_that_of_a_search_of_every_container_from_the_beginning(
        (grid, items, scenes) in cases(),
        heuristic in proptest::sample::select(&HEURISTICS[..]),
        is_best in any::<bool>(),
    ) {
        let choice = match is_best {
            true => ContainerChoice::Best,
            false => ContainerChoice::Fullest,
        };
        let mut open = OpenContainers::default();
        let mut cells = Vec::new();
        for scene in scenes {
            open.open(planner(&grid, heuristic));
            cells.push(IdealCell::holding(&grid, scene));
        }
        let mut filled_percent = vec![0.0, 1.0, 0.5];
        let mut waiting: Vec<Candidate> = Candidate::sequence(items);
        let mut step = 0;
        while !waiting.is_empty() {
            let buffer: Vec<Candidate> = waiting.iter().take(3).cloned().collect();
            let scenes: Vec<(Scene, f64)> = cells
                .iter_mut()
                .map(|cell| cell.scan().unwrap())
                .zip(filled_percent.clone())
                .collect();
            let containers: Vec<OpenContainer<'_>> = scenes
                .iter()
                .map(|(scene, filled_percent)| OpenContainer { grid: &grid, scene, filled_percent: *filled_percent })
                .collect();
            let input = ContainersStep { step, choice, ..ContainersStep::new(&containers, &buffer) };
            let (chosen, effort) = open.plan(&input).unwrap();
            let found = chosen.as_ref().map(|chosen| {
                let arrival = buffer[chosen.placement.candidate].arrival;
                (chosen.container, arrival, chosen.placement.value)
            });
            prop_assert_eq!(found, expected(&grid, heuristic, &scenes, &buffer, choice));
            prop_assert!(effort.searched <= containers.len());
            step += 1;
            let Some(chosen) = chosen else {
                waiting.remove(0);
                continue;
            };
            let taken = &buffer[chosen.placement.candidate];
            let cell = &mut cells[chosen.container];
            cell.place(taken, &chosen.placement.resting, &chosen.evidence).unwrap();
            open.changed(chosen.container);
            filled_percent[chosen.container] += 0.1;
            waiting.retain(|held| held.arrival != taken.arrival);
        }
    }

    #[test]
    fn every_item_of_a_stream_is_in_one_container_or_fits_nowhere(
        (grid, items, _) in cases(),
        open in 1_usize..4,
        buffer in 1_usize..4,
    ) {
        let count = items.len();
        let mut supply = Ideal;
        let how = StreamPlay { open, buffer, choice: ContainerChoice::Fullest, closing: ClosingRules::default() };
        let stream = play_stream(&grid, &mut supply, Candidate::sequence(items), Orders::default(), how).unwrap();
        prop_assert_eq!(stream.open.len(), open);
        let all = || stream.closed.iter().chain(&stream.open);
        let placed = all().flat_map(|filled| filled.steps.iter().map(|step| step.candidate.arrival));
        let unplaceable = stream.unplaceable.iter().map(|held| held.arrival);
        let known: Vec<usize> = placed.chain(unplaceable).collect();
        prop_assert_eq!(known.len(), count);
        prop_assert_eq!(known.into_iter().collect::<BTreeSet<_>>().len(), count);
        for filled in all() {
            prop_assert_eq!(filled.packed().items, filled.steps.len());
        }
        let numbers: BTreeSet<usize> = all().map(|filled| filled.number).collect();
        prop_assert_eq!(numbers, (0..stream.closed.len() + open).collect());
    }

    #[test]
    fn with_one_open_container_a_stream_is_one_episode_after_another(
        (grid, items, _) in cases(),
        buffer in 1_usize..4,
    ) {
        let mut left = Candidate::sequence(items);
        let how = StreamPlay { open: 1, buffer, choice: ContainerChoice::Fullest, closing: ClosingRules::default() };
        let mut supply = Ideal;
        let stream = play_stream(&grid, &mut supply, left.clone(), Orders::default(), how).unwrap();
        let mut containers = stream.closed.iter().chain(&stream.open);
        let fits_nowhere: Vec<usize> = stream.unplaceable.iter().map(|held| held.arrival).collect();
        left.retain(|held| !fits_nowhere.contains(&held.arrival));
        if !fits_nowhere.is_empty() {
            // They are left out while a container is empty, and hold others up before.
            return Ok(());
        }
        while !left.is_empty() {
            let mut cell = IdealCell::new(&grid);
            let mut planner = planner(&grid, Heuristic::Sdfm);
            let how = Play::with_buffer(buffer);
            let episode = play(&grid, &mut planner, &mut cell, left.clone(), how, &mut ()).unwrap();
            let arrivals = |steps: &[ppnpack_packing::episode::Step]| -> Vec<usize> {
                steps.iter().map(|step| step.candidate.arrival).collect()
            };
            let packed = arrivals(&episode.steps);
            prop_assert_eq!(&arrivals(&containers.next().unwrap().steps), &packed);
            left.retain(|held| !packed.contains(&held.arrival));
            prop_assert_eq!(left.is_empty(), matches!(episode.ending, Ending::AllPacked));
        }
        prop_assert!(containers.next().is_none());
    }
}

#[test]
fn a_container_that_did_not_change_is_searched_for_new_items_alone() {
    let grid = support::blocks::grid();
    let candidates = support::blocks::blocks(4);
    let mut open = OpenContainers::default();
    let mut cells = vec![IdealCell::new(&grid), IdealCell::new(&grid)];
    for _ in &cells {
        open.open(planner(&grid, Heuristic::Sdfm));
    }
    let mut plan = |cells: &mut [IdealCell], buffer: &[Candidate]| {
        let scenes: Vec<Scene> = cells.iter_mut().map(|cell| cell.scan().unwrap()).collect();
        let containers = scenes.iter().map(|scene| OpenContainer {
            grid: &grid,
            scene,
            filled_percent: 0.0,
        });
        let containers: Vec<_> = containers.collect();
        let input = ContainersStep {
            choice: ContainerChoice::Best,
            ..ContainersStep::new(&containers, buffer)
        };
        open.plan(&input).unwrap()
    };
    let (_, effort) = plan(&mut cells, &candidates[..3]);
    assert_eq!(effort.searched, 2);
    // Nothing is new.
    let (again, effort) = plan(&mut cells, &candidates[..3]);
    assert!(again.is_some());
    assert_eq!(effort.searched, 0);
    // The last item is.
    let (_, effort) = plan(&mut cells, &candidates);
    assert_eq!(effort.searched, 2);
}

#[test]
fn a_container_that_nothing_fits_into_is_not_searched_again() {
    let grid = support::blocks::grid();
    let candidates = support::blocks::blocks(4);
    let mut open = OpenContainers::default();
    let mut full = Heightmap::empty(&grid);
    (0..grid.nx()).for_each(|x| (0..grid.ny()).for_each(|y| full.raise(x, y, grid.rim())));
    open.open(planner(&grid, Heuristic::Sdfm));
    open.open(planner(&grid, Heuristic::Sdfm));
    let mut plan = |buffer: &[Candidate], scenes: [Scene; 2]| {
        let containers = scenes.each_ref().map(|scene| OpenContainer {
            grid: &grid,
            scene,
            filled_percent: f64::from(scene.heightmap().max()),
        });
        open.plan(&ContainersStep::new(&containers, buffer))
            .unwrap()
    };
    let scenes = || [full.clone(), Heightmap::empty(&grid)].map(Scene::from_heightmap);
    let (chosen, effort) = plan(&candidates[..3], scenes());
    assert_eq!((chosen.unwrap().container, effort.searched), (1, 2));
    let (chosen, effort) = plan(&candidates[..3], scenes());
    assert_eq!((chosen.unwrap().container, effort.searched), (1, 0));
    // The full one is asked for the new item alone.
    let (_, effort) = plan(&candidates, scenes());
    assert_eq!(effort.searched, 2);
}

/// Ranks one placement for each item, at a price.
struct Priced {
    by_arrival: BTreeMap<usize, f64>,
    ranked: Vec<Evaluated>,
}

impl Evaluator for Priced {
    fn rank(&mut self, input: &StepInput<'_>, group: &[usize], _: &Proposals) -> StageResult {
        let priced = group.iter().map(|candidate| Evaluated {
            candidate: *candidate,
            resting: RestingPlacement {
                placement: Placement { yaw: 0, x: 0, y: 0 },
                resting_height: 0,
            },
            value: self.by_arrival[&input.candidates[*candidate].arrival],
        });
        self.ranked = priced.filter(|placement| input.wants(placement)).collect();
        self.ranked.sort_by(|a, b| b.rank_cmp(a));
        Ok(())
    }

    fn next_best(&mut self, _: &StepInput<'_>) -> StageResult<Option<Evaluated>> {
        Ok(self.ranked.pop())
    }

    fn counts(&self, _: usize) -> PlacementCounts {
        PlacementCounts {
            possible: 1,
            proposed: 1,
            fitting: 1,
        }
    }
}

/// A container kept the best that it had offered, though an item that came later had only been looked at down to the offer of
/// another container, and might have a better place than that.
#[test]
fn an_item_that_was_looked_at_down_to_the_offer_of_another_container_is_looked_at_again_when_that_is_gone()
 {
    let grid = Grid::reference();
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let yaws = grid.resolution().yaws().count();
    let views = vec![ViewSurfaces::of_cells(1, 1, vec![1], vec![0]); yaws];
    let item = Arc::new(Item::new("cube", views, 1e-6).unwrap());
    let held = |arrival| Candidate::new(arrival, Arc::clone(&item));
    let containers = [0; 3].map(|_| OpenContainer {
        grid: &grid,
        scene: &scene,
        filled_percent: 0.0,
    });
    // What items 3, 4, 5 and 6 cost in each container.
    let prices = [
        [30.0, 25.0, 99.0, 99.0],
        [99.0, 99.0, 20.0, 99.0],
        [99.0, 99.0, 99.0, 10.0],
    ];
    let mut open = OpenContainers::default();
    for prices in prices {
        let priced = Priced {
            by_arrival: (3..).zip(prices).collect(),
            ranked: Vec::new(),
        };
        let (all, order) = (Box::new(ProposeAll), Order::Balance);
        open.open(Planner::new(all, Box::new(priced), Vec::new(), order, 0));
    }
    let mut chosen = |arrivals: &[usize]| {
        let buffer: Vec<Candidate> = arrivals.iter().copied().map(held).collect();
        let step = ContainersStep {
            choice: ContainerChoice::Best,
            ..ContainersStep::new(&containers, &buffer)
        };
        let chosen = open.plan(&step).unwrap().0.unwrap();
        open.changed(chosen.container);
        (chosen.container, buffer[chosen.placement.candidate].arrival)
    };
    assert_eq!(chosen(&[3, 5, 6]), (2, 6));
    assert_eq!(chosen(&[3, 4, 5]), (1, 5));
    assert_eq!(chosen(&[3, 4]), (0, 4));
}
