//! `ppnpack experiment filling`: how full containers get, and what topples or slides, under robot conditions.

pub(crate) mod apart;
mod bench;
mod results;
mod ways;

use std::path::PathBuf;

use clap::Args;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_cli::options::{CatalogueOptions, ViewOptions};
use ppnpack_cli::sequence::Sequence;
use ppnpack_packing::episode::{Observer, Play, play};
use ppnpack_physics::outcome::is_unsteady;
use serde::{Deserialize, Serialize};

use crate::cases::{Case, SequenceOptions};
use crate::document::{self, OutOptions};
use crate::runs::{Runs, RunsOptions, hash};
use apart::{Apart, Physics};
pub(crate) use bench::{Bench, catalogue};
use results::Results;
pub(crate) use ways::Way;

/// Packs test sequences in robot conditions with several methods, and compares volume, steadiness and time.
#[derive(Debug, Args)]
pub(crate) struct FillingArguments {
    #[command(flatten)]
    catalogue: CatalogueOptions,

    #[command(flatten)]
    sequences: SequenceOptions<0, 100>,

    /// A JSON file with the methods to compare, such as experiments/filling.json; the first is what the others are compared with, and
    /// results are named by the file
    #[arg(long, value_name = "FILE")]
    methods: PathBuf,

    /// Of them, only this one beside the first; may be given several times
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,

    /// The physics of the cells that are packed in; each has a table of its own
    #[arg(
        long,
        value_enum,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "own,apart"
    )]
    physics: Vec<Physics>,

    #[command(flatten)]
    view: ViewOptions,

    #[command(flatten)]
    runs: RunsOptions,

    #[command(flatten)]
    out: OutOptions,
}

impl FillingArguments {
    /// What results are named by.
    fn name(&self) -> String {
        let stem = self.methods.file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    }
}

/// One packed sequence.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Run {
    pub(super) objects: Vec<usize>,
    pub(super) items: usize,
    pub(crate) placed: usize,
    pub(crate) meshes_m3: f64,
    /// Toppled, slid or fell out, of what was placed.
    pub(crate) unsteady: usize,
    pub(super) set_aside: usize,
    pub(super) in_other_pose: usize,
    /// Searched exhaustively, as none of their proposals was valid.
    pub(super) steps_widened: usize,
    /// Of each step.
    pub(super) decision_s: Vec<f64>,
}

pub(crate) fn run(arguments: &FillingArguments) -> Outcome {
    let ways = ways::chosen(&arguments.methods, &arguments.only)?;
    let ways: Vec<Way> = ways
        .into_iter()
        .map(|way| way.seen_by(&arguments.view))
        .collect();
    let name = &arguments.name();
    let mut results = Results::new(&ways, arguments);
    for physics in &arguments.physics {
        results.add(*physics, pack_all(arguments, &ways, &physics.apart())?);
    }
    let folder = arguments.out.folder(name);
    let size = [760, 460];
    document::figure(&folder, name, results.steadiness().to_svg(size))?;
    let times = format!("{name}-times");
    document::figure(&folder, &times, results.times().to_svg(size))?;
    arguments.out.publish(name, &results, &results.text)
}

/// Packs all sequences in all ways, those first that come first; gives the runs by way, then sequence.
fn pack_all(arguments: &FillingArguments, ways: &[Way], apart: &Apart) -> Outcome<Vec<Vec<Run>>> {
    let folder = &arguments.runs.folder(&arguments.out, &arguments.name());
    let of_way = |way: &Way| {
        let catalogue = catalogue(&arguments.catalogue, way)?;
        let cases = arguments.sequences.read(&catalogue)?;
        let kept = Runs::new(folder, &(catalogue.content_hash(), way, apart))?;
        let pack = |Case { number, sequence }: &Case| {
            let is_right = |run: &Run| run.objects == sequence.objects;
            let name = format!("{}-{number:05}", hash(way, 16)?);
            kept.finish(&name, is_right, || {
                let seed = u64::from(*number);
                pack(way, &catalogue, sequence, seed, apart, &mut ())
            })
        };
        arguments.runs.make(&cases, pack)
    };
    ways.iter().map(of_way).collect()
}

/// Packs a sequence; the observer sees its steps.
pub(crate) fn pack(
    way: &Way,
    catalogue: &Catalogue,
    sequence: &Sequence,
    seed: u64,
    apart: &Apart,
    observer: &mut dyn Observer,
) -> Outcome<Run> {
    let Bench {
        grid,
        mut planner,
        mut cell,
    } = Bench::new(way, catalogue, seed, apart)?;
    let how = Play {
        set_aside: way.set_aside,
        ..Play::with_buffer(way.method.buffer)
    };
    let items = sequence.candidates(catalogue);
    let episode = play(&grid, &mut planner, &mut cell, items, how, observer).or_run()?;
    let reports = || cell.placed().iter().map(|placed| &placed.report);
    let steps = || episode.steps.iter();
    Ok(Run {
        objects: sequence.objects.clone(),
        items: episode.metrics.packed.items,
        placed: reports().count(),
        meshes_m3: episode.metrics.packed.meshes_m3,
        unsteady: reports()
            .filter(|report| is_unsteady(report.toppled, report.slide_m, report.inside))
            .count(),
        set_aside: episode.set_aside.len(),
        in_other_pose: steps().filter(|step| step.candidate.pose > 0).count(),
        steps_widened: episode.steps_widened(),
        decision_s: steps()
            .map(|step| step.timings.total().as_secs_f64())
            .collect(),
    })
}
