//! `ppnpack experiment loads`: loads measured in the cell, against limits and estimates.

mod limits;
mod packing;

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use ppnpack_cli::failure::{OrInput, Outcome};
use ppnpack_cli::options::CatalogueOptions;

use crate::apart::Apart;
use crate::cases::{Case, SequenceOptions};
use crate::packer::Packer;
use crate::results::with;
use crate::runs::RunsOptions;
use crate::way::Way;
use limits::{FACTORS, with_limits};
use packing::Run;
use serde_json::json;

/// Packs sequences of items that may carry only so much, measures in the cell what each carries
/// after every placement, and compares margins. The first line is packed without limits.
#[derive(Debug, Args)]
pub(crate) struct LoadsArguments {
    #[command(flatten)]
    catalogue: CatalogueOptions,

    #[command(flatten)]
    sequences: SequenceOptions<0, 100>,

    /// How many items of each sequence
    #[arg(long, value_name = "COUNT", default_value_t = 80, value_parser = clap::value_parser!(u32).range(1..))]
    items: u32,

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

    #[command(flatten)]
    runs: RunsOptions,
}

pub(crate) fn run(arguments: &LoadsArguments) -> Outcome {
    let way = Way::read_one(arguments.method.as_deref())?;
    let mut packer = Packer::robot(way, &arguments.catalogue, Apart::default())?;
    let catalogue = Arc::clone(&packer.catalogue);
    let mut cases = arguments.sequences.read(&catalogue)?;
    for case in &mut cases {
        case.sequence.objects.truncate(arguments.items as usize);
    }
    let limits_kg = limits::draw(&catalogue);
    let margins = arguments.margins.iter().copied().map(Some);
    let margins: Vec<Option<f64>> = std::iter::once(None).chain(margins).collect();
    let usual = packer.way.method.loads.margin;
    let mut lines = Vec::new();
    for margin in &margins {
        packer.way.method.loads.margin = margin.unwrap_or(usual);
        packer.way.method.validate().or_input()?;
        packer.catalogue = Arc::new(with_limits(&catalogue, margin.map(|_| &limits_kg[..])));
        let settings = (
            catalogue.content_hash(),
            &packer.way,
            &limits_kg,
            margin,
            arguments.items,
        );
        let is_right = |case: &Case, run: &Run| run.objects == case.sequence.objects;
        let pack = |case: &Case| packing::pack(&packer, case);
        let runs = arguments.runs.kept("loads", &settings)?;
        runs.make(&cases, Case::name, is_right, pack)?;
        let name = margin.map_or("no limits".to_owned(), |margin| format!("margin {margin}"));
        lines.push(json!({ "name": name, "margin": margin, "folder": runs.name() }));
    }
    let results = json!({
        "limits_kg": limits_kg,
        "items": arguments.items,
        "factors": FACTORS,
        "way": packer.way,
        "lines": lines,
    });
    let results = with(results, arguments.sequences.said());
    arguments.runs.publish("loads", results, "loads")
}
