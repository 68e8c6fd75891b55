//! Proposals that are drawn at random, against all that they are drawn from.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::panic,
    reason = "a panic in a test is a failing test"
)]

use std::collections::BTreeMap;
use std::sync::Arc;

use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::objective::{Heuristic, Order};
use ppnpack_packing::placement::Placement;
use ppnpack_packing::plan::{Candidate, Planner, Reason, StepInput};
use ppnpack_packing::proposals::{
    CandidateProposals, Percent, Proposals, ProposeRandom, ProposeTries, Proposer, all_count,
};
use ppnpack_packing::search::{Search, SearchSettings};
use proptest::prelude::*;

mod support;

fn block(nx: usize, ny: usize) -> ViewSurfaces {
    ViewSurfaces::of_cells(nx, ny, vec![10; nx * ny], vec![0; nx * ny])
}

fn item(views: Vec<ViewSurfaces>) -> Arc<Item> {
    Arc::new(Item::new("block", views, 0.0).unwrap())
}

/// A container in which an item has two placements at one yaw and four at the other.
fn six_placements() -> (Grid, Arc<Item>) {
    let resolution = Resolution::new(0.01, 0.002, Yaws::half_turn(2).unwrap());
    let container = ContainerSize {
        x_m: 0.03,
        y_m: 0.02,
        z_m: 0.1,
    };
    let grid = Grid::new(container, resolution.unwrap()).unwrap();
    (grid, item(vec![block(2, 2), block(2, 1)]))
}

/// What is proposed for an item in so many steps.
fn drawn(
    grid: &Grid,
    item: &Arc<Item>,
    proposer: &mut dyn Proposer,
    steps: u64,
) -> Vec<Vec<Placement>> {
    let scene = Scene::from_heightmap(Heightmap::empty(grid));
    let held = [Candidate::new(0, Arc::clone(item))];
    let mut proposals = Proposals::default();
    let mut of_step = |step| {
        let input = StepInput {
            step,
            ..StepInput::new(grid, &scene, &held)
        };
        proposer.propose(&input, &mut proposals).unwrap();
        named(&proposals)
    };
    (0..steps).map(&mut of_step).collect()
}

fn named(proposals: &Proposals) -> Vec<Placement> {
    match proposals.of(0) {
        CandidateProposals::Some(placements) => placements.to_vec(),
        other => panic!("not named one by one: {other:?}"),
    }
}

/// A value that a chi-square of so many degrees of freedom stays below with the probability of the normal quantile (Wilson and
/// Hilferty).
fn chi_square(freedom: usize, normal_quantile: f64) -> f64 {
    let spread = 2.0 / (9.0 * freedom as f64);
    freedom as f64 * (1.0 - spread + normal_quantile * spread.sqrt()).powi(3)
}

/// Asserts that a statistic lies between the first and the last thousandth of a chi-square's values.
fn assert_is_chance(statistic: f64, freedom: usize) {
    let [least, most] = [-3.09, 3.09].map(|quantile| chi_square(freedom, quantile));
    assert!(
        (least..most).contains(&statistic),
        "{statistic} of {freedom} degrees of freedom, where {least} to {most} is chance"
    );
}

/// Pearson's statistic.
fn statistic(counts: impl Iterator<Item = (usize, f64)>) -> f64 {
    let terms = counts.map(|(count, expected)| (count as f64 - expected).powi(2) / expected);
    terms.sum()
}

/// All subsets of some size.
fn subsets(of: &[Placement], size: usize) -> Vec<Vec<Placement>> {
    let masks = 0_u32..1 << of.len();
    let masks = masks.filter(|mask| mask.count_ones() as usize == size);
    let chosen = |mask: u32| {
        let each = of.iter().enumerate();
        let each = each.filter(|(at, _)| mask & (1 << at) != 0);
        each.map(|(_, placement)| *placement).collect()
    };
    masks.map(chosen).collect()
}

#[test]
fn every_subset_of_the_possible_placements_is_equally_likely() {
    const STEPS: u64 = 12_000;
    let (grid, item) = six_placements();
    let possible: Vec<Placement> = support::possible_placements(&grid, &item).collect();
    assert_eq!(possible.len(), 6);
    // Of twelve placements with those that leave the container; few are drawn, and of many those that are left out.
    for (percent, size) in [(8.0, 1), (16.0, 2), (25.0, 3), (33.0, 4), (41.0, 5)] {
        let mut proposer = ProposeRandom::new(Percent::new(percent).unwrap(), 7);
        let all = subsets(&possible, size);
        let mut counts: BTreeMap<Vec<Placement>, usize> =
            all.into_iter().map(|subset| (subset, 0)).collect();
        for subset in drawn(&grid, &item, &mut proposer, STEPS) {
            *counts.get_mut(&subset).unwrap() += 1;
        }
        let expected = STEPS as f64 / counts.len() as f64;
        let found = statistic(counts.values().map(|count| (*count, expected)));
        assert_is_chance(found, counts.len() - 1);
    }
}

#[test]
fn of_a_whole_container_every_placement_is_equally_likely() {
    const STEPS: u64 = 1_000;
    let grid = Grid::reference();
    let item = item(vec![block(5, 7), block(8, 8), block(7, 5), block(9, 3)]);
    let possible: Vec<Placement> = support::possible_placements(&grid, &item).collect();
    for percent in [5.0, 60.0] {
        let share = Percent::new(percent).unwrap();
        let mut proposer = ProposeRandom::new(share, 11);
        let mut counts: BTreeMap<Placement, usize> = possible.iter().map(|at| (*at, 0)).collect();
        for placement in drawn(&grid, &item, &mut proposer, STEPS).concat() {
            *counts.get_mut(&placement).unwrap() += 1;
        }
        let all = possible.len() as f64;
        let probability = share.of(all_count(&grid, &item)) as f64 / all;
        let expected = STEPS as f64 * probability;
        let found = statistic(counts.values().map(|count| (*count, expected)));
        // The counts of a step are zero or one, and their sum is given.
        let scale = (all - 1.0) / all / (1.0 - probability);
        assert_is_chance(found * scale, possible.len() - 1);
    }
}

#[test]
fn tries_draw_the_yaw_and_then_the_position() {
    const STEPS: u64 = 12_000;
    let (grid, item) = six_placements();
    let mut counts = BTreeMap::new();
    for tried in drawn(&grid, &item, &mut ProposeTries::new(1, 1, 3), STEPS) {
        assert_eq!(tried.len(), 1);
        *counts.entry(tried[0]).or_insert(0) += 1;
    }
    assert_eq!(counts.len(), 6);
    let expected = |at: &Placement| STEPS as f64 / if at.yaw == 0 { 4.0 } else { 8.0 };
    let found = statistic(counts.iter().map(|(at, count)| (*count, expected(at))));
    assert_is_chance(found, 5);
    // Each of three yaws keeps for its three positions.
    for tried in drawn(&grid, &item, &mut ProposeTries::new(3, 3, 3), 100) {
        assert_eq!(tried.len(), 9);
        for positions in tried.chunks(3) {
            assert!(positions.iter().all(|at| at.yaw == positions[0].yaw));
        }
    }
}

#[test]
fn a_yaw_that_does_not_fit_loses_its_tries() {
    let (grid, _) = six_placements();
    let item = item(vec![block(2, 3), block(3, 2)]);
    for tried in drawn(&grid, &item, &mut ProposeTries::new(3, 3, 5), 100) {
        assert!(tried.len() <= 9 && tried.len().is_multiple_of(3));
        let only = Placement { yaw: 1, x: 0, y: 0 };
        assert!(tried.iter().all(|at| *at == only));
    }
}

#[test]
fn a_step_is_widened_unless_nothing_else_may_be_placed() {
    let grid = Grid::reference();
    let mut heights = vec![grid.rim(); grid.nx() * grid.ny()];
    let hole = (11, 17);
    for (x, y) in (0..4).flat_map(|x| (0..4).map(move |y| (hole.0 + x, hole.1 + y))) {
        heights[x * grid.ny() + y] = 0;
    }
    let heightmap = Heightmap::from_units(grid.nx(), grid.ny(), heights).unwrap();
    let scene = Scene::from_heightmap(heightmap);
    let held = [Candidate::new(0, item(vec![block(4, 4); 4]))];
    let share = ProposeRandom::new(Percent::new(10.0).unwrap(), 1);
    let tries = ProposeTries::new(200, 3, 1);
    let share: [Box<dyn Proposer>; 2] = [Box::new(share.clone()), Box::new(share)];
    let tries: [Box<dyn Proposer>; 2] = [Box::new(tries.clone()), Box::new(tries)];
    for ([mut proposer, same], may_be_widened) in [(share, true), (tries, false)] {
        let settings = SearchSettings {
            heuristic: Heuristic::Random,
            order: Order::Shuffled,
            ..SearchSettings::default()
        };
        let search = Box::new(Search::new(&grid, &settings).unwrap());
        let mut planner = Planner::new(same, search, Vec::new(), Order::Shuffled, 0);
        let mut were_proposed = 0;
        for step in 0..40 {
            let input = StepInput {
                step,
                ..StepInput::new(&grid, &scene, &held)
            };
            let mut proposals = Proposals::default();
            proposer.propose(&input, &mut proposals).unwrap();
            let mut proposed = named(&proposals).into_iter();
            let is_proposed = proposed.any(|at| (at.x, at.y) == hole);
            were_proposed += usize::from(is_proposed);
            let plan = planner.plan(&input).unwrap();
            assert_eq!(plan.is_widened(), may_be_widened && !is_proposed);
            assert_eq!(plan.choice().is_some(), may_be_widened || is_proposed);
            if let Some(choice) = plan.choice() {
                let at = choice.resting.placement;
                assert_eq!((at.x, at.y), hole);
            } else {
                assert_eq!(plan.candidates()[0].reason, Some(Reason::NoneTried));
            }
        }
        assert!((1..40).contains(&were_proposed), "{were_proposed}");
    }
}

proptest! {
    #[test]
    fn the_share_is_drawn_from_the_possible_placements(
        (grid, _, items) in support::scenes(1),
        percent in 0.1_f64..100.0,
        seed in any::<u64>(),
    ) {
        let share = Percent::new(percent).unwrap();
        let mut proposer = ProposeRandom::new(share, seed);
        let found = drawn(&grid, &items[0], &mut proposer, 1).remove(0);
        let possible: Vec<Placement> = support::possible_placements(&grid, &items[0]).collect();
        let wanted = share.of(all_count(&grid, &items[0])) as usize;
        prop_assert_eq!(found.len(), wanted.min(possible.len()));
        prop_assert!(found.is_sorted_by(|one, other| one < other));
        prop_assert!(found.iter().all(|at| possible.contains(at)));
    }
}
