//! `ppnpack pack`: packs one sequence in the simulated cell and reports on it.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use indicatif::ProgressBar;
use ppnpack_packing::episode::{Observer, Play, Step};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::proposals::{OrExhaustive, Proposer};
use ppnpack_packing::step::StepInput;
use ppnpack_physics::outcome::BodyState;
use ppnpack_physics::packing_cell::Placed;

use crate::failure::{Failure, Outcome};
use crate::fastest;
use crate::network::Backend;
use crate::options::{
    CatalogueOptions, Conditions, GridOptions, Method, MethodOptions, Network, PhysicsOptions,
    ProposalSource,
};
use crate::output::{print_json, print_line};
use crate::progress;
use crate::report::{self, ArmAsked, ArmWork, Content, EndingSummary, Packing, Settings, Settled};
use crate::sequence::SequenceOptions;
use crate::simulation::simulate;

/// Packs one sequence of objects in the simulated cell, prints a summary and writes a report with pictures.
#[derive(Debug, Args)]
pub(crate) struct PackArguments {
    #[command(flatten)]
    catalogue: CatalogueOptions,

    #[command(flatten)]
    sequence: SequenceOptions,

    #[command(flatten)]
    grid: GridOptions,

    #[command(flatten)]
    method: MethodOptions,

    #[command(flatten)]
    physics: PhysicsOptions,

    /// Where the results are written
    #[arg(long, value_name = "DIR", default_value = "out/pack")]
    out: PathBuf,

    /// Print the summary as JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// Valid placements kept beside each choice, for the report.
const ALTERNATIVES: usize = 3;

pub(crate) fn run(arguments: &PackArguments, backend: &dyn Backend) -> Outcome {
    if arguments.method.arm.listed()? {
        return Ok(());
    }
    let grid = arguments.grid.grid()?;
    let proposals = &arguments.method.proposals;
    if proposals.uses_network() {
        backend.prepare();
    }
    let model = proposals.read_model()?;
    let sources = proposals.sources(&grid, model.as_ref())?;
    let first = sources.first().cloned().unwrap_or(ProposalSource::Bounded);
    let mut method = arguments.method.method(first)?;
    let simulated = arguments
        .physics
        .simulated(&grid, method.seed, Conditions::Robot)?;
    let threads = arguments.method.threads;
    let catalogue = arguments.catalogue.load(grid.resolution())?;
    let mut sequence = arguments.sequence.sequence(&catalogue, method.seed)?;
    let station = method.station()?;
    let mut arm = station
        .as_ref()
        .map(|station| ArmWork::new(station, sequence.set_aside(&catalogue, station)));
    let items = sequence.items(&catalogue);
    let network = model.as_ref().map(|model| Network {
        backend,
        model,
        device: proposals.device(),
        items: &items,
    });
    let mut costs = Vec::new();
    if sources.len() > 1 {
        costs = fastest::measure(&method, &sources, &grid, &items, threads, network)?;
        if let Some(fastest) = costs.first() {
            method.proposals = fastest.proposals.clone();
        }
    }
    let proposer = proposer(&method, &grid, network)?;
    let mut planner = method.planner_with(proposer, &grid, threads, station.as_ref())?;

    let started = Instant::now();
    let mut watch = Watch {
        bar: progress::bar("Packing", sequence.objects.len() as u64),
    };
    let (episode, cell) = simulate(
        &catalogue,
        &grid,
        &sequence,
        &simulated,
        &mut planner,
        Play {
            buffer: method.buffer,
            alternatives: ALTERNATIVES,
        },
        &mut watch,
    )?;
    watch.bar.finish_and_clear();
    if let Some(arm) = &mut arm {
        arm.cycles_s = episode.steps.iter().map(Step::cycle_s).collect();
        arm.asked = Some(ArmAsked::of(&episode));
    }
    let packing = Packing {
        settings: Settings {
            catalogue: arguments.catalogue.catalogue.clone(),
            catalogue_hash: catalogue.content_hash(),
            objects: catalogue.len(),
            sequence,
            grid,
            method,
            costs,
            threads,
            simulated,
        },
        ending: EndingSummary::new(&episode.ending),
        steps: episode.steps,
        scene: episode.scene,
        metrics: episode.metrics,
        settled: cell.placed().iter().map(settled).collect(),
        contents: cell.contents().into_iter().map(content).collect(),
        took: started.elapsed(),
        arm,
    };
    finish(&packing, &arguments.out, arguments.json)
}

/// Writes the report and prints the summary.
pub(crate) fn finish(packing: &Packing, out: &Path, json: bool) -> Outcome {
    let summary = packing.summary();
    report::write(packing, &summary, out)?;
    if json {
        print_json(&summary)?;
    } else {
        print_line(&report::table::summary(packing, &summary))?;
        print_line(&format!("Report: {}", out.join("report.html").display()))?;
    }
    Ok(())
}

fn settled(placed: &Placed) -> Settled {
    Settled {
        slide_m: placed.report.slide_m,
        tilt_rad: placed.report.tilt_rad,
        toppled: placed.report.toppled,
        inside: placed.report.inside,
    }
}

fn content((arrival, body): (usize, BodyState)) -> (usize, Content) {
    let content = Content {
        model: body.model,
        container_from_item: body.container_from_item,
        inside: body.inside,
    };
    (arrival, content)
}

/// The method's proposals. A network that cannot run, now or later, gives way to the exhaustive search.
fn proposer(
    method: &Method,
    grid: &Grid,
    network: Option<Network<'_>>,
) -> Outcome<Box<dyn Proposer>> {
    let is_network = method.proposals.is_network();
    match method.proposer(grid, network) {
        Ok(proposer) if is_network => Ok(Box::new(OrExhaustive::new(proposer))),
        Err(Failure::Run(error)) if is_network => {
            Ok(Box::new(OrExhaustive::instead(format!("{error:#}"))))
        }
        other => other,
    }
}

/// Shows how far the packing is.
struct Watch {
    bar: ProgressBar,
}

impl Observer for Watch {
    fn on_step(&mut self, _step: &Step, _input: &StepInput<'_>) {
        self.bar.inc(1);
    }
}
