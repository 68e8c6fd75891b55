//! The expert's labels against a look at every placement.

use ppnpack_dataset::{CandidateRecord, StepRecord, VALUE_STEP};
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::kernel::objective::{Heuristic, Weights};
use ppnpack_packing::planning::survey::{Surveyed, survey};

use crate::support::{grid, items, played, record, settings};

/// What is valid at a yaw, by x, then y.
fn valid(step: &StepRecord, item: &Item, yaw: usize) -> Vec<Surveyed> {
    let grid = grid();
    let heightmap = Heightmap::from_units(grid.nx(), grid.ny(), step.heightmap.clone()).unwrap();
    let (view, weights) = (&item.views()[yaw], Weights::default());
    let all = survey(&grid, &heightmap, view, Heuristic::Sdfm, &weights).unwrap();
    let valid = all.into_iter().filter(|at| at.fits && at.is_stable);
    valid.collect()
}

fn check_optima(step: &StepRecord, candidate: &CandidateRecord) {
    let item = &items()[candidate.object as usize];
    for (yaw, optima) in candidate.yaws.iter().enumerate() {
        let valid = valid(step, item, yaw);
        let values = valid.iter().map(|at| at.value);
        let least = values.fold(f64::INFINITY, f64::min);
        assert_eq!(optima.value, least);
        let ties = valid.iter().filter(|at| at.value <= least + 1e-9);
        let ties = ties.map(|at| (at.x as u16, at.y as u16));
        let found = optima.placements.iter().map(|corner| (corner.x, corner.y));
        assert!(found.eq(ties));
    }
}

fn check_values(step: &StepRecord, candidate: &CandidateRecord) {
    let item = &items()[candidate.object as usize];
    let values = candidate.values.as_ref().unwrap();
    assert_eq!(values.best(), candidate.best_value());
    for (yaw, kept) in values.yaws().iter().enumerate() {
        let valid = valid(step, item, yaw);
        for placement in &valid {
            let value = f64::from(values.get(yaw, placement.x, placement.y));
            assert!((value - placement.value).abs() <= VALUE_STEP / 2.0 + 1e-5);
        }
        let finite = kept.all_above_best().filter(|above| above.is_finite());
        assert_eq!(finite.count(), valid.len());
    }
}

#[test]
fn optima_and_values_are_those_of_every_placement_looked_at() {
    let settings = settings(true);
    let (mut candidates, mut without) = (0, 0);
    for sequence in 0..4 {
        for step in record(&settings, sequence).steps {
            for candidate in &step.candidates {
                check_optima(&step, candidate);
                check_values(&step, candidate);
                candidates += 1;
                without += usize::from(candidate.best().next().is_none());
            }
        }
    }
    assert!(candidates > 20, "{candidates}");
    assert!(without > 0, "some candidate has no valid placement");
}

#[test]
fn optima_do_not_depend_on_whether_values_are_kept() {
    let [with, without] = [true, false].map(|has_values| record(&settings(has_values), 1).steps);
    for (with, without) in with.iter().zip(&without) {
        for (with, without) in with.candidates.iter().zip(&without.candidates) {
            assert_eq!(with.yaws, without.yaws);
            assert!(with.values.is_some() && without.values.is_none());
        }
    }
}

#[test]
fn the_planner_chooses_a_best_placement_of_the_best_candidate() {
    let settings = settings(false);
    for sequence in 0..4 {
        let (record, choices) = played(&settings, sequence);
        assert_eq!(record.steps.len(), choices.len());
        for (step, choice) in record.steps.iter().zip(choices) {
            let chosen = &step.candidates[choice.candidate];
            let mut best = chosen.best();
            assert!(best.any(|placement| placement == choice.resting.placement));
            let values = step.candidates.iter().map(CandidateRecord::best_value);
            assert_eq!(choice.value, values.fold(f64::INFINITY, f64::min));
        }
    }
}
