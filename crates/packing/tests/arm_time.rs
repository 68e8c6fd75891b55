//! The arm's time in the choice of a placement.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

mod support;

use std::sync::Arc;

use nalgebra::Isometry3;
use ppnpack_packing::arm_time::{ArmTime, ArmTimeError, TimeCost};
use ppnpack_packing::candidate::Candidate;
use ppnpack_packing::check::{BoxedCheck, Cost, Evidence, ValidityCheck, Verdict};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::motion::Cycle;
use ppnpack_packing::objective::Order;
use ppnpack_packing::placement::RestingPlacement;
use ppnpack_packing::plan::{Planner, StepInput};
use ppnpack_packing::proposals::ProposeAll;
use ppnpack_packing::search::{Search, SearchSettings};
use ppnpack_packing::step::StageResult;
use proptest::prelude::*;

/// An arm that takes longer to some places than to others.
struct Arm;

impl ValidityCheck for Arm {
    fn cost(&self) -> Cost {
        Cost::Motion
    }

    fn judge(
        &mut self,
        _: &StepInput<'_>,
        _: &Candidate,
        at: &RestingPlacement,
    ) -> StageResult<Verdict> {
        let cycle = Cycle {
            arm: "arm".to_owned(),
            cycle_s: cycle_s(at),
            container_from_item_at_pick: Isometry3::identity(),
            grasp_yaw_rad: 0.0,
            grip_s: 0.0,
            release_s: 0.0,
            legs: Vec::new(),
        };
        Ok(Verdict::Accepted(Evidence {
            cycle: Some(Arc::new(cycle)),
            ..Evidence::default()
        }))
    }
}

fn cycle_s(at: &RestingPlacement) -> f64 {
    let number = at.placement.x * 31 + at.placement.y * 17 + at.placement.yaw * 7;
    1.0 + (number % 11) as f64 * 0.1
}

fn planner(grid: &Grid, time_cost: TimeCost) -> Planner {
    let search = Search::new(grid, &SearchSettings::default()).unwrap();
    let checks: Vec<BoxedCheck> = vec![Box::new(Arm)];
    let planner = Planner::new(
        Box::new(ProposeAll),
        Box::new(search),
        checks,
        Order::Balance,
        0,
    );
    planner.with_time_cost(time_cost)
}

proptest! {
    #[test]
    fn the_choice_is_that_of_the_least_value_and_time_among_the_best(
        (grid, heightmap, items) in support::scenes(3),
        value_per_s in prop_oneof![Just(0.0), 0.0..20.0_f64],
        among in 2_usize..8,
        alternatives in 0_usize..4,
    ) {
        let scene = Scene::from_heightmap(heightmap);
        let candidates = Candidate::sequence(items);
        let plan = |time_cost, alternatives| {
            let mut planner = planner(&grid, time_cost);
            let input = StepInput { alternatives, ..StepInput::new(&grid, &scene, &candidates) };
            let plan = planner.plan(&input).unwrap();
            plan.choice().into_iter().chain(plan.alternatives().copied()).collect::<Vec<_>>()
        };
        let found = plan(TimeCost { value_per_s, among }, alternatives);
        let mut expected = plan(TimeCost::default(), (among - 1).max(alternatives));
        if value_per_s > 0.0 {
            expected.sort_by(|a, b| {
                let cost = |at: &ppnpack_packing::step::Evaluated| at.value + value_per_s * cycle_s(&at.resting);
                cost(a).total_cmp(&cost(b))
            });
        }
        expected.truncate(alternatives + 1);
        prop_assert_eq!(found, expected);
    }
}

#[test]
fn a_second_is_worth_what_so_many_litres_are() {
    let time = ArmTime {
        litres_per_s: 0.01,
        among: 4,
    };
    assert_eq!(time.validate(30.0), Ok(()));
    let cost = time.cost(30.0);
    assert!((cost.value_per_s - 0.3).abs() < 1e-12 && cost.among == 4);
    assert_eq!(time.validate(0.0), Err(ArmTimeError::NoLitre));
    let off = ArmTime::default();
    assert!(!off.is_on() && !off.cost(30.0).is_on());
    assert_eq!(off.validate(0.0), Ok(()));
}
