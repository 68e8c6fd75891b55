//! What cannot be is never accepted: it fails by the name of the invariant that it breaks.

use ppnpack_packing::checks::check::Fits;
use ppnpack_packing::checks::loads::{BalanceCheck, LoadCheck};
use ppnpack_packing::checks::rules::{OnFloor, Upright};
use ppnpack_packing::checks::sequence::Sequence;
use ppnpack_packing::checks::stability::PhysicalStability;
use ppnpack_packing::planning::valid::ValidSearch;
use ppnpack_packing::streams::episode::{IdealCell, PackingCell};

use crate::support::*;

#[test]
fn a_placement_at_a_yaw_that_its_item_lacks_fails_every_check_and_is_not_made() {
    let grid = small_grid();
    let (scene, held) = (empty(&grid), blocks(1));
    let input = StepInput::new(&grid, &scene, &held);
    let mut at = resting([0, 0], 0);
    at.placement.yaw = 1;
    let is_named = |error: StageError| {
        let error = error.to_string();
        error.contains("\"a placement's yaw is one of its item's\": block has 1 yaws, not yaw 1")
    };
    let checks: [BoxedCheck; 8] = [
        Box::new(Fits),
        Box::new(OnFloor),
        Box::new(Upright::default()),
        Box::new(PublishedStability::default()),
        Box::new(PhysicalStability::new(Default::default())),
        Box::new(Sequence),
        Box::new(LoadCheck::new(1.0)),
        Box::new(BalanceCheck::new(1.0)),
    ];
    for mut check in checks {
        check.begin(&input).unwrap();
        assert!(is_named(check.judge(&input, &held[0], &at).unwrap_err()));
    }
    let mut cell = IdealCell::new(&grid);
    let placed = cell.place(&held[0], &at, &Evidence::default());
    assert!(is_named(placed.unwrap_err()) && !cell.is_inside(0));
}

/// Ranks a candidate that no step has.
struct Stranger;

impl Evaluator for Stranger {
    fn rank(&mut self, _: &StepInput<'_>, _: &[usize], _: &Proposals) -> StageResult {
        Ok(())
    }

    fn next_best(&mut self, _: &StepInput<'_>) -> StageResult<Option<Evaluated>> {
        Ok(Some(Evaluated {
            candidate: 7,
            resting: resting([0, 0], 0),
            value: 0.0,
        }))
    }

    fn counts(&self, _: usize) -> PlacementCounts {
        PlacementCounts::default()
    }
}

#[test]
fn a_ranked_candidate_that_the_step_does_not_have_fails_the_search() {
    let grid = small_grid();
    let (scene, held) = (empty(&grid), blocks(1));
    let input = StepInput::new(&grid, &scene, &held);
    let some: Vec<BoxedCheck> = vec![Box::new(OnFloor), Box::new(Fits)];
    for checks in [Vec::new(), some] {
        let mut search = ValidSearch::new(Box::new(Stranger), checks);
        search.begin(&input).unwrap();
        search.rank(&input, &[0], &all(&input)).unwrap();
        let error = search.next_valid(&input).unwrap_err().to_string();
        assert!(error.contains("is a candidate of the step\": there is no number 7"));
    }
}

#[test]
fn an_item_of_unknown_mass_is_left_out_of_loads_and_balance_and_the_evidence_says_so() {
    let grid = Grid::reference();
    let glass = Model {
        carries_kg: Some(0.0),
        ..cuboid("glass", [0.1; 3], 0.2)
    };
    let scene = empty(&grid).with_content(vec![lies(glass, [0.1, 0.1, 0.0])].into());
    let held = [Candidate::new(0, block(&grid, [4, 4], 10))];
    let input = StepInput::new(&grid, &scene, &held);
    let at = resting([12, 12], 50);
    let checks: [BoxedCheck; 2] = [
        Box::new(LoadCheck::new(1.0)),
        Box::new(BalanceCheck::new(1e-9)),
    ];
    for mut check in checks {
        check.begin(&input).unwrap();
        let verdict = check.judge(&input, &held[0], &at).unwrap();
        let Verdict::Accepted(evidence) = verdict else {
            panic!("nobody knows that it is too heavy");
        };
        assert!(evidence.degraded[0].contains("mass is not known"));
    }
}
