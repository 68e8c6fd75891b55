//! `ppnpack experiment loads`: what items carry as measured in the simulated cell, against what they may and what was estimated.

mod limits;
mod packing;
mod results;

use std::path::PathBuf;

use clap::Args;
use ppnpack_cli::failure::{Failure, Outcome};
use ppnpack_cli::options::CatalogueOptions;

use crate::cases::{Case, SequenceOptions};
use crate::document::{self, OutOptions};
use crate::filling::apart::Physics;
use crate::filling::{self, Way};
use crate::runs::{Runs, RunsOptions};
use limits::LimitOptions;
use packing::{Packing, Run};
use results::Results;

/// Packs sequences of items that may carry only so much, measures in the cell what each carries after every placement, and compares
/// margins. The first line is packed without limits.
#[derive(Debug, Args)]
pub(crate) struct LoadsArguments {
    #[command(flatten)]
    catalogue: CatalogueOptions,

    #[command(flatten)]
    sequences: SequenceOptions<0, 100>,

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

    #[command(flatten)]
    runs: RunsOptions,

    #[command(flatten)]
    out: OutOptions,
}

pub(crate) fn run(arguments: &LoadsArguments) -> Outcome {
    let way = match &arguments.method {
        Some(path) => Way::read_one(path)?,
        None => Way::default(),
    };
    let catalogue = filling::catalogue(&arguments.catalogue, &way)?;
    let mut cases = arguments.sequences.read(&catalogue)?;
    for case in &mut cases {
        case.sequence.objects.truncate(arguments.items as usize);
    }
    let limits = arguments.limits.draw(&catalogue)?;
    let apart = arguments.physics.apart();
    let folder = arguments.runs.folder(&arguments.out, "loads");
    let margins = arguments.margins.iter().copied().map(Some);
    let mut packed = Vec::new();
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
        let kept = Runs::new(&folder, &settings)?;
        let pack = |case: &Case| {
            let is_right = |run: &Run| run.objects == case.sequence.objects;
            let name = format!("{:05}", case.number);
            kept.finish(&name, is_right, || packing.pack(case))
        };
        packed.push((margin, arguments.runs.make(&cases, pack)?));
    }
    let results = Results::new(arguments, &way, packed, &limits);
    let chart = results.chart.to_svg([760, 340]);
    document::figure(&arguments.out.folder("loads"), "loads", chart)?;
    arguments.out.publish("loads", &results, &results.text)
}
