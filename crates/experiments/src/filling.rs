//! `ppnpack experiment filling`: volume, and what topples or slides, under robot conditions.

use std::path::PathBuf;

use clap::Args;
use ppnpack_cli::failure::Outcome;
use ppnpack_cli::options::CatalogueOptions;
use serde_json::{Value, json};

use crate::apart::Physics;
use crate::cases::SequenceOptions;
use crate::packer::Packer;
use crate::results::with;
use crate::runs::RunsOptions;
use crate::way::{self, Way};

/// Packs test sequences in robot conditions by several methods; compares volume, steadiness, time.
#[derive(Debug, Args)]
pub(crate) struct FillingArguments {
    #[command(flatten)]
    catalogue: CatalogueOptions,

    #[command(flatten)]
    sequences: SequenceOptions<0, 100>,

    /// A JSON file with the methods to compare, such as experiments/filling.json; the first is what
    /// the others are compared with, and results are named by the file
    #[arg(long, value_name = "FILE")]
    methods: PathBuf,

    /// Only this one of them beside the first; may be given several times
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
    runs: RunsOptions,
}

pub(crate) fn run(arguments: &FillingArguments) -> Outcome {
    let ways = way::chosen(&arguments.methods, &arguments.only)?;
    let name = arguments.methods.file_stem().unwrap_or_default();
    let name = &*name.to_string_lossy();
    let (sequences, runs) = (&arguments.sequences, &arguments.runs);
    let table = |physics: &Physics| {
        let apart = physics.apart();
        let line = |way: &Way| {
            let packer = Packer::robot(way.clone(), &arguments.catalogue, apart)?;
            let cases = sequences.read(&packer.catalogue)?;
            let folder = packer.pack_all(&cases, 0, runs, name)?;
            Ok(json!({ "name": way.name, "folder": folder }))
        };
        let lines: Vec<Value> = ways.iter().map(line).collect::<Outcome<_>>()?;
        Ok(json!({ "apart": apart, "lines": lines }))
    };
    let tables = arguments.physics.iter().map(table);
    let tables: Vec<Value> = tables.collect::<Outcome<_>>()?;
    let results = json!({ "ways": ways, "tables": tables });
    runs.publish(name, with(results, sequences.said()), "filling")
}
