//! `ppnpack compare`: two packings side by side.

use std::path::PathBuf;

use clap::Args;

use crate::comparison::{Comparison, Run, page};
use crate::failure::{OrInput, Outcome};
use crate::output;

/// Compares two packings: what differs in their settings and figures, and where their choices first part. Prints it and writes
/// `compare.html` with both pictures.
#[derive(Debug, Args)]
pub(crate) struct CompareArguments {
    /// The folder of a packing, as `ppnpack pack --out` wrote it
    a: PathBuf,

    /// The folder of another one
    b: PathBuf,

    /// Where `compare.html` is written
    #[arg(long, value_name = "DIR", default_value = "out/compare")]
    out: PathBuf,

    /// Print JSON instead of tables
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &CompareArguments) -> Outcome {
    let a = Run::read(&arguments.a).or_input()?;
    let b = Run::read(&arguments.b).or_input()?;
    let comparison = Comparison::of(&a, &b);
    let path = arguments.out.join("compare.html");
    ppnpack_files::write_whole(&path, page::page(&comparison, &a, &b).as_bytes())?;
    Ok(output::print(&comparison, arguments.json, || {
        format!("{}\nPage: {}", comparison.tables(), path.display())
    })?)
}
