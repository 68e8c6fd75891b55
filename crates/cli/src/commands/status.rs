//! `ppnpack status`: which services are alive, and whether they are ready.

use anyhow::anyhow;
use clap::Args;
use ppnpack_service::alive;
use ppnpack_service::rpc::Client;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;
use serde::Serialize;

use crate::failure::{OrRun, Outcome};
use crate::output;
use crate::stack::connect::ConnectOptions;
use crate::text::template;

/// Shows which services are alive, and whether they are ready. Ends with 1 where one is not ready or none is alive.
#[derive(Debug, Args)]
pub(crate) struct StatusArguments {
    #[command(flatten)]
    connection: ConnectOptions,

    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// One service.
#[derive(Debug, Default, Serialize)]
struct Line {
    service: String,
    instance: String,
    /// The cells that it serves; none where it serves any.
    cells: Vec<String>,
    ready: bool,
    /// What does not pass, or why it could not be asked.
    failing: Vec<String>,
    version: String,
    configuration: String,
    model: String,
    uptime_s: f64,
}

pub(crate) fn run(arguments: &StatusArguments) -> Outcome {
    let session = arguments.connection.open()?;
    let client = Client::new(&session);
    let deadline = arguments.connection.deadline()?;
    let mut lines = Vec::new();
    for found in alive::find(&session, deadline).or_run()? {
        let line = Line {
            service: found.service.to_string(),
            instance: found.instance.to_string(),
            cells: found.cells.iter().map(Cell::to_string).collect(),
            ..Line::default()
        };
        let health = client.health(found.service, &found.instance, deadline);
        lines.push(match health {
            Ok(health) => line.with(health),
            Err(error) => Line {
                failing: vec![error.to_string()],
                ..line
            },
        });
    }
    output::print(&lines, arguments.json, template!("status.txt"))?;
    match lines.iter().find(|line| !line.ready) {
        Some(line) => Err(anyhow!("{} {} is not ready", line.service, line.instance).into()),
        None if lines.is_empty() => Err(anyhow!("no service is alive").into()),
        None => Ok(()),
    }
}

impl Line {
    fn with(self, health: v1::HealthReply) -> Self {
        let failing = health.checks.into_iter().filter(|check| !check.is_passing);
        let failing = failing.map(|check| format!("{}: {}", check.name, check.message));
        let versions = health.header.and_then(|header| header.versions);
        let versions = versions.unwrap_or_default();
        Self {
            ready: health.is_ready,
            failing: failing.collect(),
            version: versions.software,
            configuration: versions.configuration,
            model: versions.model,
            uptime_s: health.uptime_ns as f64 / 1e9,
            ..self
        }
    }
}
