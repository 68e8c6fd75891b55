//! What a check refuses by what it found out about other placements is not looked into by the checks before it.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use ppnpack_packing::check::{BoxedCheck, Cost, Evidence, ValidityCheck, Verdict};
use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::objective::Order;
use ppnpack_packing::placement::{Placement, RestingPlacement};
use ppnpack_packing::plan::{CandidateReport, Planner};
use ppnpack_packing::proposals::ProposeAll;
use ppnpack_packing::refusal::{Cause, Refusal};
use ppnpack_packing::search::{Search, SearchSettings};
use ppnpack_packing::step::{Candidate, StageResult, StepInput};

/// The block may be at so many places along each side of the container.
const SIDE: usize = 13;

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
    let resolution = Resolution::new(0.01, 0.002, Yaws::half_turn(1).unwrap());
    let container = ContainerSize {
        x_m: 0.16,
        y_m: 0.16,
        z_m: 0.1,
    };
    let grid = Grid::new(container, resolution.unwrap()).unwrap();
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let view = ViewSurfaces::of_cells(4, 4, vec![10; 16], vec![0; 16]);
    let block = Arc::new(Item::new("block", vec![view], 0.0).unwrap());
    let candidates = [Candidate::new(0, block)];
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
    assert_eq!(asked, SIDE * SIDE);
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
