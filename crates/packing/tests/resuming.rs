//! A ranking goes on where it stopped: what was refused is looked at once, and what takes too long is cut.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use ppnpack_packing::check::{Cost, ValidityCheck, Verdict};
use ppnpack_packing::evaluator::Evaluator;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::objective::Order;
use ppnpack_packing::placement::RestingPlacement;
use ppnpack_packing::plan::Planner;
use ppnpack_packing::proposals::{Proposals, ProposeAll};
use ppnpack_packing::refusal::Cause;
use ppnpack_packing::search::{Search, SearchSettings};
use ppnpack_packing::step::{Candidate, Evaluated, PlacementCounts, StageError, StepInput};

/// What was asked of the stages.
#[derive(Debug, Default)]
struct Asked {
    rankings: AtomicU64,
    placements: AtomicU64,
    checks: AtomicU64,
}

/// Counts what is asked of a search.
struct Counting(Search, Arc<Asked>);

impl Evaluator for Counting {
    fn rank(
        &mut self,
        input: &StepInput<'_>,
        group: &[usize],
        proposals: &Proposals,
    ) -> Result<(), StageError> {
        self.1.rankings.fetch_add(1, Ordering::Relaxed);
        self.0.rank(input, group, proposals)
    }

    fn next_best(&mut self, input: &StepInput<'_>) -> Result<Option<Evaluated>, StageError> {
        self.1.placements.fetch_add(1, Ordering::Relaxed);
        self.0.next_best(input)
    }

    fn counts(&self, candidate: usize) -> PlacementCounts {
        self.0.counts(candidate)
    }
}

/// An arm that refuses the first placements that it is asked for, and takes its time for each.
struct Reluctant {
    refusals: u64,
    takes: Duration,
    asked: Arc<Asked>,
}

impl ValidityCheck for Reluctant {
    fn cost(&self) -> Cost {
        Cost::Motion
    }

    fn judge(
        &mut self,
        _: &StepInput<'_>,
        _: &Candidate,
        _: &RestingPlacement,
    ) -> Result<Verdict, StageError> {
        std::thread::sleep(self.takes);
        let before = self.asked.checks.fetch_add(1, Ordering::Relaxed);
        Ok(Verdict::of(before >= self.refusals, Cause::Arm))
    }
}

fn block() -> Arc<Item> {
    let view = ViewSurfaces::of_cells(5, 5, vec![20; 25], vec![0; 25]);
    Arc::new(Item::new("block", vec![view; 4], 0.0).unwrap())
}

fn planner(refusals: u64, takes: Duration) -> (Planner, Arc<Asked>) {
    let asked = Arc::new(Asked::default());
    let search = Search::new(&Grid::reference(), &SearchSettings::default()).unwrap();
    let check = Reluctant {
        refusals,
        takes,
        asked: Arc::clone(&asked),
    };
    let planner = Planner::new(
        Box::new(ProposeAll),
        Box::new(Counting(search.bounded(), Arc::clone(&asked))),
        vec![Box::new(check)],
        Order::Balance,
        0,
    );
    (planner, asked)
}

#[test]
fn a_placement_after_two_hundred_refusals_costs_one_ranking_and_each_placement_once() {
    let grid = Grid::reference();
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let candidates = Candidate::sequence([block(), block()]);
    let (mut planner, asked) = planner(200, Duration::ZERO);
    let plan = planner
        .plan(&StepInput::new(&grid, &scene, &candidates))
        .unwrap();
    assert!(plan.choice().is_some() && !plan.is_cut());
    let refused: u64 = plan.candidates().iter().map(|it| it.refusals.total()).sum();
    assert_eq!(refused, 200);
    for (count, expected) in [
        (&asked.rankings, 1),
        (&asked.placements, 201),
        (&asked.checks, 201),
    ] {
        assert_eq!(count.load(Ordering::Relaxed), expected);
    }
}

#[test]
fn after_the_deadline_nothing_more_is_checked_and_the_plan_says_so() {
    let grid = Grid::reference();
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let candidates = Candidate::sequence([block()]);
    let (mut planner, asked) = planner(u64::MAX, Duration::from_millis(5));
    let input = StepInput {
        deadline: Some(Instant::now() + Duration::from_millis(30)),
        ..StepInput::new(&grid, &scene, &candidates)
    };
    let plan = planner.plan(&input).unwrap();
    assert!(plan.is_cut());
    assert_eq!(plan.choice(), None);
    assert_eq!(
        plan.candidates()[0].reason,
        None,
        "not everything was tried"
    );
    assert!(plan.degraded()[0].contains("time limit"));
    assert!(asked.checks.load(Ordering::Relaxed) <= 7);
}
