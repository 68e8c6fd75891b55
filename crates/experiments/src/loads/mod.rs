//! `ppnpack experiment loads`: what items carry as measured in the simulated cell, against what they may and what was estimated.

mod limits;
mod packing;
mod results;

use std::path::PathBuf;

use clap::Args;
use ppnpack_cli::failure::{Failure, Outcome};
use ppnpack_cli::options::CatalogueOptions;
use ppnpack_cli::sequence::SequenceFile;

use crate::cases::{Case, cases};
use crate::document::{self, Answer, Document};
use crate::filling::apart::Physics;
use crate::filling::{self, Way};
use crate::runs::{Runs, ShardOptions};
use crate::workers;
use limits::LimitOptions;
use packing::{Packing, Run};
use results::Results;

/// Packs sequences of items that may carry only so much, measures in the cell what each carries after every placement, and compares
/// margins. The first line is packed without limits.
#[derive(Debug, Args)]
pub(crate) struct LoadsArguments {
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

    /// How many items of each sequence
    #[arg(long, value_name = "COUNT", default_value_t = 80, value_parser = clap::value_parser!(u32).range(1..))]
    items: u32,

    #[command(flatten)]
    limits: LimitOptions,

    /// How many times estimated loads are held against the limits
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "1,1.25,1.5,2"
    )]
    margins: Vec<f64>,

    /// A JSON file with the method, in place of placements that are tried on 5 mm and 8 yaws
    #[arg(long, value_name = "FILE")]
    method: Option<PathBuf>,

    /// The physics of the cells that are packed in
    #[arg(long, value_enum, default_value_t = Physics::Own)]
    physics: Physics,

    /// Sequences packed at once, by default one per core
    #[arg(long, value_name = "COUNT", default_value_t = workers::default_count())]
    workers: usize,

    /// Where report.html, loads.md, loads.json and loads.svg are written
    #[arg(long, value_name = "DIR", default_value = "out/loads")]
    out: PathBuf,

    #[command(flatten)]
    runs: ShardOptions,

    /// Print the results as JSON instead of a table
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &LoadsArguments) -> Outcome {
    let way = match &arguments.method {
        Some(path) => Way::read_one(path)?,
        None => Way::default(),
    };
    let catalogue = filling::catalogue(&arguments.catalogue, &way)?;
    let sequences = SequenceFile::read(&arguments.sequences, &catalogue)?;
    let mut cases = cases(&sequences, arguments.first, arguments.cases)?;
    for case in &mut cases {
        case.sequence.objects.truncate(arguments.items as usize);
    }
    let limits = arguments.limits.draw(&catalogue)?;
    let apart = arguments.physics.apart();
    let part = arguments.runs.part(&arguments.out);
    let margins = arguments.margins.iter().copied().map(Some);
    let mut results = Results::new(arguments, &way);
    for margin in std::iter::once(None).chain(margins) {
        let packing = Packing::new(&way, margin, &catalogue, &limits, &apart);
        packing.way.method.validate().map_err(Failure::input)?;
        let settings = (
            catalogue.content_hash(),
            &packing.way,
            &apart,
            &limits,
            margin,
            arguments.items,
        );
        let kept = Runs::new(&part.runs, &settings)?;
        let pack = |case: &Case| {
            let is_right = |run: &Run| run.objects == case.sequence.objects;
            let name = format!("{:05}", case.number);
            kept.finish(&name, is_right, || packing.pack(case))
        };
        if let Some(runs) = part.make(&kept, &cases, arguments.workers, pack)? {
            results.add(margin, &runs, &limits);
        }
    }
    if part.shard.is_some() {
        return part.tell(arguments.json);
    }
    let out = &arguments.out;
    document::bars(out, "loads", results::TITLES, results.bars())?;
    let document = Document {
        name: "loads",
        answer: Answer {
            question: "Do items carry no more than they may?",
            text: results.answer(),
            picture: "loads.svg".to_owned(),
        },
        results: &results,
        asked: arguments,
        measured: &["lines"],
        markdown: results.markdown(),
    };
    document.publish(out, arguments.json)
}
