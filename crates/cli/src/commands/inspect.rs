//! `ppnpack inspect`: what is in a recording.

use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;
use ppnpack_recording::Contents;

use crate::failure::{OrInput, Outcome};
use crate::output;
use crate::text::template;

/// Says what is in a recording: its time, channels, decisions, cells and versions, and whether it
/// ended whole. Ends with 1 where it is damaged.
#[derive(Debug, Args)]
pub(crate) struct InspectArguments {
    /// An MCAP file of `ppnpack record`
    file: PathBuf,

    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &InspectArguments) -> Outcome {
    let contents = Contents::of(&arguments.file).or_input()?;
    output::print(&contents, arguments.json, template!("inspect.txt"))?;
    match contents.damage {
        Some(damage) => Err(anyhow!(damage).into()),
        None => Ok(()),
    }
}
