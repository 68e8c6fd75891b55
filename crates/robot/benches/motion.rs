//! The arm's check of one placement, and a whole cycle with its trajectories.
#![allow(missing_docs, reason = "criterion's macros make undocumented items")]
#![allow(
    clippy::unwrap_used,
    reason = "a bench that cannot run should say so at once"
)]

#[path = "../tests/all/common/mod.rs"]
#[allow(
    dead_code,
    clippy::indexing_slicing,
    reason = "a measurement over the random placements of the tests, which have more than it uses"
)]
mod common;

use std::sync::Arc;

use common::scenes::{Case, case};
use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Isometry3, Point3};
use ppnpack_packing::ranking::step::StepInput;
use ppnpack_robot::arms;
use ppnpack_robot::cell::CellSettings;
use ppnpack_robot::cycle::CycleSettings;
use ppnpack_robot::feasibility::ArmCheck;
use ppnpack_robot::motion::{PlacePlanner, Placing};
use ppnpack_robot::trajectory::Trajectory;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

const CASES: usize = 256;

fn input(case: &Case) -> StepInput<'_> {
    StepInput::new(&case.grid, &case.scene, &[])
}

fn bench(criterion: &mut Criterion) {
    let arm = Arc::new(arms::arm("nachi-mz07l").unwrap());
    let mut planner = PlacePlanner::new(Arc::clone(&arm), CellSettings::default()).unwrap();
    let mut check = ArmCheck::new(planner.clone());
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let (mut accepted, mut refused) = (Vec::new(), Vec::new());
    while accepted.len() < CASES {
        let case = case(&mut random);
        let pick = check.pick(&case.candidate(), case.grid.resolution());
        if pick.is_err() {
            continue;
        }
        match check.plan(&input(&case), &case.candidate(), &case.resting) {
            Ok(_) => accepted.push(case),
            Err(_) => refused.push(case),
        }
    }
    for (name, cases) in [("check accepts", &accepted), ("check refuses", &refused)] {
        let mut next = cases.iter().cycle();
        criterion.bench_function(name, |bencher| {
            bencher.iter(|| {
                let case = next.next().unwrap();
                check.plan(&input(case), &case.candidate(), &case.resting)
            });
        });
    }

    let pose = Isometry3::translation(0.1, -0.35, 0.0);
    let picks = accepted.iter();
    let picks = picks.map(|case| check.pick(&case.candidate(), case.grid.resolution()));
    let picks: Vec<_> = picks.map(Result::unwrap).collect();
    let mut cycle_of = |at: usize| {
        let (case, pick) = (accepted.get(at).unwrap(), picks.get(at).unwrap());
        let placing = Placing {
            grid: &case.grid,
            scene: &case.scene,
            item: &case.item,
            resting: &case.resting,
            pick,
        };
        planner.plan_cycle(&placing, &pose, &CycleSettings::default())
    };
    let cycles: Vec<_> = (0..CASES).filter_map(|at| cycle_of(at).ok()).collect();
    let mut times_s: Vec<_> = cycles.iter().map(|cycle| cycle.cycle_s).collect();
    times_s.sort_by(f64::total_cmp);
    let median_s = times_s.get(times_s.len() / 2).copied();
    let possible = cycles.len();
    eprintln!("{possible} of {CASES} cycles possible, median {median_s:.2?} s");
    let mut at = 0;
    criterion.bench_function("plan a cycle", |bencher| {
        bencher.iter(|| {
            at = (at + 1) % CASES;
            cycle_of(at)
        });
    });
    let paths = cycles.iter().flat_map(|cycle| &cycle.legs);
    let paths: Vec<_> = paths.map(|(_, leg)| leg.path().clone()).collect();
    let mut next = paths.iter().cycle();
    criterion.bench_function("time a leg", |bencher| {
        bencher.iter(|| Trajectory::new(next.next().unwrap().clone(), arm.limits()));
    });
    criterion.bench_function("inverse kinematics", |bencher| {
        bencher.iter(|| arm.inverse(&Point3::new(0.2, 0.1, 0.2), 0.0));
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = bench
}
criterion_main!(benches);
