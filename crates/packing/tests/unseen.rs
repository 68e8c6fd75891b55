//! What a check refuses by what it found out about other placements is not looked into by the checks before it.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use ppnpack_packing::check::{BoxedCheck, Cost, Evidence, ValidityCheck, Verdict};
use ppnpack_packing::objective::Order;
use ppnpack_packing::placement::{Placement, RestingPlacement};
use ppnpack_packing::plan::{CandidateReport, Planner};
use ppnpack_packing::proposals::ProposeAll;
use ppnpack_packing::refusal::{Cause, Refusal};
use ppnpack_packing::search::{Search, SearchSettings};
use ppnpack_packing::step::{Candidate, StageResult, StepInput};

mod support;

use support::blocks::{PLACES, SIDE, blocks, empty, grid};

/// Accepts everything, and counts how often it is asked.
struct Arm(Arc<AtomicUsize>);

impl ValidityCheck for Arm {
    fn cost(&self) -> Cost {
        Cost::Motion
    }

    fn judge(
        &mut self,
        _: &StepInput<'_>,
        _: &Candidate,
        _: &RestingPlacement,
    ) -> StageResult<Verdict> {
        self.0.fetch_add(1, Ordering::Relaxed);
        Ok(Verdict::Accepted(Evidence::default()))
    }
}

/// Refuses all placements but one, and knows that one refused placement stands for all of its row.
struct Trial {
    foresight: usize,
    says_so: bool,
    refused_rows: Vec<usize>,
}

const ACCEPTED: Placement = Placement { yaw: 0, x: 7, y: 5 };

fn why() -> Refusal {
    Cause::Unsteady.into()
}

impl ValidityCheck for Trial {
    fn cost(&self) -> Cost {
        Cost::Simulation
    }

    fn begin(&mut self, _: &StepInput<'_>) -> StageResult {
        self.refused_rows.clear();
        Ok(())
    }

    fn refuses_unseen(
        &self,
        _: &StepInput<'_>,
        _: &Candidate,
        at: &RestingPlacement,
    ) -> Option<Refusal> {
        (self.says_so && self.refused_rows.contains(&at.placement.y)).then(why)
    }

    fn judge(
        &mut self,
        _: &StepInput<'_>,
        _: &Candidate,
        at: &RestingPlacement,
    ) -> StageResult<Verdict> {
        if at.placement == ACCEPTED {
            return Ok(Verdict::Accepted(Evidence::default()));
        }
        if at.placement.y != ACCEPTED.y {
            self.refused_rows.push(at.placement.y);
        }
        Ok(Verdict::Refused(why()))
    }

    fn foresight(&self) -> usize {
        self.foresight
    }
}

/// What a step chooses and says of its only item, and how often the arm was asked for that.
fn step(foresight: usize, says_so: bool) -> (Option<Placement>, CandidateReport, usize) {
    let grid = grid();
    let scene = empty(&grid);
    let candidates = blocks(1);
    let input = StepInput {
        // So that the step goes on to the last placement.
        alternatives: 1,
        ..StepInput::new(&grid, &scene, &candidates)
    };
    let asked = Arc::new(AtomicUsize::new(0));
    let trial = Trial {
        foresight,
        says_so,
        refused_rows: Vec::new(),
    };
    let checks: Vec<BoxedCheck> = vec![Box::new(trial), Box::new(Arm(Arc::clone(&asked)))];
    let search = Search::new(&grid, &SearchSettings::default()).unwrap();
    let order = Order::Arrival;
    let mut planner = Planner::new(Box::new(ProposeAll), Box::new(search), checks, order, 1);
    let plan = planner.plan(&input).unwrap();
    let choice = plan.choice().map(|choice| choice.resting.placement);
    let report = plan.candidates()[0].clone();
    (choice, report, asked.load(Ordering::Relaxed))
}

#[test]
fn what_is_refused_unseen_is_not_asked_of_the_arm_and_counts_as_refused() {
    let (choice, report, asked) = step(1, false);
    assert_eq!(choice, Some(ACCEPTED));
    assert_eq!(asked, PLACES);
    for foresight in [1, 4] {
        let (other_choice, other_report, other_asked) = step(foresight, true);
        assert_eq!(other_choice, choice);
        assert_eq!(other_report.refusals, report.refusals);
        // The first of each other row, as many more as are looked at ahead, and the row of the one that is accepted.
        let most = (SIDE - 1) * foresight + SIDE;
        assert!(
            (2 * SIDE - 1..=most).contains(&other_asked),
            "{other_asked}"
        );
    }
}
