//! `ppnpack inspect`: what is in a recording.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use ppnpack_recording::Contents;

use crate::failure::{OrInput, Outcome};
use crate::output;
use crate::text::template;

/// Says what is in recordings: of each its time, channels, decisions, cells and versions, and whether it
/// ended whole. Ends with 1 where one is damaged.
#[derive(Debug, Args)]
pub(crate) struct InspectArguments {
    /// MCAP files of `ppnpack record`
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,

    /// Print JSON instead of a table, a line for each file
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &InspectArguments) -> Outcome {
    output::of_each(&arguments.files, arguments.json, |file| {
        inspect(file, arguments.json)
    })
}

fn inspect(file: &Path, json: bool) -> Outcome {
    let contents = Contents::of(file).or_input()?;
    output::print(&contents, json, template!("inspect.txt"))?;
    match contents.damage {
        Some(damage) => Err(anyhow!(damage).into()),
        None => Ok(()),
    }
}
