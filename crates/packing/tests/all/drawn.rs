//! Proposals: those drawn at random, and the exhaustive search in place of those that fail.

use std::collections::BTreeMap;

use ppnpack_packing::ranking::proposals::{OrExhaustive, ProposeTries};

use crate::support::*;

fn item(cells: &[[usize; 2]]) -> Arc<Item> {
    let views = cells.iter().map(|cells| block_view(*cells, 10));
    Arc::new(Item::new("block", views.collect(), 0.0).unwrap())
}

/// A container in which an item has two placements at one yaw and four at the other.
fn six_placements() -> (Grid, Arc<Item>) {
    (grid_of([3, 2], 0.01, 50, 2), item(&[[2, 2], [2, 1]]))
}

/// What is proposed for an item in so many steps.
fn drawn(
    grid: &Grid,
    item: &Arc<Item>,
    proposer: &mut dyn Proposer,
    steps: u64,
) -> Vec<Vec<Placement>> {
    let scene = empty(grid);
    let held = Candidate::sequence([Arc::clone(item)]);
    let mut proposals = Proposals::default();
    let mut of_step = |step| {
        let input = StepInput {
            step,
            ..StepInput::new(grid, &scene, &held)
        };
        proposer.propose(&input, &mut proposals).unwrap();
        match proposals.of(0) {
            CandidateProposals::Some(placements) => placements.to_vec(),
            CandidateProposals::All => panic!("not named one by one"),
        }
    };
    (0..steps).map(&mut of_step).collect()
}

/// Asserts that what was counted is chance: that Pearson's statistic, times a scale, lies between
/// the first and the last thousandth of a chi-square's values (Wilson and Hilferty).
fn assert_is_chance(counts: impl Iterator<Item = (usize, f64)>, scale: f64) {
    let terms = counts.map(|(count, expected)| (count as f64 - expected).powi(2) / expected);
    let terms: Vec<f64> = terms.collect();
    let statistic = scale * terms.iter().sum::<f64>();
    let freedom = terms.len() as f64 - 1.0;
    let spread = 2.0 / (9.0 * freedom);
    let [least, most] = [-3.09, 3.09]
        .map(|quantile: f64| freedom * (1.0 - spread + quantile * spread.sqrt()).powi(3));
    assert!(
        (least..most).contains(&statistic),
        "{statistic} of {freedom} degrees of freedom, where {least} to {most} is chance"
    );
}

/// All subsets of some size.
fn subsets(of: &[Placement], size: u32) -> Vec<Vec<Placement>> {
    let masks = (0_u32..1 << of.len()).filter(|mask| mask.count_ones() == size);
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
    let possible: Vec<Placement> = possible_placements(&grid, &item).collect();
    assert_eq!(possible.len(), 6);
    // Of twelve placements, some outside; few are drawn, or of many those that are left out.
    for (percent, size) in [(8.0, 1), (16.0, 2), (25.0, 3), (33.0, 4), (41.0, 5)] {
        let mut proposer = ProposeRandom::new(Percent::new(percent).unwrap(), 7);
        let all = subsets(&possible, size).into_iter();
        let mut counts: BTreeMap<Vec<Placement>, usize> = all.map(|subset| (subset, 0)).collect();
        for subset in drawn(&grid, &item, &mut proposer, STEPS) {
            *counts.get_mut(&subset).unwrap() += 1;
        }
        let expected = STEPS as f64 / counts.len() as f64;
        assert_is_chance(counts.values().map(|count| (*count, expected)), 1.0);
    }
}

#[test]
fn of_a_whole_container_every_placement_is_equally_likely() {
    const STEPS: u64 = 1_000;
    let grid = Grid::reference();
    let item = item(&[[5, 7], [8, 8], [7, 5], [9, 3]]);
    let possible: Vec<Placement> = possible_placements(&grid, &item).collect();
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
        // The counts of a step are zero or one, and their sum is given.
        let scale = (all - 1.0) / all / (1.0 - probability);
        assert_is_chance(counts.values().map(|count| (*count, expected)), scale);
    }
}

#[test]
fn tries_draw_the_yaw_and_then_the_position() {
    const STEPS: u64 = 12_000;
    let (grid, block) = six_placements();
    let mut counts = BTreeMap::new();
    for tried in drawn(&grid, &block, &mut ProposeTries::new(1, 1, 3), STEPS) {
        assert_eq!(tried.len(), 1);
        *counts.entry(tried[0]).or_insert(0) += 1;
    }
    assert_eq!(counts.len(), 6);
    let expected = |at: &Placement| STEPS as f64 / if at.yaw == 0 { 4.0 } else { 8.0 };
    assert_is_chance(counts.iter().map(|(at, count)| (*count, expected(at))), 1.0);
    // Each of three yaws keeps for its three positions.
    for tried in drawn(&grid, &block, &mut ProposeTries::new(3, 3, 3), 100) {
        assert_eq!(tried.len(), 9);
        for positions in tried.chunks(3) {
            assert!(positions.iter().all(|at| at.yaw == positions[0].yaw));
        }
    }
    // A yaw that does not fit loses its tries.
    let narrow = item(&[[2, 3], [3, 2]]);
    for tried in drawn(&grid, &narrow, &mut ProposeTries::new(3, 3, 5), 100) {
        assert!(tried.len() <= 9 && tried.len().is_multiple_of(3));
        let only = Placement { yaw: 1, x: 0, y: 0 };
        assert!(tried.iter().all(|at| *at == only));
    }
}

#[test]
fn a_step_is_widened_unless_nothing_else_may_be_placed() {
    let grid = Grid::reference();
    let hole = (11, 17);
    let is_hole = |x, y| (hole.0..hole.0 + 4).contains(&x) && (hole.1..hole.1 + 4).contains(&y);
    let cells = (0..grid.nx()).flat_map(|x| (0..grid.ny()).map(move |y| (x, y)));
    let heights = cells.map(|(x, y)| if is_hole(x, y) { 0 } else { grid.rim() });
    let heightmap = Heightmap::from_units(grid.nx(), grid.ny(), heights.collect()).unwrap();
    let scene = Scene::from_heightmap(heightmap);
    let block = item(&[[4, 4]; 4]);
    let held = Candidate::sequence([Arc::clone(&block)]);
    let share = || Box::new(ProposeRandom::new(Percent::new(10.0).unwrap(), 1));
    let tries = || Box::new(ProposeTries::new(200, 3, 1));
    let pairs: [([Box<dyn Proposer>; 2], bool); 2] =
        [([share(), share()], true), ([tries(), tries()], false)];
    for ([mut proposer, same], may_be_widened) in pairs {
        let search = searching(&grid, Heuristic::Random, Order::Shuffled, false);
        let mut planner = Planner::new(same, Box::new(search), Vec::new(), Order::Shuffled, 0);
        let mut were_proposed = 0;
        for (step, proposed) in drawn(&grid, &block, &mut *proposer, 40).iter().enumerate() {
            let input = StepInput {
                step: step as u64,
                ..StepInput::new(&grid, &scene, &held)
            };
            let is_proposed = proposed.iter().any(|at| (at.x, at.y) == hole);
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

/// Fails every second time.
struct Unsteady(u32);

impl Proposer for Unsteady {
    fn propose(&mut self, input: &StepInput<'_>, proposals: &mut Proposals) -> StageResult {
        self.0 += 1;
        proposals.clear();
        if self.0.is_multiple_of(2) {
            return Err("out of order".into());
        }
        input.candidates.iter().for_each(|_| proposals.push([]));
        Ok(())
    }
}

#[test]
fn a_failing_proposer_gives_way_to_the_exhaustive_search_and_the_reason_is_kept() {
    let grid = small_grid();
    let (scene, candidates) = (empty(&grid), blocks(1));
    let input = StepInput::new(&grid, &scene, &candidates);
    let mut proposals = Proposals::default();
    let mut proposer = OrExhaustive::new(Box::new(Unsteady(0)));
    for expected in [None, Some("out of order"), None, Some("out of order")] {
        proposer.propose(&input, &mut proposals).unwrap();
        assert_eq!(proposals.degraded(), expected);
        let is_all = proposals.of(0) == CandidateProposals::All;
        assert_eq!(is_all, expected.is_some());
    }
    let mut absent = OrExhaustive::instead("no weights");
    absent.propose(&input, &mut proposals).unwrap();
    assert_eq!(proposals.degraded(), Some("no weights"));
    assert_eq!(proposals.of(0), CandidateProposals::All);
}

#[test]
fn shares_outside_0_to_100_are_refused() {
    for percent in [0.0, -1.0, 100.1, f64::NAN] {
        assert!(Percent::new(percent).is_err(), "{percent}");
    }
    assert_eq!(Percent::new(5.0).unwrap().of(1001), 51);
}

proptest! {
    #[test]
    fn the_share_is_drawn_from_the_possible_placements(
        (grid, _, items) in scenes(1),
        percent in 0.1_f64..100.0,
        seed in any::<u64>(),
    ) {
        let share = Percent::new(percent).unwrap();
        let mut proposer = ProposeRandom::new(share, seed);
        let found = drawn(&grid, &items[0], &mut proposer, 1).remove(0);
        let possible: Vec<Placement> = possible_placements(&grid, &items[0]).collect();
        let wanted = share.of(all_count(&grid, &items[0])) as usize;
        prop_assert_eq!(found.len(), wanted.min(possible.len()));
        prop_assert!(found.is_sorted_by(|one, other| one < other));
        prop_assert!(found.iter().all(|at| possible.contains(at)));
    }
}
