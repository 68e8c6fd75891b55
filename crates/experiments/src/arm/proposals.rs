//! `ppnpack experiment proposals`: where pruned proposals pay with an arm. Decision time, packed volume and checks per step
//! of each source of proposals, with the arm's check and without. Items stay where they are placed; no physics.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_cli::options::{
    CatalogueOptions, Method, PROPOSAL_YAWS, ProposalSource, StabilityOption,
};
use ppnpack_cli::sequence::SequenceFile;
use ppnpack_packing::episode::{IdealCell, Observer, Step, play};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::item::Item;
use ppnpack_packing::objective::{Heuristic, Order, Weights};
use ppnpack_packing::step::StepInput;
use ppnpack_robot::station::{ArmStation, StationSettings};

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
    let coarse = |percent| ProposalSource::coarse(grid, percent, PROPOSAL_YAWS);
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
    decision_s: f64,
    check_s: f64,
    volume_m3: f64,
    asked: u64,
    refused: u64,
    most_asked: u64,
    cycles_s: Vec<f64>,
}

/// Notes what the steps of a sequence came to.
struct Notes<'a> {
    found: &'a mut Found,
    station: Option<&'a ArmStation>,
}

impl Observer for Notes<'_> {
    fn on_step(&mut self, step: &Step, input: &StepInput<'_>) {
        let Self { found, station } = self;
        let item = &step.candidate.item;
        found.steps += 1;
        found.decision_s += step.timings.total().as_secs_f64();
        found.check_s += step.timings.check.as_secs_f64();
        found.volume_m3 += item.mesh_volume_m3();
        if let Some(station) = station {
            let tally = station.take_tally();
            found.asked += tally.asked;
            found.refused += tally.refused.values().sum::<u64>();
            found.most_asked = found.most_asked.max(tally.asked);
            let cycle = station.cycle(input, &step.candidate, &step.choice.resting);
            found.cycles_s.extend(cycle.map(|cycle| cycle.cycle_s));
        }
    }
}

pub(crate) fn run(arguments: &ProposalsArguments) -> Outcome {
    for option in &arguments.grids {
        let grid = option.grid()?;
        let catalogue = arguments.catalogue.load(grid.resolution())?;
        let file = SequenceFile::read(&arguments.sequences, &catalogue)?;
        let count = arguments.cases.min(file.len());
        println!("\n{}, {count} sequences", option.name());
        measure(&catalogue, &grid, &file, count)?;
    }
    Ok(())
}

fn measure(catalogue: &Catalogue, grid: &Grid, file: &SequenceFile, count: usize) -> Outcome {
    let station = ArmStation::new(&StationSettings::default()).or_run()?;
    let resolution = grid.resolution();
    for object in &catalogue.objects {
        station.hold(&object.item, &object.model);
    }
    let can_be_lifted = |item: &Item| station.lift(item, resolution).is_ok();
    let objects = catalogue.objects.iter();
    let held = objects.filter(|object| can_be_lifted(&object.item)).count();
    println!(
        "{held} of {} objects can be picked",
        catalogue.objects.len()
    );
    println!(
        "| proposals | arm | steps | decision ms | of it checks ms | volume cm3 | asked per step | most | refused | cycle s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for source in sources(grid) {
        for has_arm in [false, true] {
            let started = Instant::now();
            let of_step = has_arm.then_some(&station);
            let mut found = Found::default();
            for case in 0..count {
                let mut items = file.get(case)?.items(catalogue);
                items.retain(|item| can_be_lifted(item));
                let method = method(&source);
                let proposer = method.proposer(grid, None)?;
                let mut planner = method.planner_with(proposer, grid, 1, of_step)?;
                let mut cell = IdealCell::new(grid);
                let mut notes = Notes {
                    found: &mut found,
                    station: of_step,
                };
                play(grid, &mut planner, &mut cell, items, BUFFER, &mut notes).or_run()?;
                // The last step, which found nothing, is no decision.
                station.take_tally();
            }
            print(&source, has_arm, &found, count);
            eprintln!("{:.1} s", started.elapsed().as_secs_f64());
        }
    }
    Ok(())
}

fn method(proposals: &ProposalSource) -> Method {
    Method {
        heuristic: Heuristic::Sdfm,
        order: Order::Balance,
        proposals: proposals.clone(),
        stability: StabilityOption::Physical,
        arm: None,
        weights: Weights::default(),
        buffer: BUFFER,
        seed: 0,
    }
}

fn print(source: &ProposalSource, has_arm: bool, found: &Found, sequences: usize) {
    let steps = found.steps.max(1) as f64;
    let mean_s = found.cycles_s.iter().sum::<f64>() / steps;
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
        "| {source} | {} | {:.1} | {:.2} | {:.2} | {:.0} | {of_arm} |",
        if has_arm { "yes" } else { "no" },
        steps / sequences as f64,
        1e3 * found.decision_s / steps,
        1e3 * found.check_s / steps,
        1e6 * found.volume_m3 / sequences as f64
    );
}
