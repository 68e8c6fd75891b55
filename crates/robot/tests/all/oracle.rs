//! The place motion against a brute-force oracle: nothing unsafe may be accepted.
use std::sync::Arc;

use crate::common::oracle::Oracle;
use crate::common::scenes::{arms, case};
use ppnpack_packing::ranking::step::StepInput;
use ppnpack_robot::cell::CellSettings;
use ppnpack_robot::feasibility::ArmCheck;
use ppnpack_robot::motion::PlacePlanner;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

#[test]
fn no_unsafe_placement_is_accepted_and_few_possible_ones_are_refused() {
    let [mut accepted, mut refused, mut lost] = [0; 3];
    for (seed, (name, arm)) in arms().into_iter().enumerate() {
        let arm = Arc::new(arm);
        let cell = CellSettings::default();
        let planner = PlacePlanner::new(Arc::clone(&arm), cell.clone()).unwrap();
        let mut check = ArmCheck::new(planner);
        let mut random = ChaCha8Rng::seed_from_u64(seed as u64);
        for number in 0..40 {
            let case = case(&mut random);
            let input = StepInput::new(&case.grid, &case.scene, &[]);
            let Ok(pick) = check.pick(&case.candidate(), case.grid.resolution()) else {
                continue;
            };
            let planned = check.plan(&input, &case.candidate(), &case.resting);
            let oracle = Oracle::new(&arm, &cell, &case, &pick);
            match planned {
                Ok(motion) => {
                    accepted += 1;
                    assert_eq!(oracle.check(&motion), Ok(()), "{name}, case {number}");
                }
                Err(_) => {
                    refused += 1;
                    lost += usize::from(oracle.is_possible());
                }
            }
        }
    }
    assert!(accepted > 60 && refused > 10, "{accepted} {refused}");
    assert!(5 * lost < accepted, "{lost} possible of {accepted}");
}
