//! `ppnpack experiment loads`: what items carry as measured in the simulated cell, against what they may and what was estimated.

mod columns;
mod limits;
mod packing;

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use ppnpack_cli::failure::{OrInput, Outcome};
use ppnpack_cli::options::CatalogueOptions;

use crate::apart::Apart;
use crate::cases::{Case, SequenceOptions};
use crate::document::Page;
use crate::packer::Packer;
use crate::runs::RunsOptions;
use crate::sheet::Lines;
use crate::way::Way;
use limits::{FACTORS, with_limits};
use packing::Run;

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
    let mut packed = Vec::new();
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
        let runs = &arguments.runs;
        let runs = runs.make("loads", &settings, &cases, Case::name, is_right, pack)?;
        let name = margin.map_or("no limits".to_owned(), |margin| format!("margin {margin}"));
        packed.push((name, runs));
    }
    let mut lines = Lines::new("name", packed);
    lines.keep("margin", margins);
    let ([least, greatest], sequences) = (FACTORS, &arguments.sequences);
    let mut page = Page::new(
        "loads",
        format!(
            "# Loads: measured, estimated, allowed\n\n\
             {} containers of up to {} items, sequences from {} on, method *{}*. Each object may carry between {least} and {greatest} times its own mass, a \
             factor drawn once an object, or what the catalogue says. Loads are measured in the simulated cell, at rest, after every \
             placement: the vertical forces, friction among them, with which other items press an item down. Impacts are not measured. Limits \
             *exceeded* are items that carried more after any placement. Differences are to packing without limits, sequence by sequence, \
             with 95 % intervals by Student's t.\n\n{}\n\
             Loads of at least 50 g at the end, as measured, by what is estimated from where all items lie then. *Missed* are those estimated at \
             less than a tenth; *beyond all above* those more than 10 % greater than the mass of all that was thought to rest there. *In \
             motion* are placements after which something still moved; *unbalanced* says how exact the measure is: the difference between \
             what an item is held up with and what it weighs and carries, for 99 % of them.\n\n{}",
            sequences.cases,
            arguments.items,
            sequences.first,
            packer.way.name,
            lines.table("line", &columns::limits(&limits_kg)),
            lines.table("line", &columns::ratios()),
        ),
    );
    page.keep("first_case", sequences.first);
    page.keep("cases", sequences.cases);
    page.keep("items", arguments.items);
    page.keep("factors", FACTORS);
    page.keep("way", &packer.way);
    page.keep("lines", lines);
    page.publish(&arguments.runs.out)
}
