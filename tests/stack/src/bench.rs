//! The times of plans through the stack: every service is a process, connected to a router.

use anyhow::{Context, Result};
use clap::Args;
use ppnpack_catalogue::catalogue::{Catalogue, Settings};
use ppnpack_packing::kernel::grid::Resolution;
use ppnpack_wire::keys::Service;

use crate::latency::{Measured, Times, Twin, pack_container};
use crate::report::print_table;
use crate::stack::{Options, Stack};

/// The planner's default setting of where placements are evaluated.
const IN_PROCESS: &str = "in-process";

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Containers packed per row
    #[arg(long, default_value_t = 5)]
    containers: usize,

    /// Objects that arrive for each container
    #[arg(long, default_value_t = 60)]
    objects: usize,

    /// Leave the network out, as where there is no libtorch
    #[arg(long)]
    without_network: bool,
}

type Row = (String, Measured);

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let catalogue = builtin()?;
    let mut rows = vec![
        exhaustive(arguments, &catalogue, IN_PROCESS)?,
        exhaustive(arguments, &catalogue, "services")?,
    ];
    if !arguments.without_network {
        rows.push(with_network(arguments, &catalogue)?);
    }
    rows.extend(four_cells(arguments, &catalogue)?);
    print_rows(rows);
    Ok(())
}

pub(crate) fn builtin() -> Result<Catalogue> {
    let (objects, settings) = (ppnpack_household::builtin(), Settings::default());
    let quietly = &|_: usize, _: usize| {};
    let resolution = Resolution::reference();
    Ok(Catalogue::load(&objects, &settings, &resolution, quietly)?)
}

/// Has placements pass a geometric test without a try, which takes longer than all that is
/// measured.
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
    let mut twin = Twin::new(catalogue)?;
    let measured = pack(&stack, 0, arguments, catalogue, Some(&mut twin))?;
    let what = format!("exhaustive search, evaluate = {evaluate}, one cell");
    Ok((what, measured))
}

fn with_network(arguments: &Arguments, catalogue: &Catalogue) -> Result<Row> {
    let options = untried(Options {
        has_network: true,
        evaluate: IN_PROCESS,
        ..Options::default()
    });
    let stack =
        Stack::start(&options).context("with the network; --without-network leaves it out")?;
    let measured = pack(&stack, 0, arguments, catalogue, None)?;
    Ok(("network, K = 5 %, one cell".to_owned(), measured))
}

fn four_cells(arguments: &Arguments, catalogue: &Catalogue) -> Result<Vec<Row>> {
    let cells: Vec<String> = (1..=4).map(|number| format!("cell-{number}")).collect();
    let options = untried(Options {
        cells: cells.clone(),
        evaluate: IN_PROCESS,
        ..Options::default()
    });
    let stack = Stack::start(&options)?;
    let measured: Vec<Result<Measured>> = std::thread::scope(|scope| {
        let stack = &stack;
        let pack = |cell| move || pack(stack, cell, arguments, catalogue, None);
        let threads = (0..cells.len()).map(|cell| scope.spawn(pack(cell)));
        let threads: Vec<_> = threads.collect();
        let joined = threads.into_iter().map(|thread| thread.join());
        let panicked = |_| Err(anyhow::anyhow!("a thread panicked"));
        joined
            .map(|joined| joined.unwrap_or_else(panicked))
            .collect()
    });
    let rows = cells.iter().zip(measured);
    rows.map(|(cell, measured)| {
        let what = format!("exhaustive search, {cell} of four at once");
        Ok((what, measured?))
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
        let objects = objects(arguments, catalogue, container);
        let session_id = format!("bench-{cell}-{container}");
        let measured = pack_container(&client, &session_id, &objects, twin.as_deref_mut())?;
        // The first plan of a container is like any other, but the first of all fills the caches.
        let warm_up = usize::from(container == 0);
        all.asked.extend(measured.asked.iter().skip(warm_up));
        all.in_process
            .extend(measured.in_process.iter().skip(warm_up));
        for (stage, times) in measured.stages {
            all.stages.entry(stage).or_default().extend(times);
        }
        all.degraded += measured.degraded;
    }
    Ok(all)
}

/// The objects that arrive for a container: another part of the catalogue each time, the same in
/// every row.
fn objects<'a>(arguments: &Arguments, catalogue: &'a Catalogue, container: usize) -> Vec<&'a str> {
    let names = catalogue.objects.iter().map(|object| &**object.item.name());
    let objects = names.cycle().skip(container * 17).take(arguments.objects);
    objects.collect()
}

fn print_rows(rows: Vec<Row>) {
    let mut stages = Vec::new();
    let rows = rows.into_iter().map(|(what, measured)| {
        for (stage, times) in measured.stages {
            stages.push(vec![what.clone(), stage, Times::new(times).shown(0.5)]);
        }
        let (asked, alone) = (Times::new(measured.asked), Times::new(measured.in_process));
        // The same steps planned in one process, where they were.
        let alone_ms = (alone.count() > 0).then(|| alone.percentile_ms(0.5));
        let optional = |value: Option<f64>| value.map_or("–".to_owned(), |ms| format!("{ms:.2}"));
        let mut row = vec![what, asked.count().to_string()];
        row.extend([0.5, 0.99, 1.0].map(|share| asked.shown(share)));
        row.push(optional(alone_ms));
        row.push(optional(alone_ms.map(|ms| asked.percentile_ms(0.5) - ms)));
        row.push(measured.degraded.to_string());
        row
    });
    print_table(
        "what | plans | p50 (ms) | p99 (ms) | max (ms) | in one process, p50 (ms) | added (ms) | degraded",
        rows,
    );
    println!("The planner's stages, each at its median:\n");
    print_table("what | stage | p50 (ms)", stages);
}
