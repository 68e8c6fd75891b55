//! The best-first search against a full sort, its caches, threads and proposals.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::sync::Arc;

use ppnpack_packing::check::{BoxedCheck, Fits};
use ppnpack_packing::grid::{Grid, Units};
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::objective::{Heuristic, Order, Weights};
use ppnpack_packing::placement::{Placement, RestingPlacement};
use ppnpack_packing::plan::{
    Candidate, Evaluated, Evaluator, PlacementCounts, Planner, Reason, StepInput,
};
use ppnpack_packing::proposals::{
    CandidateProposals, Percent, Proposals, ProposeAll, ProposeRandom, Proposer, YawRange,
};
use ppnpack_packing::refusal::Cause;
use ppnpack_packing::search::{Search, SearchSettings};
use ppnpack_packing::stability::PublishedStability;
use proptest::prelude::*;

mod support;

use support::oracle::Oracle;

const HEURISTICS: [Heuristic; 6] = [
    Heuristic::Sdfm,
    Heuristic::Dbl,
    Heuristic::Hm,
    Heuristic::Mta,
    Heuristic::FirstFit,
    Heuristic::Random,
];

fn settings(heuristic: Heuristic, order: Order) -> SearchSettings {
    SearchSettings {
        heuristic,
        order,
        seed: 7,
        ..SearchSettings::default()
    }
}

fn candidates(items: &[Arc<Item>]) -> Vec<Candidate> {
    let arrivals = items.iter().enumerate();
    arrivals
        .map(|(arrival, item)| Candidate::new(arrival, item.clone()))
        .collect()
}

fn ranking(search: &mut Search, input: &StepInput<'_>, proposals: &Proposals) -> Vec<Evaluated> {
    let group: Vec<usize> = (0..input.candidates.len()).collect();
    search.rank(input, &group, proposals).unwrap();
    std::iter::from_fn(|| search.next_best(input).unwrap()).collect()
}

fn all(input: &StepInput<'_>) -> Proposals {
    let mut proposals = Proposals::default();
    ProposeAll.propose(input, &mut proposals).unwrap();
    proposals
}

/// All yaws, cut into ranges, of which some may be empty.
fn parts(yaws: usize, mut cuts: Vec<usize>) -> Vec<YawRange> {
    cuts.extend([0, yaws]);
    cuts.retain(|cut| *cut <= yaws);
    cuts.sort_unstable();
    let range = |pair: &[usize]| YawRange {
        first: pair[0],
        end: pair[1],
    };
    cuts.windows(2).map(range).collect()
}

/// The content, where what reaches the rim is as high as items may reach.
fn walled(grid: &Grid, heightmap: &Heightmap, above_rim: Units) -> Heightmap {
    let mut walled = heightmap.clone();
    for x in 0..grid.nx() {
        for y in 0..grid.ny() {
            if heightmap.get(x, y).unwrap() >= grid.rim() {
                walled.raise(x, y, grid.rim() + above_rim);
            }
        }
    }
    walled
}

/// Every placement that does not reach too high with its value, sorted.
fn sorted(
    input: &StepInput<'_>,
    heuristic: Heuristic,
    weights: &Weights,
    above_rim: Units,
) -> Vec<(f64, usize, Placement)> {
    let grid = input.grid;
    let heightmap = &walled(grid, input.scene.heightmap(), above_rim);
    let mut found = Vec::new();
    for (index, candidate) in input.candidates.iter().enumerate() {
        for (yaw, view) in candidate.item.views().iter().enumerate() {
            let oracle = Oracle {
                grid,
                heightmap,
                view,
            };
            for x in 0..grid.nx() {
                for y in 0..grid.ny() {
                    let placement = Placement { yaw, x, y };
                    let Some(resting_height) = oracle.resting_height(placement) else {
                        continue;
                    };
                    if view.height() <= grid.rim()
                        && resting_height + view.height() <= grid.rim() + above_rim
                        && resting_height < grid.rim()
                    {
                        let at = RestingPlacement {
                            placement,
                            resting_height,
                        };
                        let value = oracle.value(&at, heuristic, weights, true);
                        found.push((value, index, placement));
                    }
                }
            }
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    found
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(384))]

    #[test]
    fn the_search_gives_what_a_full_sort_gives(
        (grid, heightmap, items) in support::scenes(3),
        heuristic in proptest::sample::select(&HEURISTICS[..4]),
        weights in support::weights(),
        above_rim in prop_oneof![Just(0), 1_i16..12],
    ) {
        let scene = Scene::from_heightmap(heightmap);
        let held = candidates(&items);
        let input = StepInput::new(&grid, &scene, &held);
        let above_rim_m = f64::from(above_rim) * grid.resolution().height_unit_m();
        let settings = SearchSettings { weights, above_rim_m, ..settings(heuristic, Order::Balance) };
        let mut search = Search::new(&grid, &settings).unwrap();
        let found = ranking(&mut search, &input, &all(&input));
        let expected = sorted(&input, heuristic, &weights, above_rim);
        prop_assert_eq!(found.len(), expected.len());
        for (found, (value, ..)) in found.iter().zip(&expected) {
            prop_assert!((found.value - value).abs() <= 1e-9 * value.abs().max(1.0));
        }
        // Equal values come by candidate, yaw, x, y.
        let key = |found: &Evaluated| (found.candidate, found.resting.placement);
        for pair in found.windows(2) {
            prop_assert!(
                pair[0].value < pair[1].value
                    || (pair[0].value == pair[1].value && key(&pair[0]) < key(&pair[1]))
            );
        }
    }

    #[test]
    fn threads_and_earlier_steps_change_nothing(
        (grid, first, items) in support::scenes(4),
        change in proptest::collection::vec((0_usize..14, 0_usize..14, 0_i16..60), 0..5),
        heuristic in proptest::sample::select(&HEURISTICS[..]),
    ) {
        let mut second = first.clone();
        for (x, y, height) in change {
            second.raise(x, y, height);
        }
        let held = candidates(&items);
        let scenes = [first, second.clone(), second].map(Scene::from_heightmap);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let settings = settings(heuristic, Order::Balance);
        let mut kept =
            Search::new(&grid, &settings).unwrap().with_pool(Arc::new(pool));
        for (step, scene) in scenes.iter().enumerate() {
            // The buffer changes from step to step too.
            let held = &held[step.min(held.len() - 1)..];
            let input = StepInput { step: step as u64 , ..StepInput::new(&grid, scene, held) };
            let mut fresh = Search::new(&grid, &settings).unwrap();
            let expected = ranking(&mut fresh, &input, &all(&input));
            prop_assert_eq!(ranking(&mut kept, &input, &all(&input)), expected);
        }
    }

    #[test]
    fn bounds_change_no_ranking(
        (grid, first, items) in support::scenes(3),
        change in proptest::collection::vec((0_usize..14, 0_usize..14, 0_i16..60), 0..5),
        heuristic in proptest::sample::select(&HEURISTICS[..]),
        weights in support::weights(),
        percent in 1.0_f64..100.0,
        above_rim_m in prop_oneof![Just(0.0), 0.001..0.05],
    ) {
        let mut second = first.clone();
        for (x, y, height) in change {
            second.raise(x, y, height);
        }
        let held = candidates(&items);
        let settings = SearchSettings { weights, above_rim_m, ..settings(heuristic, Order::Balance) };
        let mut bounded = Search::new(&grid, &settings).unwrap().bounded();
        let mut whole = Search::new(&grid, &settings).unwrap();
        for scene in [first, second].map(Scene::from_heightmap) {
            let input = StepInput { step: 1, ..StepInput::new(&grid, &scene, &held) };
            // All placements of the first candidate, a few yaws of the second and some placements of the third.
            let mut random = Proposals::default();
            ProposeRandom::new(Percent::new(percent).unwrap(), 5).propose(&input, &mut random).unwrap();
            let mut mixed = Proposals::default();
            mixed.push_all();
            mixed.push_all_at(YawRange { first: 1, end: 3 });
            if let CandidateProposals::Some(placements) = random.of(2) {
                mixed.push(placements.iter().copied());
            }
            for proposals in [&all(&input), &mixed] {
                let expected = ranking(&mut whole, &input, proposals);
                prop_assert_eq!(ranking(&mut bounded, &input, proposals), expected);
                for candidate in 0..held.len() {
                    prop_assert_eq!(bounded.counts(candidate), whole.counts(candidate));
                }
            }
        }
    }

    #[test]
    fn levels_blocks_and_proposals_give_one_ranking(
        (grid, heightmap, items) in support::scenes(3),
        heuristic in proptest::sample::select(&HEURISTICS[..]),
        order in proptest::sample::select(&[Order::Balance, Order::Arrival][..]),
        weights in support::weights(),
    ) {
        let scene = Scene::from_heightmap(heightmap);
        let held = candidates(&items);
        let input = StepInput { step: 4 , ..StepInput::new(&grid, &scene, &held) };
        // Every placement by name, backwards, and the first ones again.
        let mut named = Proposals::default();
        for candidate in &held {
            let mut placements: Vec<_> = support::possible_placements(&grid, &candidate.item).collect();
            placements.reverse();
            placements.extend_from_within(..placements.len().min(5));
            named.push(placements);
        }
        let settings = SearchSettings { weights, ..settings(heuristic, order) };
        let search = || Search::new(&grid, &settings).unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let pool = Arc::new(pool);
        let (mut levels, mut blocks) = (search(), search().bounded());
        let mut threads = search().with_pool(pool);
        let expected = ranking(&mut levels, &input, &all(&input));
        let compare = |search: &mut Search, proposals: &Proposals| {
            let found = ranking(search, &input, proposals);
            assert_eq!(found, expected);
            let bits = |ranked: &[Evaluated]| -> Vec<u64> {
                ranked.iter().map(|found| found.value.to_bits()).collect()
            };
            assert_eq!(bits(&found), bits(&expected));
        };
        compare(&mut blocks, &all(&input));
        for search in [&mut levels, &mut blocks, &mut threads] {
            compare(search, &named);
        }
        // The order of the group does not matter either.
        let group: Vec<usize> = (0..held.len()).rev().collect();
        blocks.rank(&input, &group, &all(&input)).unwrap();
        let backwards: Vec<_> = std::iter::from_fn(|| blocks.next_best(&input).unwrap()).collect();
        prop_assert_eq!(backwards, expected);
    }

    #[test]
    fn proposals_are_ranked_like_all_placements_restricted_to_them(
        (grid, heightmap, items) in support::scenes(3),
        heuristic in proptest::sample::select(&HEURISTICS[..]),
        percent in 1.0_f64..100.0,
    ) {
        let scene = Scene::from_heightmap(heightmap);
        let held = candidates(&items);
        let input = StepInput { step: 3, ..StepInput::new(&grid, &scene, &held) };
        let mut proposals = Proposals::default();
        let share = Percent::new(percent).unwrap();
        ProposeRandom::new(share, 5).propose(&input, &mut proposals).unwrap();
        let proposed = |found: &Evaluated| match proposals.of(found.candidate) {
            CandidateProposals::All => true,
            CandidateProposals::AllAt(yaws) => yaws.contains(found.resting.placement.yaw),
            CandidateProposals::Some(placements) => placements.contains(&found.resting.placement),
        };
        let mut search = Search::new(&grid, &settings(heuristic, Order::Balance)).unwrap();
        let mut expected = ranking(&mut search, &input, &all(&input));
        expected.retain(proposed);
        prop_assert_eq!(ranking(&mut search, &input, &proposals), expected);
        for (index, candidate) in held.iter().enumerate() {
            let possible = ppnpack_packing::proposals::possible_count(&grid, &candidate.item);
            let counts = search.counts(index);
            let is_low_enough = candidate.item.views().iter().any(|view| view.height() <= grid.rim());
            if is_low_enough {
                prop_assert_eq!(counts.possible, possible);
            }
            let wanted = share.of(ppnpack_packing::proposals::all_count(&grid, &candidate.item));
            prop_assert_eq!(counts.proposed, wanted.min(possible));
        }
    }

    #[test]
    fn a_ranking_split_by_yaw_and_merged_is_the_whole_one(
        (grid, heightmap, items) in support::scenes(3),
        heuristic in proptest::sample::select(&HEURISTICS[..]),
        cuts in proptest::collection::vec(0_usize..4, 0..3),
    ) {
        let scene = Scene::from_heightmap(heightmap);
        let held = candidates(&items);
        let input = StepInput { step: 2, ..StepInput::new(&grid, &scene, &held) };
        let settings = settings(heuristic, Order::Balance);
        let mut whole = Search::new(&grid, &settings).unwrap();
        let expected = ranking(&mut whole, &input, &all(&input));
        // One search that keeps its maps takes all parts but the first.
        let mut kept = Search::new(&grid, &settings).unwrap();
        let mut merged = Vec::new();
        let mut counted = vec![PlacementCounts::default(); held.len()];
        for (index, yaws) in parts(grid.resolution().yaws().count(), cuts).into_iter().enumerate() {
            let mut proposals = Proposals::default();
            held.iter().for_each(|_| proposals.push_all_at(yaws));
            let mut fresh = Search::new(&grid, &settings).unwrap();
            let search = if index == 0 { &mut fresh } else { &mut kept };
            let part = ranking(search, &input, &proposals);
            prop_assert!(part.iter().all(|found| yaws.contains(found.resting.placement.yaw)));
            merged.extend(part);
            for (candidate, counted) in counted.iter_mut().enumerate() {
                let part = search.counts(candidate);
                counted.possible += part.possible;
                counted.proposed += part.proposed;
                counted.fitting += part.fitting;
            }
        }
        let key = |found: &Evaluated| (found.candidate, found.resting.placement);
        merged.sort_by(|a, b| a.value.total_cmp(&b.value).then_with(|| key(a).cmp(&key(b))));
        prop_assert_eq!(merged, expected);
        for (candidate, counted) in counted.iter().enumerate() {
            prop_assert_eq!(*counted, whole.counts(candidate));
        }
    }

    #[test]
    fn a_plan_is_the_best_valid_placement_and_says_why_there_is_none(
        (grid, heightmap, items) in support::scenes(3),
        order in proptest::sample::select(&[Order::Balance, Order::BboxVolume, Order::Arrival, Order::Shuffled][..]),
    ) {
        let scene = Scene::from_heightmap(heightmap);
        let held = candidates(&items);
        let input = StepInput { alternatives: 2, ..StepInput::new(&grid, &scene, &held) };
        let search = Search::new(&grid, &settings(Heuristic::Sdfm, order)).unwrap();
        let checks: Vec<BoxedCheck> = vec![Box::new(PublishedStability::default()), Box::new(Fits)];
        let mut planner =
            Planner::new(Box::new(ProposeAll), Box::new(search), checks, order, 1);
        let plan = planner.plan(&input).unwrap();
        let mut search = Search::new(&grid, &settings(Heuristic::Sdfm, order)).unwrap();
        let mut stability = PublishedStability::default();
        let mut valid = ranking(&mut search, &input, &all(&input));
        let fitting = valid.clone();
        valid.retain(|found| {
            let view = &held[found.candidate].item.views()[found.resting.placement.yaw];
            stability.is_stable(&grid, scene.heightmap(), view, &found.resting)
        });
        if order == Order::Balance {
            prop_assert_eq!(plan.choice(), valid.first().copied());
            prop_assert!(plan.alternatives().eq(valid.iter().skip(1).take(2)));
        }
        prop_assert_eq!(plan.choice().is_some(), !valid.is_empty());
        for (index, report) in plan.candidates().iter().enumerate() {
            let of = |ranked: &[Evaluated]| ranked.iter().filter(|found| found.candidate == index).count();
            match &report.reason {
                Some(Reason::Rejected(refusal)) => {
                    prop_assert_eq!(refusal.cause, Cause::UnstableByPublishedTest);
                    prop_assert!(of(&fitting) > 0 && of(&valid) == 0);
                    prop_assert_eq!(report.refusals.total() as usize, of(&fitting));
                }
                Some(_) => prop_assert_eq!(of(&fitting), 0),
                None => prop_assert!(plan.choice().is_some()),
            }
        }
    }
}

#[test]
fn random_placements_are_spread_over_all_valid_ones() {
    let grid = Grid::reference();
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let surfaces = ViewSurfaces::of_cells(2, 2, vec![3; 4], vec![0; 4]);
    let item = Arc::new(Item::new("block", vec![surfaces; 4], 0.0).unwrap());
    let held = candidates(&[item]);
    let mut search = Search::new(&grid, &settings(Heuristic::Random, Order::Shuffled)).unwrap();
    let mut quadrants = [0; 8];
    for step in 0..4000 {
        let input = StepInput {
            step,
            ..StepInput::new(&grid, &scene, &held)
        };
        let group = [0];
        search.rank(&input, &group, &all(&input)).unwrap();
        let Placement { yaw, x, y } = search.next_best(&input).unwrap().unwrap().resting.placement;
        quadrants[(yaw / 2) * 4 + (x / 16) * 2 + y / 16] += 1;
    }
    assert!(
        quadrants.iter().all(|count| (400..=600).contains(count)),
        "{quadrants:?}"
    );
}
