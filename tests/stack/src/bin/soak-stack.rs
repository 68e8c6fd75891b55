//! `soak-stack`: automatic packing over several cells for a long time, every service its own process.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::PoisonError;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Result, ensure};
use clap::Parser;
use ppnpack_catalogue::catalogue::{Catalogue, Settings};
use ppnpack_packing::grid::Resolution;
use ppnpack_stack_tests::cell::CellClient;
use ppnpack_stack_tests::faults::{Faults, strike};
use ppnpack_stack_tests::latency::Times;
use ppnpack_stack_tests::soak::{Decided, note_decisions, pack_container};
use ppnpack_stack_tests::{Options, Signal, Stack, records};
use ppnpack_wire::keys::Service;
use rand::RngExt;
use serde::Serialize;

/// Packs container after container in automatic mode, and says what latency and memory were at the start and at the
/// end. Fails where anything was lost, failed or kept growing.
#[derive(Debug, Parser)]
struct Arguments {
    /// How long, in seconds
    #[arg(long, default_value_t = 3600)]
    seconds: u64,

    /// Cells at once
    #[arg(long, default_value_t = 4)]
    cells: usize,

    /// Objects that arrive for each container
    #[arg(long, default_value_t = 60)]
    objects: usize,

    /// How long the robot takes for a placement, in seconds
    #[arg(long, default_value_t = 0.2)]
    place_duration: f64,

    /// What a service's memory may grow by after the first tenth, in MiB
    #[arg(long, default_value_t = 16.0)]
    growth: f64,

    /// Seconds between two faults, about: processes that are killed or stopped, cells that are held; without, nothing fails
    #[arg(long, value_name = "SECONDS")]
    faults: Option<f64>,

    /// Print JSON instead of tables
    #[arg(long)]
    json: bool,
}

/// Between two looks at the memory.
const LOOK: Duration = Duration::from_secs(10);

/// After a fault has ended, fresh requests succeed within so many seconds.
const RECOVERY_S: f64 = 5.0;

#[derive(Debug, Serialize)]
struct Report {
    seconds: f64,
    cells: usize,
    containers: usize,
    items: usize,
    degraded: usize,
    /// What was done to the stack.
    faults: Faults,
    /// Lines of the logs that warn or tell of an error, per process.
    complaints: BTreeMap<String, usize>,
    /// Decision times of each tenth of the time.
    decisions: Vec<Tenth>,
    /// Per process, in MiB.
    memory: BTreeMap<String, Memory>,
}

#[derive(Debug, Serialize)]
struct Tenth {
    decisions: usize,
    p50_ms: f64,
    p99_ms: f64,
    max_ms: f64,
}

/// What a process had in memory: the mean of each tenth of the time.
#[derive(Debug, Serialize)]
struct Memory {
    tenths_mib: Vec<f64>,
    max_mib: f64,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let catalogue = Catalogue::load(
        &ppnpack_household::builtin(),
        &Settings::default(),
        &Resolution::reference(),
        &|_, _| {},
    )?;
    let cells: Vec<String> = (1..=arguments.cells)
        .map(|number| format!("cell-{number}"))
        .collect();
    let robots = cells.iter().map(|cell| {
        let duration = arguments.place_duration;
        (
            Service::Bridge,
            format!("service.cells.{cell}.place_duration_s={duration:?}"),
        )
    });
    let mut stack = Stack::start(&Options {
        cells: cells.clone(),
        settings: robots.collect(),
        ..Options::default()
    })?;
    let start = Instant::now();
    let noted = note_decisions(&stack, start)?;
    let all = Duration::from_secs(arguments.seconds);
    let clients = (0..cells.len()).map(|cell| stack.cell(cell));
    let clients = clients.collect::<Result<Vec<CellClient>>>()?;
    let ran = run(&mut stack, &clients, &catalogue, &arguments, start, all)?;
    let complaints = complaints(&stack)?;
    stack.signal("bridge-1", Signal::Terminate)?;
    check_records(&stack, &cells, &ran.packed)?;
    let decisions = noted.lock().unwrap_or_else(PoisonError::into_inner).clone();
    let seconds = start.elapsed();
    let containers = ran.packed.iter().flatten();
    let memory: BTreeMap<String, Memory> = ran
        .samples
        .into_iter()
        .map(|(name, samples)| (name, Memory::new(&samples, all)))
        .collect();
    let report = Report {
        seconds: seconds.as_secs_f64(),
        cells: cells.len(),
        containers: containers.clone().count(),
        items: containers.map(BTreeSet::len).sum(),
        degraded: decisions
            .iter()
            .filter(|decided| decided.is_degraded)
            .count(),
        faults: ran.faults,
        complaints,
        decisions: (0..10)
            .map(|tenth| Tenth::new(&decisions, all, tenth))
            .collect(),
        memory,
    };
    match arguments.json {
        true => println!("{}", serde_json::to_string_pretty(&report)?),
        false => print_tables(&report),
    }
    for (name, memory) in &report.memory {
        let (first, last) = (memory.tenths_mib.first(), memory.tenths_mib.last());
        let grown = last.zip(first).map_or(0.0, |(last, first)| last - first);
        ensure!(grown <= arguments.growth, "{name} grew by {grown:.1} MiB");
    }
    let most_s = report.faults.values().map(|fault| fault.longest_s);
    let most_s = most_s.fold(0.0, f64::max);
    ensure!(
        most_s <= RECOVERY_S,
        "once it took {most_s:.1} s to serve again"
    );
    ensure!(
        arguments.faults.is_some() || report.degraded == 0,
        "{} decisions were degraded",
        report.degraded
    );
    Ok(())
}

type Samples = BTreeMap<String, Vec<(Duration, f64)>>;

/// The items of each container.
type Packed = Vec<BTreeSet<String>>;

/// What came of it.
struct Ran {
    /// Per cell.
    packed: Vec<Packed>,
    /// The memory of each process.
    samples: Samples,
    faults: Faults,
}

/// Packs in every cell until the time is over; looks at the memory, and lets things fail, meanwhile.
fn run(
    stack: &mut Stack,
    clients: &[CellClient],
    catalogue: &Catalogue,
    arguments: &Arguments,
    start: Instant,
    all: Duration,
) -> Result<Ran> {
    let has_failed = AtomicBool::new(false);
    let goes_on = || start.elapsed() < all && !has_failed.load(Ordering::Relaxed);
    std::thread::scope(|scope| {
        let pack = |cell: usize, client: &CellClient| {
            let packed = pack_cell(client, catalogue, arguments, cell, &goes_on);
            if let Err(error) = &packed {
                eprintln!("\ncell {cell}: {error:#}");
                has_failed.store(true, Ordering::Relaxed);
            }
            packed
        };
        let clients_of = clients.iter().enumerate();
        let threads: Vec<_> = clients_of
            .map(|(cell, client)| scope.spawn(move || pack(cell, client)))
            .collect();
        let mut samples = Samples::new();
        let mut faults = Faults::new();
        let mut next_look = Instant::now();
        while goes_on() {
            if next_look <= Instant::now() {
                sample(stack, start, &mut samples)?;
                next_look += LOOK;
            }
            let left = all.saturating_sub(start.elapsed());
            eprint!("\r{:.0} s left  ", left.as_secs_f64());
            match arguments.faults {
                None => std::thread::sleep(LOOK.min(left)),
                Some(seconds) => {
                    let pause = seconds * rand::rng().random_range(0.5..1.5);
                    std::thread::sleep(Duration::try_from_secs_f64(pause)?.min(left));
                    let struck = strike(stack, clients, &mut faults);
                    has_failed.fetch_or(struck.is_err(), Ordering::Relaxed);
                    struck?;
                }
            }
        }
        eprintln!();
        let mut packed = Vec::new();
        for thread in threads {
            let of_cell = thread
                .join()
                .map_err(|_| anyhow::anyhow!("a thread panicked"))?;
            packed.push(of_cell?);
        }
        Ok(Ran {
            packed,
            samples,
            faults,
        })
    })
}

fn sample(stack: &Stack, start: Instant, samples: &mut Samples) -> Result<()> {
    for name in stack.names() {
        let sample = (start.elapsed(), stack.resident_mib(name)?);
        samples.entry(name.to_owned()).or_default().push(sample);
    }
    Ok(())
}

fn pack_cell(
    client: &CellClient,
    catalogue: &Catalogue,
    arguments: &Arguments,
    cell: usize,
    goes_on: &dyn Fn() -> bool,
) -> Result<Packed> {
    let names: Vec<&str> = catalogue
        .objects
        .iter()
        .map(|object| &**object.item.name())
        .collect();
    let mut packed = Packed::new();
    while goes_on() {
        let container = packed.len();
        let objects = names
            .iter()
            .copied()
            .cycle()
            .skip(container * 17 + cell * 5);
        let objects: Vec<&str> = objects.take(arguments.objects).collect();
        packed.push(pack_container(
            client,
            &format!("soak-{cell}-{container}"),
            &objects,
        )?);
    }
    Ok(packed)
}

/// Compares what the planner acknowledged with what the bridge's journal says, read without the bridge. Where it has forgotten
/// the first containers, the last ones.
fn check_records(stack: &Stack, cells: &[String], packed: &[Packed]) -> Result<()> {
    let journal = stack.folder().join("bridge.redb");
    for (cell, packed) in cells.iter().zip(packed) {
        let recorded = records::containers(&journal, cell)?;
        let recorded = recorded.iter().map(|items| items.iter().cloned().collect());
        let recorded: Packed = recorded.collect();
        let packed: Vec<_> = packed.iter().filter(|items| !items.is_empty()).collect();
        // The first that is left may be known in part.
        let known = recorded.len().saturating_sub(1).min(packed.len());
        let last = |count: usize| count - known;
        let is_same = recorded
            .iter()
            .skip(last(recorded.len()))
            .eq(packed.iter().copied().skip(last(packed.len())));
        ensure!(
            known > 0 && is_same,
            "{cell}: the journal does not say what was acknowledged"
        );
    }
    Ok(())
}

fn complaints(stack: &Stack) -> Result<BTreeMap<String, usize>> {
    let count = |name: &str| {
        let log = stack.log(name)?;
        let is_complaint = |line: &&str| {
            line.contains(" WARN ")
                || line.contains("ERROR ")
                || line.contains("\"level\":\"WARN\"")
        };
        Ok((name.to_owned(), log.lines().filter(is_complaint).count()))
    };
    stack.names().map(count).collect()
}

fn tenth_of(at: Duration, all: Duration) -> usize {
    ((at.as_secs_f64() / all.as_secs_f64() * 10.0) as usize).min(9)
}

impl Tenth {
    fn new(decisions: &[Decided], all: Duration, tenth: usize) -> Self {
        let of_tenth = decisions
            .iter()
            .filter(|decided| tenth_of(decided.at, all) == tenth);
        let times = Times::new(of_tenth.map(|decided| decided.took).collect());
        Self {
            decisions: times.count(),
            p50_ms: times.percentile_ms(0.5),
            p99_ms: times.percentile_ms(0.99),
            max_ms: times.percentile_ms(1.0),
        }
    }
}

impl Memory {
    fn new(samples: &[(Duration, f64)], all: Duration) -> Self {
        let mean = |tenth: usize| {
            let of_tenth = samples.iter().filter(|(at, _)| tenth_of(*at, all) == tenth);
            let of_tenth: Vec<f64> = of_tenth.map(|(_, mib)| *mib).collect();
            of_tenth.iter().sum::<f64>() / of_tenth.len().max(1) as f64
        };
        Self {
            tenths_mib: (0..10).map(mean).collect(),
            max_mib: samples.iter().map(|(_, mib)| *mib).fold(0.0, f64::max),
        }
    }
}

fn print_tables(report: &Report) {
    println!(
        "{} containers with {} items in {} cells, {:.0} s; {} decisions degraded.\n",
        report.containers, report.items, report.cells, report.seconds, report.degraded
    );
    print_faults(&report.faults);
    println!("| tenth of the time | decisions | p50 (ms) | p99 (ms) | max (ms) |");
    println!("|---|---|---|---|---|");
    for (index, tenth) in report.decisions.iter().enumerate() {
        println!(
            "| {} | {} | {:.2} | {:.2} | {:.2} |",
            index + 1,
            tenth.decisions,
            tenth.p50_ms,
            tenth.p99_ms,
            tenth.max_ms
        );
    }
    println!("\n| process | first tenth (MiB) | fifth | last | most | warnings and errors |");
    println!("|---|---|---|---|---|---|");
    for (name, memory) in &report.memory {
        let tenth = |index: usize| memory.tenths_mib.get(index).copied().unwrap_or(f64::NAN);
        let complaints = report.complaints.get(name).copied().unwrap_or_default();
        println!(
            "| {name} | {:.1} | {:.1} | {:.1} | {:.1} | {complaints} |",
            tenth(0),
            tenth(4),
            tenth(9),
            memory.max_mib
        );
    }
}

fn print_faults(faults: &Faults) {
    if faults.is_empty() {
        return;
    }
    println!("| fault | times | served again after, at most (s) |");
    println!("|---|---|---|");
    for (what, recovered) in faults {
        println!(
            "| {what} | {} | {:.2} |",
            recovered.count, recovered.longest_s
        );
    }
    println!();
}
