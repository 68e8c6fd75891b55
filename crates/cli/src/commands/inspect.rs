//! `ppnpack inspect`: what is in a recording.

use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;
use ppnpack_recording::Contents;

use crate::failure::{OrInput, Outcome};
use crate::output;

/// Says what is in a recording: its time, channels, decisions, cells and versions, and whether it ended whole. Ends with 1 where it is
/// damaged.
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
    output::print(&contents, arguments.json, || told(&contents))?;
    match contents.damage {
        Some(damage) => Err(anyhow!(damage).into()),
        None => Ok(()),
    }
}

/// The contents for people.
fn told(contents: &Contents) -> String {
    let Contents {
        library,
        first_ns,
        last_ns,
        cells,
        decisions,
        planners,
        ..
    } = contents;
    let list = |names: &std::collections::BTreeSet<String>| match names.is_empty() {
        true => "none".to_owned(),
        false => names.iter().cloned().collect::<Vec<_>>().join(", "),
    };
    let span_s = last_ns.saturating_sub(*first_ns) as f64 / 1e9;
    let summary = output::rows([
        ("written by", library.clone()),
        ("from", utc(*first_ns)),
        ("to", format!("{}, {span_s:.1} s later", utc(*last_ns))),
        ("cells", list(cells)),
        ("planners", list(planners)),
        (
            "steps planned",
            format!(
                "{} decided, {} in which nothing fitted, {} of these cut by their time",
                decisions.decided, decisions.nothing_fitted, decisions.cut
            ),
        ),
        ("end", end(contents)),
    ]);
    let lines = contents.topics.iter().map(|(topic, of)| {
        [
            topic.clone(),
            of.messages.to_string(),
            format!("{:.2}", of.bytes as f64 / 1e6),
            of.dropped.to_string(),
            of.schema.clone(),
        ]
    });
    let table = output::columns(["channel", "messages", "MB", "dropped", "schema"], lines);
    format!("{summary}\n{table}")
}

/// How the file ends, for people.
fn end(contents: &Contents) -> String {
    match (&contents.damage, contents.is_whole) {
        (Some(damage), _) => damage.clone(),
        (None, true) => "whole".to_owned(),
        (None, false) => "cut: its recorder was killed, or is still writing it; the last second before that may be missing"
            .to_owned(),
    }
}

/// A time in UTC.
fn utc(at_ns: u64) -> String {
    ppnpack_recording::utc(at_ns / 1_000_000_000)
}
