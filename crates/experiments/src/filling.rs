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
use ppnpack_cli::sequence::{Sequence, SequenceFile};
use ppnpack_packing::episode::{Observer, Play, play};
use ppnpack_physics::outcome::is_unsteady;
use serde::{Deserialize, Serialize};

use crate::cases::{Case, cases};
use crate::document::{self, Answer, Document};
use crate::runs::{Part, Runs, ShardOptions, hash};
use crate::workers;
use apart::{Apart, Physics};
pub(crate) use bench::{Bench, catalogue};
use results::{Results, Table};
use ways::Comparison;
pub(crate) use ways::Way;

/// Packs test sequences in robot conditions with several methods, and compares volume, steadiness and time.
#[derive(Debug, Args)]
pub(crate) struct FillingArguments {
    #[command(flatten)]
    catalogue: CatalogueOptions,

    /// A .npy file of sequences, int64 [sequences, length], of object indices
    #[arg(long, value_name = "FILE")]
    sequences: PathBuf,

    /// The first sequence
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    first: u32,

    /// How many sequences
    #[arg(long, value_name = "COUNT", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..))]
    cases: u32,

    /// What is compared
    #[arg(long, value_enum, default_value_t = Comparison::Stages)]
    compare: Comparison,

    /// Of what is compared, only this method beside the first; may be given several times
    #[arg(long, value_name = "NAME", conflicts_with = "methods")]
    only: Vec<String>,

    /// A JSON file with the methods to compare, in place of those of --compare; the first is what the others are compared
    /// with
    #[arg(long, value_name = "FILE", conflicts_with = "compare")]
    methods: Option<PathBuf>,

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

    /// Sequences packed at once, by default one per core
    #[arg(long, value_name = "COUNT", default_value_t = workers::default_count())]
    workers: usize,

    /// Where report.html, the document (filling.md, effort.md, limits.md or views.md), its figures and its chart are written
    #[arg(long, value_name = "DIR", default_value = "out/filling")]
    out: PathBuf,

    #[command(flatten)]
    runs: ShardOptions,

    /// Print the results as JSON instead of a table
    #[arg(long)]
    json: bool,
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
    let ways = match &arguments.methods {
        Some(path) => ways::read(path)?,
        None => arguments.compare.ways(&arguments.only)?,
    };
    let ways: Vec<Way> = ways
        .into_iter()
        .map(|way| way.seen_by(&arguments.view))
        .collect();
    let part = arguments.runs.part(&arguments.out);
    let compare = arguments.compare;
    let mut results = Results::new(compare.title(), &ways, arguments);
    for physics in &arguments.physics {
        let packed = pack_all(arguments, &ways, &physics.apart(), &part)?;
        let table = packed.map(|runs| Table::new(*physics, &ways, &runs));
        results.tables.extend(table);
    }
    if part.shard.is_some() {
        return part.tell(arguments.json);
    }
    let (out, name) = (&arguments.out, compare.name());
    let chart = match compare {
        Comparison::Stages | Comparison::Limits | Comparison::Views => results.steadiness(),
        Comparison::Efforts => results.times(),
    };
    document::figure(out, name, chart.to_svg([760, 460]))?;
    let document = Document {
        name,
        answer: Answer {
            question: compare.question(),
            text: results.answer(),
            picture: format!("{name}.svg"),
        },
        results: &results,
        asked: arguments,
        measured: &["lines"],
        markdown: results.markdown(),
    };
    document.publish(out, arguments.json)
}

/// Packs all sequences in all ways, those first that come first; gives the runs by way, then sequence; `None` where only a shard of
/// them is made here.
fn pack_all(
    arguments: &FillingArguments,
    ways: &[Way],
    apart: &Apart,
    part: &Part,
) -> Outcome<Option<Vec<Vec<Run>>>> {
    let mut of_ways = Vec::new();
    for way in ways {
        let catalogue = catalogue(&arguments.catalogue, way)?;
        let sequences = SequenceFile::read(&arguments.sequences, &catalogue)?;
        let cases = cases(&sequences, arguments.first, arguments.cases)?;
        let kept = Runs::new(&part.runs, &(catalogue.content_hash(), way, apart))?;
        let pack = |case: &Case| pack_kept(&kept, way, &catalogue, case, apart);
        of_ways.push(part.make(&kept, &cases, arguments.workers, pack)?);
    }
    Ok(of_ways.into_iter().collect())
}

/// Packs a sequence, where that was not done before.
pub(crate) fn pack_kept(
    kept: &Runs,
    way: &Way,
    catalogue: &Catalogue,
    Case { number, sequence }: &Case,
    apart: &Apart,
) -> Outcome<Run> {
    let is_right = |run: &Run| run.objects == sequence.objects;
    let name = format!("{}-{number:05}", hash(way, 16)?);
    kept.finish(&name, is_right, || {
        let seed = u64::from(*number);
        pack(way, catalogue, sequence, seed, apart, &mut ())
    })
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
