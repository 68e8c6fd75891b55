//! Candidates that a check rules out are left out of the step, and nothing else changes. What is refused is counted.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::sync::Arc;

use ppnpack_packing::check::{BoxedCheck, Cost, ValidityCheck, Verdict};
use ppnpack_packing::episode::{IdealCell, Play, play};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::objective::Order;
use ppnpack_packing::placement::RestingPlacement;
use ppnpack_packing::plan::{Plan, Planner, Reason};
use ppnpack_packing::proposals::{ProposeAll, Proposer};
use ppnpack_packing::refusal::{Cause, Refusal};
use ppnpack_packing::search::{Search, SearchSettings};
use ppnpack_packing::stability::PublishedStability;
use ppnpack_packing::step::{Candidate, StageError, StepInput};
use proptest::prelude::*;

mod support;

use support::ProposeCorner;

/// Rules candidates out by their arrival, and refuses placements at the wall.
struct Picky(Vec<bool>);

impl ValidityCheck for Picky {
    fn cost(&self) -> Cost {
        Cost::Motion
    }

    fn rules_out(
        &mut self,
        _: &StepInput<'_>,
        held: &Candidate,
    ) -> Result<Option<Refusal>, StageError> {
        Ok(self.0[held.arrival].then(|| Cause::Arm.into()))
    }

    fn judge(
        &mut self,
        _: &StepInput<'_>,
        held: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<Verdict, StageError> {
        assert!(!self.0[held.arrival], "it was ruled out");
        Ok(Verdict::of(resting.placement.x > 0, Cause::Arm))
    }
}

fn planner(
    grid: &Grid,
    proposer: Box<dyn Proposer>,
    order: Order,
    ruled_out: Vec<bool>,
) -> Planner {
    let settings = SearchSettings {
        order,
        ..SearchSettings::default()
    };
    let search = Search::new(grid, &settings).unwrap();
    let checks: Vec<BoxedCheck> = vec![
        Box::new(Picky(ruled_out)),
        Box::new(PublishedStability::default()),
    ];
    Planner::new(proposer, Box::new(search), checks, order, 1)
}

/// The chosen placements, each with the arrival of its candidate.
fn chosen(plan: &Plan, held: &[Candidate]) -> Vec<(usize, RestingPlacement, f64)> {
    let placements = plan.choice().into_iter();
    let placements = placements.chain(plan.alternatives().copied());
    placements
        .map(|found| (held[found.candidate].arrival, found.resting, found.value))
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn planning_without_those_that_are_ruled_out_is_the_same_plan(
        (grid, heightmap, items) in support::scenes(4),
        ruled_out in proptest::collection::vec(any::<bool>(), 4),
        order in proptest::sample::select(&[Order::Balance, Order::BboxVolume, Order::Arrival][..]),
    ) {
        let scene = Scene::from_heightmap(heightmap);
        let candidate = |(arrival, item): (usize, &_)| Candidate::new(arrival, std::sync::Arc::clone(item));
        let held: Vec<Candidate> = items.iter().enumerate().map(candidate).collect();
        let others: Vec<Candidate> = held.iter().filter(|held| !ruled_out[held.arrival]).cloned().collect();
        let input = StepInput { step: 3, alternatives: 2, ..StepInput::new(&grid, &scene, &held) };
        let without = StepInput { candidates: &others, ..input };
        let mut of_all = planner(&grid, Box::new(ProposeAll), order, ruled_out.clone());
        let mut of_others = planner(&grid, Box::new(ProposeAll), order, ruled_out.clone());
        let (plan, expected) = (of_all.plan(&input).unwrap(), of_others.plan(&without).unwrap());
        prop_assert_eq!(chosen(plan, &held), chosen(expected, &others));
        let mut reports = expected.candidates().iter();
        for (index, candidate) in held.iter().enumerate() {
            if ruled_out[candidate.arrival] {
                let report = &plan.candidates()[index];
                let reason = Some(Reason::Rejected(Cause::Arm.into()));
                prop_assert_eq!(&report.reason, &reason);
                prop_assert_eq!(report.refusals.total(), 0);
            } else {
                prop_assert_eq!(Some(&plan.candidates()[index]), reports.next());
            }
        }
    }
}

#[test]
fn the_refusals_of_a_widened_step_are_those_of_both_searches() {
    let grid = Grid::reference();
    let view = ViewSurfaces::of_cells(4, 4, vec![20; 16], vec![0; 16]);
    let item = Arc::new(Item::new("cube", vec![view; 4], 0.0).unwrap());
    let held = Candidate::sequence([item.clone(), item]);
    let ruled_out = vec![false, true];
    let mut planner = planner(&grid, Box::new(ProposeCorner), Order::Balance, ruled_out);
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    // The second candidate is ruled out, which makes no difference.
    for held in [&held[..1], &held[..]] {
        let plan = planner.plan(&StepInput::new(&grid, &scene, held)).unwrap();
        assert!(plan.is_widened() && plan.choice().is_some());
        let of_second_search = plan
            .candidates()
            .iter()
            .map(|report| report.refusals.total());
        let of_second_search: u64 = of_second_search.sum();
        assert!(of_second_search > 0);
        assert_eq!(plan.refusals().total(), 1 + of_second_search);
    }
    let (mut cell, how) = (IdealCell::new(&grid), Play::with_buffer(2));
    let episode = play(&grid, &mut planner, &mut cell, held, how, &mut ()).unwrap();
    assert_eq!(episode.steps.len(), 1, "{:?}", episode.ending);
    assert_eq!(episode.steps[0].refusals, episode.refusals);
    assert!(episode.refusals.total() > 1);
}
