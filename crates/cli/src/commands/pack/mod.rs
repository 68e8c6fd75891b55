//! `ppnpack pack`: packs one sequence in the simulated cell and reports on it.

use std::time::Instant;

use clap::Args;
use indicatif::ProgressBar;
use ppnpack_packing::check::BoxedCheck;
use ppnpack_packing::episode::{Observer, Play, Step};
use ppnpack_packing::method::OpenNetwork;
use ppnpack_packing::step::StepInput;
use ppnpack_physics::moves::Moves;
use ppnpack_physics::outcome::BodyState;
use ppnpack_physics::packing_cell::Placed;
use ppnpack_physics::trial;
use ppnpack_physics::twin::TwinSettings;

use super::job::{ALTERNATIVES, ResultOptions, SettingAsideOptions};
use crate::failure::{OrInput, OrRun, Outcome};
use crate::network::Backend;
use crate::options::{CatalogueOptions, Conditions, GridOptions, MethodOptions, PhysicsOptions};
use crate::progress;
use crate::report::{
    ArmAsked, ArmWork, Content, EndingSummary, MethodWithArm, Packing, Settings, Settled,
    Unplaceable,
};
use crate::sequence::SequenceOptions;
use crate::simulation::{empty_cell, simulate};

/// Packs one sequence of objects in the simulated cell, prints a summary and writes a report with pictures.
#[derive(Debug, Args)]
pub(crate) struct PackArguments {
    #[command(flatten)]
    catalogue: CatalogueOptions,

    #[command(flatten)]
    sequence: SequenceOptions,

    #[command(flatten)]
    setting_aside: SettingAsideOptions,

    #[command(flatten)]
    grid: GridOptions,

    #[command(flatten)]
    method: MethodOptions,

    #[command(flatten)]
    physics: PhysicsOptions,

    #[command(flatten)]
    results: ResultOptions,
}

pub(crate) fn run(arguments: &PackArguments, backend: &dyn Backend) -> Outcome {
    if arguments.method.arm.listed()? {
        return Ok(());
    }
    let conditions = arguments.physics.conditions(Conditions::Robot);
    let grid = arguments.grid.grid(conditions)?;
    let threads = arguments.method.threads.unwrap_or(1);
    let proposals = &arguments.method.proposals;
    if proposals.uses_network() {
        backend.prepare();
    }
    let model = proposals.read_model()?;
    let source = proposals.source(&grid, model.as_ref())?;
    let poses = arguments.catalogue.poses;
    let method = arguments.method.method(source, conditions, poses)?;
    let (arm, station) = arguments.method.arm.station()?.unzip();
    let simulated = arguments
        .physics
        .simulated(&grid, method.seed, Conditions::Robot)?;
    let catalogue = arguments.catalogue.load(grid.resolution())?;
    let mut sequence = arguments.sequence.sequence(&catalogue, method.seed)?;
    let mut work = station
        .as_ref()
        .map(|station| ArmWork::new(station, &mut sequence, &catalogue));
    let items = sequence.items(&catalogue);
    let network = proposals.network(backend, model.as_ref(), &items);
    let network = network.as_ref().map(|network| network as &dyn OpenNetwork);
    let station = station.as_ref();
    let twin = TwinSettings::of(&simulated.cell);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let pool = trial::pool(
        arguments
            .method
            .threads
            .map_or(cores, |threads| threads as usize),
    );
    let pool = pool.or_run()?;
    let started = Instant::now();
    let proposer = method.proposer_or_exhaustive(&grid, network)?;
    let arm_check = station.map(|station| Box::new(station.check()) as BoxedCheck);
    let trial = trial::check(method.trial, &method.loads, twin, pool).or_input()?;
    let checks = arm_check.into_iter().chain(trial);
    let mut planner = method.build_with(&grid, proposer, checks, threads)?;
    let set_aside = arguments.setting_aside.limit(conditions);
    let mut watch = Watch(progress::bar("Packing", sequence.objects.len() as u64));
    let (episode, cell) = simulate(
        &catalogue,
        &grid,
        &sequence,
        empty_cell(&catalogue, &grid, &simulated)?,
        &mut planner,
        Play {
            buffer: method.buffer,
            set_aside,
            alternatives: ALTERNATIVES.into(),
        },
        &mut watch,
    )?;
    watch.0.finish_and_clear();
    if let Some(work) = &mut work {
        work.asked = Some(ArmAsked::of(&episode));
    }
    let packing = Packing {
        settings: Settings {
            catalogue: arguments.catalogue.catalogue.clone(),
            catalogue_hash: catalogue.content_hash(),
            objects: catalogue.len(),
            poses: arguments.catalogue.poses,
            sequence,
            set_aside,
            grid,
            method: MethodWithArm { method, arm },
            threads,
            simulated,
        },
        ending: EndingSummary::new(&episode.ending),
        set_aside: episode.set_aside.iter().map(Unplaceable::from).collect(),
        steps: episode.steps,
        scene: episode.scene,
        metrics: episode.metrics,
        settled: cell.placed().iter().map(settled).collect(),
        moves: cell.placed().iter().map(moves).collect(),
        contents: cell.contents().into_iter().map(content).collect(),
        took: started.elapsed(),
        arm: work,
    };
    arguments.results.publish(&packing)
}

fn settled(placed: &Placed) -> Settled {
    Settled {
        slide_m: placed.report.slide_m,
        tilt_rad: placed.report.tilt_rad,
        toppled: placed.report.toppled,
        inside: placed.report.inside,
    }
}

fn moves(placed: &Placed) -> Moves {
    placed.moves.clone()
}

fn content((arrival, body): (usize, BodyState)) -> (usize, Content) {
    (arrival, body.into())
}

/// Shows how far the packing is.
struct Watch(ProgressBar);

impl Observer for Watch {
    fn on_step(&mut self, _step: &Step, _input: &StepInput<'_>) {
        self.0.inc(1);
    }
}
