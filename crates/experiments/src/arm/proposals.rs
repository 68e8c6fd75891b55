//! `ppnpack experiment proposals`: where pruned proposals pay with an arm. Decision time, packed volume and checks per step
//! of each source of proposals, with the arm's check and without. Items stay where they are placed; no physics.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_cli::options::{CatalogueOptions, PROPOSAL_YAWS};
use ppnpack_cli::sequence::SequenceFile;
use ppnpack_packing::check::BoxedCheck;
use ppnpack_packing::episode::{IdealCell, Observer, Play, Step, play};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::method::{ProposalSource, Stability};
use ppnpack_packing::refusal::Cause;
use ppnpack_packing::step::{Candidate, StepInput};
use ppnpack_robot::station::{ArmStation, StationSettings};

use crate::method::sdfm;
use crate::pareto::GridOption;

const BUFFER: usize = 5;

/// Packs test sequences with each source of proposals, with the built-in arm and without.
#[derive(Debug, Args)]
pub(crate) struct ProposalsArguments {
    #[command(flatten)]
    catalogue: CatalogueOptions,

    /// A .npy file of sequences, int64 [sequences, length], of object indices
    #[arg(long, value_name = "FILE")]
    sequences: PathBuf,

    /// How many sequences, from the first
    #[arg(long, value_name = "COUNT", default_value_t = 5)]
    cases: usize,

    /// The grids
    #[arg(long, value_enum, value_delimiter = ',', default_value = "coarse,fine")]
    grids: Vec<GridOption>,
}

fn sources(grid: &Grid) -> [ProposalSource; 5] {
    let coarse = |percent| ProposalSource::coarse(grid, percent, None, PROPOSAL_YAWS);
    [
        ProposalSource::All,
        ProposalSource::Bounded,
        coarse(5.0),
        coarse(0.5),
        ProposalSource::Random { percent: 5.0 },
    ]
}

/// What the sequences of a line of the table came to.
#[derive(Debug, Default)]
struct Found {
    steps: usize,
    /// Of these, searched exhaustively as none of their proposals was valid.
    steps_widened: usize,
    decision_s: f64,
    check_s: f64,
    volume_m3: f64,
    asked: u64,
    refused: u64,
    most_asked: u64,
    cycle_s: f64,
}

impl Observer for Found {
    fn on_step(&mut self, step: &Step, _input: &StepInput<'_>) {
        self.steps += 1;
        self.steps_widened += usize::from(step.is_widened);
        self.decision_s += step.timings.total().as_secs_f64();
        self.check_s += step.timings.check.as_secs_f64();
        self.cycle_s += step.cycle_s().unwrap_or_default();
        self.volume_m3 += step.candidate.item.mesh_volume_m3();
        let refusals = step.refusals.iter();
        let of_arm = refusals.filter(|(refusal, _)| refusal.cause == Cause::Arm);
        let refused: u64 = of_arm.map(|(_, count)| count).sum();
        // The arm is asked last: it accepted the choice.
        let asked = refused + 1;
        self.asked += asked;
        self.refused += refused;
        self.most_asked = self.most_asked.max(asked);
    }
}

pub(crate) fn run(arguments: &ProposalsArguments) -> Outcome {
    for option in &arguments.grids {
        let grid = option.grid()?;
        let catalogue = arguments.catalogue.load(grid.resolution())?;
        let file = SequenceFile::read(&arguments.sequences, &catalogue)?;
        let count = arguments.cases.min(file.count());
        let (_, name, ..) = option.parts();
        println!("\n{name}, {count} sequences");
        measure(&catalogue, &grid, &file, count)?;
    }
    Ok(())
}

fn measure(catalogue: &Catalogue, grid: &Grid, file: &SequenceFile, count: usize) -> Outcome {
    let station = ArmStation::new(&StationSettings::default()).or_run()?;
    let resolution = grid.resolution();
    let mut check = station.check();
    let mut can_be_lifted = |held: &Candidate| check.lift(held, resolution).is_ok();
    let (all, objects) = (catalogue.len(), catalogue.objects.iter());
    let held = objects.filter(|object| can_be_lifted(&object.candidate(0)));
    println!("{} of {all} objects can be picked", held.count());
    println!(
        "| proposals | arm | steps | widened in all | decision ms | of it checks ms | volume cm3 | asked per step | most | refused | cycle s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for source in sources(grid) {
        for has_arm in [false, true] {
            let started = Instant::now();
            let mut found = Found::default();
            for case in 0..count {
                let mut items = file.get(case)?.candidates(catalogue);
                items.retain(|item| can_be_lifted(item));
                let poses = items.chunk_by_mut(|a, b| a.arrival == b.arrival);
                for (arrival, poses) in poses.enumerate() {
                    poses.iter_mut().for_each(|item| item.arrival = arrival);
                }
                let method = sdfm(source.clone(), Stability::Physical, BUFFER, 0);
                let proposer = method.proposer(grid, None)?;
                let check = has_arm.then(|| Box::new(station.check()) as BoxedCheck);
                let mut planner = method.build_with(grid, proposer, check, 1)?;
                let mut cell = IdealCell::new(grid);
                let how = Play::with_buffer(BUFFER);
                play(grid, &mut planner, &mut cell, items, how, &mut found).or_run()?;
            }
            print(&source, has_arm, &found, count);
            eprintln!("{:.1} s", started.elapsed().as_secs_f64());
        }
    }
    Ok(())
}

fn print(source: &ProposalSource, has_arm: bool, found: &Found, sequences: usize) {
    let steps = found.steps.max(1) as f64;
    let mean_s = found.cycle_s / steps;
    let of_arm = match has_arm {
        true => format!(
            "{:.1} | {} | {:.0} % | {mean_s:.2}",
            found.asked as f64 / steps,
            found.most_asked,
            100.0 * found.refused as f64 / found.asked.max(1) as f64
        ),
        false => "| | |".to_owned(),
    };
    println!(
        "| {source} | {} | {:.1} | {} | {:.2} | {:.2} | {:.0} | {of_arm} |",
        if has_arm { "yes" } else { "no" },
        steps / sequences as f64,
        found.steps_widened,
        1e3 * found.decision_s / steps,
        1e3 * found.check_s / steps,
        1e6 * found.volume_m3 / sequences as f64
    );
}
