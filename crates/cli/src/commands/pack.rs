//! `ppnpack pack`: packs one sequence in the simulated cell and reports on it.

use std::time::Instant;

use clap::{Arg, Args};
use indicatif::ProgressBar;
use ppnpack_packing::checks::check::BoxedCheck;
use ppnpack_packing::planning::method::OpenNetwork;
use ppnpack_packing::ranking::step::StepInput;
use ppnpack_packing::streams::episode::{Observer, Play, Step, play};
use ppnpack_physics::trial;
use ppnpack_physics::twin::TwinSettings;

use super::job::{ALTERNATIVES, CellOptions, JobOptions};
use crate::failure::{OrInput, OrRun, Outcome};
use crate::network::Backend;
use crate::progress;
use crate::report::{ArmAsked, Packing};

/// Options that matter first: they come before the others' headings.
const FIRST: [&str; 8] = [
    "catalogue",
    "container",
    "cell",
    "yaws",
    "poses",
    "items",
    "random",
    "out",
];

const EXAMPLES: &str = "Examples:
  ppnpack pack --random 30
  ppnpack pack --catalogue parts --unit mm --container 60x40x30cm --poses 4 --out out/parts";

/// Packs one sequence of objects in the simulated cell, prints a summary and writes a report with
/// pictures.
#[derive(Debug, Args)]
#[command(mut_args(first), after_help = EXAMPLES)]
pub(crate) struct PackArguments {
    #[command(flatten)]
    cell: CellOptions,

    #[command(flatten)]
    job: JobOptions,
}

pub(crate) fn run(arguments: &PackArguments, backend: &dyn Backend) -> Outcome {
    let options = &arguments.cell;
    if options.method.arm.listed()? {
        return Ok(());
    }
    let cell = options.set_up(backend, true)?;
    let catalogue = options.load(&cell, arguments.job.begin()?)?;
    let (settings, mut arm) = arguments.job.settings(options, &cell, &catalogue)?;
    let (grid, method, simulated) = (&cell.grid, &cell.method, &cell.simulated);
    let items = settings.sequence.items(&catalogue);
    let proposals = &options.method.proposals;
    let network = proposals.network(backend, cell.model.as_ref(), &items);
    let network = network.as_ref().map(|network| network as &dyn OpenNetwork);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let pool = trial::pool(cores).or_run()?;
    let started = Instant::now();
    let proposer = method.proposer_or_exhaustive(grid, network)?;
    let arm_check = cell.station.as_ref();
    let arm_check = arm_check.map(|station| Box::new(station.check()) as BoxedCheck);
    let twin = TwinSettings::of(&simulated.cell);
    let trial = trial::check(method.trial, &method.loads, twin, pool).or_input()?;
    let checks = arm_check.into_iter().chain(trial);
    let mut planner = method.build_with(grid, proposer, checks)?;
    let objects = settings.sequence.objects.len() as u64;
    let mut watch = Watch(progress::bar("Packing", objects));
    let mut done = simulated.packing_cell(simulated.cell.clone(), grid, &catalogue)?;
    let how = Play {
        buffer: method.buffer,
        set_aside: settings.set_aside,
        alternatives: ALTERNATIVES.into(),
    };
    let arriving = settings.sequence.candidates(&catalogue);
    let episode = play(grid, &mut planner, &mut done, arriving, how, &mut watch).or_run()?;
    watch.0.finish_and_clear();
    if let Some(arm) = &mut arm {
        arm.asked = Some(ArmAsked::of(&episode));
    }
    arguments.job.publish(&Packing {
        arm,
        ..Packing::of(settings, episode, &done, started.elapsed())
    })
}

/// Takes an option that matters first out of its heading.
fn first(option: Arg) -> Arg {
    match FIRST.contains(&option.get_id().as_str()) {
        true => option.help_heading(None),
        false => option,
    }
}

/// Shows how far the packing is.
struct Watch(ProgressBar);

impl Observer for Watch {
    fn on_step(&mut self, _step: &Step, _input: &StepInput<'_>) {
        self.0.inc(1);
    }
}
