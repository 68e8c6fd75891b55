//! `ppnpack status`: which services are alive, and whether they are ready.

use clap::Args;
use ppnpack_service::alive;
use ppnpack_service::rpc::Client;
use ppnpack_wire::keys::{Cell, Instance, Service};
use ppnpack_wire::v1;
use serde::Serialize;

use crate::failure::{Failure, OrRun, Outcome};
use crate::output::{self, print_json, print_line};
use crate::stack::connect::ConnectOptions;

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
#[derive(Debug, Serialize)]
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
        let asked = client.health(found.service, &found.instance, deadline);
        lines.push(match asked {
            Ok(health) => line(found.service, &found.instance, &found.cells, health),
            Err(error) => silent(
                found.service,
                &found.instance,
                &found.cells,
                error.to_string(),
            ),
        });
    }
    if arguments.json {
        print_json(&lines)?;
    } else {
        print_line(&table(&lines))?;
    }
    match lines.iter().find(|line| !line.ready) {
        Some(line) => Err(Failure::Run(anyhow::anyhow!(
            "{} {} is not ready",
            line.service,
            line.instance
        ))),
        None if lines.is_empty() => Err(Failure::Run(anyhow::anyhow!("no service is alive"))),
        None => Ok(()),
    }
}

fn line(service: Service, instance: &Instance, cells: &[Cell], health: v1::HealthReply) -> Line {
    let failing = health.checks.into_iter().filter(|check| !check.is_passing);
    let versions = health
        .header
        .and_then(|header| header.versions)
        .unwrap_or_default();
    Line {
        ready: health.is_ready,
        failing: failing
            .map(|check| format!("{}: {}", check.name, check.message))
            .collect(),
        version: versions.software,
        configuration: versions.configuration,
        model: versions.model,
        uptime_s: health.uptime_ns as f64 / 1e9,
        ..silent(service, instance, cells, String::new())
    }
}

fn silent(service: Service, instance: &Instance, cells: &[Cell], reason: String) -> Line {
    Line {
        service: service.to_string(),
        instance: instance.to_string(),
        cells: cells.iter().map(Cell::to_string).collect(),
        ready: false,
        failing: vec![reason],
        version: String::new(),
        configuration: String::new(),
        model: String::new(),
        uptime_s: 0.0,
    }
}

fn table(lines: &[Line]) -> String {
    let mut table = output::table();
    table.set_header([
        "service",
        "instance",
        "cells",
        "ready",
        "version",
        "up",
        "what is wrong",
    ]);
    for line in lines {
        let cells = match line.cells.is_empty() {
            true => "any".to_owned(),
            false => line.cells.join(", "),
        };
        let ready = if line.ready { "yes" } else { "no" };
        table.add_row([
            line.service.clone(),
            line.instance.clone(),
            cells,
            ready.to_owned(),
            line.version.clone(),
            format!("{:.0} s", line.uptime_s),
            line.failing.join("; "),
        ]);
    }
    table.to_string()
}
