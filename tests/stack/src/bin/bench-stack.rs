//! `bench-stack`: how long plans take through the stack, every service its own process, through a router.

use std::collections::BTreeMap;
use std::time::Duration;

use anyhow::{Context, Result};
use clap::Parser;
use ppnpack_catalogue::catalogue::{Catalogue, Settings};
use ppnpack_packing::grid::Resolution;
use ppnpack_stack_tests::latency::{Measured, Times, Twin, measure};
use ppnpack_stack_tests::{Options, Stack};
use ppnpack_wire::keys::Service;
use serde::Serialize;

/// Where a stack evaluates if nothing else is said.
const FASTEST: &str = "fastest";

/// Measures plans through the stack: reference setting, simulated cells, the built-in objects.
#[derive(Debug, Parser)]
struct Arguments {
    /// Containers packed per row
    #[arg(long, default_value_t = 5)]
    containers: usize,

    /// Objects that arrive for each container
    #[arg(long, default_value_t = 60)]
    objects: usize,

    /// Leave the network out, as where there is no libtorch
    #[arg(long)]
    without_network: bool,

    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// A row of the table; times in milliseconds.
#[derive(Debug, Serialize)]
struct Row {
    what: String,
    plans: usize,
    p50_ms: f64,
    p99_ms: f64,
    max_ms: f64,
    /// The same steps planned in one process.
    in_process_p50_ms: Option<f64>,
    /// The planner's own stages, each at its median; what is left of `p50_ms` is the way to the planner and back.
    stages_p50_ms: BTreeMap<String, f64>,
    degraded: usize,
}

impl Row {
    fn new(what: impl Into<String>, measured: Measured) -> Self {
        let asked = Times::new(measured.asked);
        let in_process = Times::new(measured.in_process);
        let stages = measured.stages.into_iter();
        let median = |(stage, times)| (stage, Times::new(times).percentile_ms(0.5));
        Self {
            stages_p50_ms: stages.map(median).collect(),
            what: what.into(),
            plans: asked.count(),
            p50_ms: asked.percentile_ms(0.5),
            p99_ms: asked.percentile_ms(0.99),
            max_ms: asked.percentile_ms(1.0),
            in_process_p50_ms: (in_process.count() > 0).then(|| in_process.percentile_ms(0.5)),
            degraded: measured.degraded,
        }
    }
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let catalogue = Catalogue::load(
        &ppnpack_household::builtin(),
        &Settings::default(),
        &Resolution::reference(),
        &|_, _| {},
    )?;
    let mut rows = vec![
        exhaustive(&arguments, &catalogue, FASTEST)?,
        exhaustive(&arguments, &catalogue, "services")?,
    ];
    if !arguments.without_network {
        rows.push(with_network(&arguments, &catalogue)?);
    }
    rows.extend(four_cells(&arguments, &catalogue)?);
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&rows)?);
    } else {
        print_table(&rows);
    }
    Ok(())
}

/// Placements pass a geometric test and are not tried: a try takes longer than all that is measured here.
fn untried(mut options: Options) -> Options {
    for cell in &options.cells {
        for setting in ["trial.tries_per_item=0", "stability=\"physical\""] {
            let setting = format!("service.cells.{cell}.{setting}");
            options.settings.push((Service::Planner, setting));
        }
    }
    options
}

fn exhaustive(arguments: &Arguments, catalogue: &Catalogue, evaluate: &'static str) -> Result<Row> {
    let stack = Stack::start(&untried(Options {
        evaluate,
        ..Options::default()
    }))?;
    let mut twin = Twin::new(catalogue, true)?;
    let measured = pack(&stack, 0, arguments, catalogue, Some(&mut twin))?;
    let what = format!("exhaustive search, evaluate = {evaluate}, one cell");
    Ok(Row::new(what, measured))
}

fn with_network(arguments: &Arguments, catalogue: &Catalogue) -> Result<Row> {
    let options = untried(Options {
        has_network: true,
        evaluate: FASTEST,
        ..Options::default()
    });
    let stack =
        Stack::start(&options).context("with the network; --without-network leaves it out")?;
    let measured = pack(&stack, 0, arguments, catalogue, None)?;
    Ok(Row::new("network, K = 5 %, one cell", measured))
}

fn four_cells(arguments: &Arguments, catalogue: &Catalogue) -> Result<Vec<Row>> {
    let cells: Vec<String> = (1..=4).map(|number| format!("cell-{number}")).collect();
    let options = untried(Options {
        cells: cells.clone(),
        evaluate: FASTEST,
        ..Options::default()
    });
    let stack = Stack::start(&options)?;
    let measured: Vec<Result<Measured>> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..cells.len())
            .map(|cell| {
                let stack = &stack;
                scope.spawn(move || pack(stack, cell, arguments, catalogue, None))
            })
            .collect();
        let joined = threads.into_iter().map(|thread| thread.join());
        joined
            .map(|joined| joined.unwrap_or_else(|_| Err(anyhow::anyhow!("a thread panicked"))))
            .collect()
    });
    let rows = cells.iter().zip(measured);
    rows.map(|(cell, measured)| {
        Ok(Row::new(
            format!("exhaustive search, {cell} of four at once"),
            measured?,
        ))
    })
    .collect()
}

fn pack(
    stack: &Stack,
    cell: usize,
    arguments: &Arguments,
    catalogue: &Catalogue,
    mut twin: Option<&mut Twin<'_>>,
) -> Result<Measured> {
    let client = stack.cell(cell)?;
    let mut all = Measured::default();
    for container in 0..arguments.containers {
        // Another part of the catalogue each time, the same in every row.
        let names = catalogue.objects.iter().map(|object| &**object.item.name());
        let objects: Vec<&str> = names
            .cycle()
            .skip(container * 17)
            .take(arguments.objects)
            .collect();
        let session_id = format!("bench-{cell}-{container}");
        let measured = measure(&client, &session_id, &objects, twin.as_deref_mut())?;
        // The first plan of a container is like any other, but the first of all fills the caches.
        let warm_up = usize::from(container == 0);
        all.asked.extend(
            measured
                .asked
                .iter()
                .skip(warm_up)
                .copied()
                .collect::<Vec<Duration>>(),
        );
        all.in_process
            .extend(measured.in_process.iter().skip(warm_up));
        for (stage, times) in measured.stages {
            all.stages.entry(stage).or_default().extend(times);
        }
        all.degraded += measured.degraded;
    }
    Ok(all)
}

fn print_table(rows: &[Row]) {
    println!(
        "| what | plans | p50 (ms) | p99 (ms) | max (ms) | in one process, p50 (ms) | added (ms) | degraded |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for row in rows {
        let optional = |value: Option<f64>| value.map_or("–".to_owned(), |ms| format!("{ms:.2}"));
        println!(
            "| {} | {} | {:.2} | {:.2} | {:.2} | {} | {} | {} |",
            row.what,
            row.plans,
            row.p50_ms,
            row.p99_ms,
            row.max_ms,
            optional(row.in_process_p50_ms),
            optional(row.in_process_p50_ms.map(|ms| row.p50_ms - ms)),
            row.degraded
        );
    }
    println!("\nThe planner's stages, each at its median:\n");
    println!("| what | stage | p50 (ms) |");
    println!("|---|---|---|");
    for row in rows {
        for (stage, p50_ms) in &row.stages_p50_ms {
            println!("| {} | {stage} | {p50_ms:.2} |", row.what);
        }
    }
}
