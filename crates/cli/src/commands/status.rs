//! `ppnpack status`: lists the services that are alive, and whether they are ready.

use std::time::Instant;

use anyhow::anyhow;
use clap::Args;
use ppnpack_service::alive::Found;
use ppnpack_service::survey;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;
use serde::Serialize;

use crate::failure::{OrRun, Outcome};
use crate::output;
use crate::stack::connect::ConnectOptions;
use crate::text::template;

/// Shows which services are alive, and whether they are ready. Ends with 1 where one is not ready
/// or none is alive.
#[derive(Debug, Args)]
pub(crate) struct StatusArguments {
    #[command(flatten)]
    connection: ConnectOptions,

    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// One service.
#[derive(Debug, Serialize)]
struct Line {
    service: String,
    instance: String,
    /// The cells that it serves; none where it serves any.
    cells: Vec<String>,
    ready: bool,
    /// Checks that do not pass, or the reason why it could not be asked.
    failing: Vec<String>,
    version: String,
    configuration: String,
    model: String,
    uptime_s: f64,
}

pub(crate) fn run(arguments: &StatusArguments) -> Outcome {
    let session = arguments.connection.open()?;
    let left = arguments.connection.deadline()? - Instant::now();
    let found = survey::instances(&session, left).or_run()?;
    let lines: Vec<Line> = found.into_iter().map(Line::of).collect();
    output::print(&lines, arguments.json, template!("status.txt"))?;
    match lines.iter().find(|line| !line.ready) {
        Some(line) => Err(anyhow!("{} {} is not ready", line.service, line.instance).into()),
        None if lines.is_empty() => Err(anyhow!("no service is alive").into()),
        None => Ok(()),
    }
}

impl Line {
    fn of((found, health): (Found, v1::HealthReply)) -> Self {
        let failing = health.checks.into_iter().filter(|check| !check.is_passing);
        let failing = failing.map(|check| format!("{}: {}", check.name, check.message));
        let versions = health.header.and_then(|header| header.versions);
        let versions = versions.unwrap_or_default();
        Self {
            service: found.service.to_string(),
            instance: found.instance.to_string(),
            cells: found.cells.iter().map(Cell::to_string).collect(),
            ready: health.is_ready,
            failing: failing.collect(),
            version: versions.software,
            configuration: versions.configuration,
            model: versions.model,
            uptime_s: health.uptime_ns as f64 / 1e9,
        }
    }
}
