//! `ppnpack pack`: packs one sequence in the simulated cell and reports on it.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use indicatif::ProgressBar;
use ppnpack_packing::episode::{Observer, Step};
use ppnpack_packing::heightmap::Scene;

use crate::failure::Outcome;
use crate::options::{CatalogueOptions, Conditions, GridOptions, MethodOptions, PhysicsOptions};
use crate::output::{print_json, print_line};
use crate::progress;
use crate::report::{self, Packing, Settings};
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

pub(crate) fn run(arguments: &PackArguments) -> Outcome {
    let grid = arguments.grid.grid()?;
    let method = arguments.method.method()?;
    let simulated = arguments
        .physics
        .simulated(&grid, method.seed, Conditions::Robot)?;
    let threads = arguments.method.threads;
    let mut planner = method
        .planner(&grid, threads)?
        .with_alternatives(ALTERNATIVES);
    let catalogue = arguments.catalogue.load(grid.resolution())?;
    let sequence = arguments.sequence.sequence(&catalogue, method.seed)?;

    let started = Instant::now();
    let mut watch = Progress(progress::bar("Packing", sequence.objects.len() as u64));
    let (episode, cell) = simulate(
        &catalogue,
        &grid,
        &sequence,
        &simulated,
        &mut planner,
        method.buffer,
        &mut watch,
    )?;
    watch.0.finish_and_clear();
    let packing = Packing {
        settings: Settings {
            catalogue: arguments.catalogue.catalogue.clone(),
            catalogue_hash: catalogue.content_hash(),
            objects: catalogue.len(),
            sequence,
            grid,
            method,
            threads,
            simulated,
        },
        episode,
        contents: cell.contents(),
        placed: cell.placed().to_vec(),
        took: started.elapsed(),
    };
    let summary = packing.summary();
    report::write(&packing, &summary, &arguments.out)?;
    if arguments.json {
        print_json(&summary)?;
    } else {
        print_line(&report::table::summary(&packing, &summary))?;
        print_line(&format!(
            "Report: {}",
            arguments.out.join("report.html").display()
        ))?;
    }
    Ok(())
}

struct Progress(ProgressBar);

impl Observer for Progress {
    fn on_step(&mut self, _step: &Step, _scene: &Scene) {
        self.0.inc(1);
    }
}
