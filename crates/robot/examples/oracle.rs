//! Places random items over random contents and asks the oracle about each: unsafe ones accepted, safe ones refused.
//!
//! `cargo run --release -p ppnpack-robot --example oracle -- PLACEMENTS [ARM [THREADS [WRIST_BEND]]]`; ARM counts
//! the arms from 0, WRIST_BEND is the least bend of the wrist in degrees. For times of the check use one thread.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "an experiment that cannot run should say so at once"
)]

#[path = "../tests/common/mod.rs"]
mod common;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use common::oracle::Oracle;
use common::scenes::{Case, arms, case};
use ppnpack_packing::step::StepInput;
use ppnpack_robot::arm::Arm;
use ppnpack_robot::cell::CellSettings;
use ppnpack_robot::feasibility::ArmCheck;
use ppnpack_robot::motion::{PlaceMotion, PlacePlanner};
use ppnpack_robot::refusal::Refusal;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// What became of some placements.
#[derive(Default)]
struct Report {
    accepted: Vec<Duration>,
    refused: Vec<Duration>,
    /// What accepted placements touch.
    unsafe_ones: Vec<String>,
    /// Placements that could be made, by the check or by the oracle.
    possible: usize,
    /// Refused placements by reason, and how many of them could be made.
    refusals: BTreeMap<String, (usize, usize)>,
}

impl Report {
    fn add(&mut self, other: Self) {
        self.accepted.extend(other.accepted);
        self.refused.extend(other.refused);
        self.unsafe_ones.extend(other.unsafe_ones);
        self.possible += other.possible;
        for (reason, (count, possible)) in other.refusals {
            let counts = self.refusals.entry(reason).or_default();
            counts.0 += count;
            counts.1 += possible;
        }
    }
}

fn run(arm: &Arc<Arm>, cell: &CellSettings, seed: u64, placements: usize) -> Report {
    let planner = PlacePlanner::new(Arc::clone(arm), cell.clone()).unwrap();
    let mut check = ArmCheck::new(planner);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut report = Report::default();
    while report.accepted.len() + report.refused.len() < placements {
        let case = case(&mut random);
        let input = StepInput::new(&case.grid, &case.scene, &[]);
        let Ok(pick) = check.pick(&case.item, case.grid.resolution()) else {
            continue;
        };
        let (planned, took) = timed(&check, &input, &case);
        let oracle = Oracle::new(arm, cell, &case, &pick);
        match planned {
            Ok(motion) => {
                report.accepted.push(took);
                match oracle.check(&motion) {
                    Ok(()) => report.possible += 1,
                    Err(touched) => report.unsafe_ones.push(touched),
                }
            }
            Err(refusal) => {
                report.refused.push(took);
                let was_possible = usize::from(oracle.is_possible());
                report.possible += was_possible;
                let mut text = refusal.to_string();
                text.retain(|letter| !letter.is_ascii_digit());
                let counts = report.refusals.entry(text).or_default();
                counts.0 += 1;
                counts.1 += was_possible;
            }
        }
    }
    report
}

/// What the check says, and the least time of three, each on its own copy: a machine that does other things too adds
/// milliseconds now and then.
fn timed(
    check: &ArmCheck,
    input: &StepInput<'_>,
    case: &Case,
) -> (Result<PlaceMotion, Refusal>, Duration) {
    let attempts = [(); 3].map(|()| {
        let mut check = check.clone();
        let start = Instant::now();
        let planned = check.plan(input, &case.item, &case.resting);
        (planned, start.elapsed())
    });
    attempts.into_iter().min_by_key(|(_, took)| *took).unwrap()
}

fn quantile(times: &mut [Duration], share: f64) -> Duration {
    times.sort_unstable();
    let at = ((times.len() as f64 - 1.0) * share).round() as usize;
    times.get(at).copied().unwrap_or_default()
}

fn main() {
    let arguments: Vec<usize> = std::env::args()
        .skip(1)
        .map(|text| text.parse().unwrap())
        .collect();
    let placements = arguments.first().copied().unwrap_or(1000);
    let threads = arguments.get(2).copied();
    let threads = threads.unwrap_or_else(|| std::thread::available_parallelism().unwrap().get());
    let mut cell = CellSettings::default();
    if let Some(bend_deg) = arguments.get(3) {
        cell.least_wrist_bend_deg = *bend_deg as f64;
    }
    for (index, (name, arm)) in arms().into_iter().enumerate() {
        if arguments.get(1).is_some_and(|wanted| *wanted != index) {
            continue;
        }
        let arm = Arc::new(arm);
        let mut report = Report::default();
        std::thread::scope(|scope| {
            let parts = (0..threads).map(|thread| {
                let (arm, cell) = (&arm, &cell);
                let seed = (1000 * (index + 1) + thread) as u64;
                scope.spawn(move || run(arm, cell, seed, placements.div_ceil(threads)))
            });
            for part in parts.collect::<Vec<_>>() {
                report.add(part.join().unwrap());
            }
        });
        let tried = report.accepted.len() + report.refused.len();
        println!(
            "{name}: {tried} placements that can be held, {} accepted",
            report.accepted.len()
        );
        println!(
            "  unsafe ones accepted: {} {:?}",
            report.unsafe_ones.len(),
            report.unsafe_ones
        );
        let lost: usize = report.refusals.values().map(|(_, possible)| possible).sum();
        println!(
            "  possible ones refused: {lost} of {} ({:.1} %)",
            report.possible,
            100.0 * lost as f64 / report.possible as f64
        );
        for (reason, (count, possible)) in report.refusals {
            println!("  {count:5} refused, {possible:4} of them possible: {reason}");
        }
        for (what, times) in [
            ("accepted", &mut report.accepted),
            ("refused", &mut report.refused),
        ] {
            println!(
                "  time of one check, {what}: median {:?}, 99 % {:?}, greatest {:?}",
                quantile(times, 0.5),
                quantile(times, 0.99),
                quantile(times, 1.0)
            );
        }
    }
}
