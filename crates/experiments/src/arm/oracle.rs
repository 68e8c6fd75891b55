//! `ppnpack experiment oracle`: places random items over random contents and asks the oracle about each: unsafe ones
//! accepted, safe ones refused.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::Args;
use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_packing::step::StepInput;
use ppnpack_robot::arm::Arm;
use ppnpack_robot::cell::CellSettings;
use ppnpack_robot::feasibility::ArmCheck;
use ppnpack_robot::motion::{PlaceMotion, PlacePlanner};
use ppnpack_robot::refusal::Refusal;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::common::oracle::Oracle;
use super::common::scenes::{Case, arms, case};
use crate::statistics::{nearest_rank, percentage};
use crate::workers;

/// Compares the arm's check with brute force on random placements. For times of the check use one thread.
#[derive(Debug, Args)]
pub(crate) struct OracleArguments {
    /// How many placements that the arm can hold, for each arm
    #[arg(long, value_name = "COUNT", default_value_t = 1000)]
    placements: usize,

    /// Only this arm, counted from 0
    #[arg(long, value_name = "NUMBER")]
    arm: Option<usize>,

    /// Threads [default: one per core]
    #[arg(long, value_name = "COUNT", value_parser = ppnpack_cli::options::at_least_one)]
    threads: Option<usize>,

    /// The least bend of the wrist, in degrees [default: the cell's]
    #[arg(long, value_name = "DEGREES")]
    wrist_bend: Option<f64>,
}

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
            self.refuse(reason, count, possible);
        }
    }

    fn refuse(&mut self, reason: String, count: usize, possible: usize) {
        let counts = self.refusals.entry(reason).or_default();
        counts.0 += count;
        counts.1 += possible;
    }
}

fn try_some(arm: &Arc<Arm>, cell: &CellSettings, seed: u64, placements: usize) -> Outcome<Report> {
    let planner = PlacePlanner::new(Arc::clone(arm), cell.clone()).or_run()?;
    let mut check = ArmCheck::new(planner);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut report = Report::default();
    while report.accepted.len() + report.refused.len() < placements {
        let case = case(&mut random);
        let input = StepInput::new(&case.grid, &case.scene, &[]);
        let Ok(pick) = check.pick(&case.candidate(), case.grid.resolution()) else {
            continue;
        };
        let Some((planned, took)) = timed(&check, &input, &case) else {
            continue;
        };
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
                report.refuse(text, 1, was_possible);
            }
        }
    }
    Ok(report)
}

/// What the check says, and the least time of three, each on its own copy: a machine that does other things too adds
/// milliseconds now and then.
fn timed(
    check: &ArmCheck,
    input: &StepInput<'_>,
    case: &Case,
) -> Option<(Result<PlaceMotion, Refusal>, Duration)> {
    let attempts = [(); 3].map(|()| {
        let mut check = check.clone();
        let start = Instant::now();
        let planned = check.plan(input, &case.candidate(), &case.resting);
        (planned, start.elapsed())
    });
    attempts.into_iter().min_by_key(|(_, took)| *took)
}

pub(crate) fn run(arguments: &OracleArguments) -> Outcome {
    let threads = arguments.threads.unwrap_or_else(workers::default_count);
    let mut cell = CellSettings::default();
    if let Some(bend_deg) = arguments.wrist_bend {
        cell.least_wrist_bend_deg = bend_deg;
    }
    for (index, (name, arm)) in arms().into_iter().enumerate() {
        if arguments.arm.is_some_and(|wanted| wanted != index) {
            continue;
        }
        let arm = Arc::new(arm);
        let each = arguments.placements.div_ceil(threads);
        let jobs: Vec<u64> = (0..threads as u64).collect();
        let parts = workers::map("Placing", &jobs, threads, |thread| {
            try_some(&arm, &cell, 1000 * (index as u64 + 1) + thread, each)
        })?;
        let mut report = Report::default();
        parts.into_iter().for_each(|part| report.add(part));
        let tried = report.accepted.len() + report.refused.len();
        let accepted = report.accepted.len();
        println!("{name}: {tried} placements that can be held, {accepted} accepted");
        let found = &report.unsafe_ones;
        println!("  unsafe ones accepted: {} {found:?}", found.len());
        let lost: usize = report.refusals.values().map(|(_, possible)| possible).sum();
        let possible = report.possible;
        let percent = percentage(lost, possible);
        println!("  possible ones refused: {lost} of {possible} ({percent:.1} %)");
        for (reason, (count, possible)) in report.refusals {
            println!("  {count:5} refused, {possible:4} of them possible: {reason}");
        }
        for (what, mut times) in [("accepted", report.accepted), ("refused", report.refused)] {
            times.sort_unstable();
            let [median, most, greatest] =
                [0.5, 0.99, 1.0].map(|share| nearest_rank(&times, share).unwrap_or_default());
            println!(
                "  time of one check, {what}: median {median:?}, 99 % {most:?}, greatest {greatest:?}"
            );
        }
    }
    Ok(())
}
