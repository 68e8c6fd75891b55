//! Coarse proposals against the plain meaning of their regions.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::collections::HashSet;
use std::sync::Arc;

use ppnpack_packing::coarse::{CoarseGrid, CoarseToFine, Coarsening};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::item::{Item, ItemView};
use ppnpack_packing::objective::{Heuristic, Order};
use ppnpack_packing::placement::Placement;
use ppnpack_packing::plan::{Candidate, Evaluator, StepInput};
use ppnpack_packing::proposals::{
    CandidateProposals, Percent, Proposals, ProposeAll, ProposeRandom, Proposer, all_count,
    possible_count,
};
use ppnpack_packing::search::{ProposeBest, Search, SearchSettings};
use proptest::prelude::*;

mod support;

fn candidates(items: &[Arc<Item>]) -> Vec<Candidate> {
    let arrivals = items.iter().cloned().enumerate();
    arrivals
        .map(|(arrival, item)| Candidate::new(arrival, item))
        .collect()
}

/// Twice the distance between the centres of two footprints along a side, in fine cells.
fn twice_apart(cells: usize, (corner, footprint): (usize, usize), coarse: (usize, usize)) -> usize {
    (2 * corner + footprint).abs_diff((2 * coarse.0 + coarse.1) * cells)
}

/// Whether no other coarse corner along a side is nearer to a fine one.
fn is_nearest(
    cells: usize,
    fine: (usize, usize),
    coarse: (usize, usize),
    coarse_cells: usize,
) -> bool {
    let distance = |corner| twice_apart(cells, fine, (corner, coarse.1));
    (0..=coarse_cells - coarse.1).all(|other| distance(coarse.0) <= distance(other))
}

fn settings() -> SearchSettings {
    SearchSettings {
        heuristic: Heuristic::Sdfm,
        order: Order::Balance,
        seed: 7,
        ..SearchSettings::default()
    }
}

fn has_room(grid: &Grid, view: &ItemView) -> bool {
    view.nx() <= grid.nx() && view.ny() <= grid.ny()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn regions_partition_all_placements_by_the_nearest_footprint_centre(
        (grid, _, items) in support::scenes(2),
        cells in 1_usize..4,
    ) {
        let Ok(grids) = CoarseGrid::new(&grid, Coarsening { cells, yaws: 1 }) else {
            return Ok(());
        };
        for item in &items {
            let coarse = grids.item(item).unwrap();
            let mut found = HashSet::new();
            for at in support::possible_placements(grids.coarse(), &coarse) {
                for fine in grids.region(item.views(), coarse.views(), at) {
                    prop_assert!(found.insert(fine), "{fine:?} belongs to two regions");
                    prop_assert_eq!(fine.yaw, at.yaw);
                    let (view, pooled) = (&item.views()[fine.yaw], &coarse.views()[at.yaw]);
                    let (nx, ny) = (grids.coarse().nx(), grids.coarse().ny());
                    prop_assert!(is_nearest(cells, (fine.x, view.nx()), (at.x, pooled.nx()), nx));
                    prop_assert!(is_nearest(cells, (fine.y, view.ny()), (at.y, pooled.ny()), ny));
                }
            }
            let expected: HashSet<Placement> = support::possible_placements(&grid, item)
                .filter(|at| has_room(grids.coarse(), &coarse.views()[at.yaw]))
                .collect();
            prop_assert_eq!(found, expected);
        }
    }

    #[test]
    fn all_coarse_placements_propose_all_fine_ones(
        (grid, heightmap, items) in support::scenes(3),
        cells in 1_usize..4,
        yaws in 1_usize..3,
    ) {
        let Ok(grids) = CoarseGrid::new(&grid, Coarsening { cells, yaws }) else {
            return Ok(());
        };
        let scene = Scene::from_heightmap(heightmap);
        let held = candidates(&items);
        let input = StepInput { step: 0, ..StepInput::new(&grid, &scene, &held) };
        let everything = ProposeRandom::new(Percent::new(100.0).unwrap(), 1);
        let coarse: Vec<Item> = items.iter().map(|item| grids.item(item).unwrap()).collect();
        let coarse_grid = grids.coarse().clone();
        let mut proposer = CoarseToFine::new(grids, Box::new(everything));
        let mut proposals = Proposals::default();
        proposer.propose(&input, &mut proposals).unwrap();
        for (index, coarse) in coarse.iter().enumerate() {
            let item = &held[index].item;
            match proposals.of(index) {
                CandidateProposals::AllAt(_) => prop_assert!(false, "some yaws alone"),
                CandidateProposals::All => {
                    prop_assert_eq!(possible_count(&coarse_grid, coarse), 0);
                }
                CandidateProposals::Some(placements) => {
                    let found: HashSet<_> = placements.iter().copied().collect();
                    prop_assert_eq!(found.len(), placements.len());
                    // What fits the container and not the coarse one, by a rounded footprint, may be left out.
                    let all = coarse.views().iter().all(|view| has_room(&coarse_grid, view));
                    if all {
                        let expected: HashSet<_> = support::possible_placements(&grid, item).collect();
                        prop_assert_eq!(found, expected);
                    }
                }
            }
        }
    }

    #[test]
    fn the_best_are_the_first_of_each_candidates_ranking(
        (grid, heightmap, items) in support::scenes(3),
        percent in 1.0_f64..100.0,
    ) {
        let scene = Scene::from_heightmap(heightmap);
        let held = candidates(&items);
        let input = StepInput { step: 0, ..StepInput::new(&grid, &scene, &held) };
        let share = Percent::new(percent).unwrap();
        let mut proposals = Proposals::default();
        ProposeBest::new(&grid, &settings(), share).unwrap().propose(&input, &mut proposals).unwrap();
        let mut all = Proposals::default();
        ProposeAll.propose(&input, &mut all).unwrap();
        for (index, candidate) in held.iter().enumerate() {
            let mut search = Search::new(&grid, &settings()).unwrap();
            search.rank(&input, &[index], &all).unwrap();
            let ranking = std::iter::from_fn(|| search.next_best(&input).unwrap());
            let wanted = share.of(all_count(&grid, &candidate.item)) as usize;
            let expected: Vec<Placement> =
                ranking.map(|found| found.resting.placement).take(wanted).collect();
            prop_assert_eq!(proposals.of(index), CandidateProposals::Some(&expected[..]));
        }
    }

    #[test]
    fn a_shared_budget_goes_to_the_first_of_the_ranking_of_all(
        (grid, heightmap, items) in support::scenes(3),
        percent in 1.0_f64..100.0,
        wide in 1.0_f64..100.0,
        order in prop_oneof![Just(Order::Balance), Just(Order::Arrival)],
    ) {
        let scene = Scene::from_heightmap(heightmap);
        let held = candidates(&items);
        let input = StepInput { step: 0, ..StepInput::new(&grid, &scene, &held) };
        let (share, wide) = (Percent::new(percent).unwrap(), Percent::new(wide).unwrap());
        let settings = SearchSettings { order, ..settings() };
        let mut among = ProposeRandom::new(wide, 3);
        let best = ProposeBest::new(&grid, &settings, share).unwrap();
        let mut proposals = Proposals::default();
        best.shared_by_candidates()
            .among(Box::new(among.clone()))
            .propose(&input, &mut proposals)
            .unwrap();

        let mut all = Proposals::default();
        among.propose(&input, &mut all).unwrap();
        let wanted = |index: usize| share.of(all_count(&grid, &held[index].item)) as usize;
        let everybody: Vec<usize> = (0..held.len()).collect();
        let groups = match order {
            Order::Balance => vec![everybody],
            _ => everybody.iter().map(|index| vec![*index]).collect(),
        };
        let mut expected = vec![Vec::new(); held.len()];
        for group in groups {
            let mut search = Search::new(&grid, &settings).unwrap();
            search.rank(&input, &group, &all).unwrap();
            let ranking = std::iter::from_fn(|| search.next_best(&input).unwrap());
            for found in ranking.take(group.iter().copied().map(wanted).sum()) {
                expected[found.candidate].push(found.resting.placement);
            }
        }
        for (index, expected) in expected.iter().enumerate() {
            prop_assert_eq!(proposals.of(index), CandidateProposals::Some(&expected[..]));
        }
    }

    #[test]
    fn proposals_that_repeat_or_leave_the_container_count_once_or_not(
        (grid, heightmap, items) in support::scenes(1),
    ) {
        let scene = Scene::from_heightmap(heightmap);
        let held = candidates(&items);
        let input = StepInput { step: 0, ..StepInput::new(&grid, &scene, &held) };
        let possible: Vec<Placement> = support::possible_placements(&grid, &items[0]).collect();
        let outside = [
            Placement { yaw: 0, x: grid.nx(), y: 0 },
            Placement { yaw: 0, x: 0, y: usize::MAX },
            Placement { yaw: grid.resolution().yaws().count(), x: 0, y: 0 },
        ];
        let mut proposals = Proposals::default();
        proposals.push(possible.iter().chain(&outside).chain(&possible).copied());
        let mut search = Search::new(&grid, &settings()).unwrap();
        search.rank(&input, &[0], &proposals).unwrap();
        prop_assert_eq!(search.counts(0).proposed, possible.len() as u64);
        let found = std::iter::from_fn(|| search.next_best(&input).unwrap());
        let found: Vec<Placement> = found.map(|found| found.resting.placement).collect();
        let distinct: HashSet<Placement> = found.iter().copied().collect();
        prop_assert_eq!(found.len(), distinct.len());
    }
}
