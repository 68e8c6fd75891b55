//! Automatic packing over several cells for a long time, every service its own process.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow};
use clap::Args;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_service::sync::lock;
use ppnpack_wire::keys::Service;
use rand::RngExt;

use crate::bench::builtin;
use crate::cell::CellClient;
use crate::clock::Clock;
use crate::disk::Disk;
use crate::faults::Faults;
use crate::mix::{self, Kind};
use crate::packer::{Container, Packer, note_decisions};
use crate::process::Signal;
use crate::records::{self, Files};
use crate::report::{Report, Samples};
use crate::stack::{Options, Stack};

/// Packs container after container in automatic mode, and says what latency and memory were at the
/// start and at the end. Fails where anything was lost, failed or kept growing.
///
/// The first cell is plain, the second has a camera and inspects what was placed, the third has an
/// arm; the next ones begin again.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// How long, in seconds
    #[arg(long, default_value_t = 3600)]
    seconds: u64,

    /// Cells at once
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u8).range(1..))]
    cells: u8,

    /// All cells are plain
    #[arg(long)]
    plain: bool,

    /// Objects that arrive for each container
    #[arg(long, default_value_t = 60)]
    objects: usize,

    /// How long the robot takes for a placement, in seconds
    #[arg(long, default_value_t = 0.2)]
    place_duration: f64,

    /// The maximum growth of a service's memory after the first tenth, in MiB
    #[arg(long, default_value_t = 16.0)]
    growth: f64,

    /// Seconds between two faults, about: processes that are killed or stopped, cells that are
    /// held, full disks, clocks that are set; without, nothing fails
    #[arg(long, value_name = "SECONDS")]
    faults: Option<f64>,

    /// After a fault has ended, fresh requests succeed within so many seconds; more is fair where
    /// others use the machine
    #[arg(long, default_value_t = 5.0, value_name = "SECONDS")]
    recovery: f64,
}

/// Between two looks at the memory.
const LOOK: Duration = Duration::from_secs(10);

/// The disk of journal and store, in MiB: several times what an hour writes.
const DISK_MIB: u32 = 128;

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let kinds = Kind::of_cells(arguments.cells.into(), arguments.plain);
    let names = (1..).map(|number| format!("cell-{number}"));
    let cells: Vec<(String, Kind)> = names.zip(kinds).collect();
    let folder = tempfile::tempdir()?;
    let ended = soak(arguments, &cells, folder.path()).and_then(|(report, failed)| {
        report.print();
        failed.map_or_else(|| report.check(arguments.growth, arguments.recovery), Err)
    });
    if ended.is_err() {
        eprintln!("kept: {}", folder.keep().display());
    }
    ended
}

/// Gives the measurements, and the failure, if any: the ends of the containers are not known then.
fn soak(
    arguments: &Arguments,
    cells: &[(String, Kind)],
    folder: &Path,
) -> Result<(Report, Option<anyhow::Error>)> {
    let catalogue = builtin()?;
    let names: Vec<String> = cells.iter().map(|(name, _)| name.clone()).collect();
    // With nothing to fail, nothing is needed for it.
    let fails = arguments.faults.is_some();
    let written = folder.join("written");
    std::fs::create_dir(&written)?;
    let disk = fails.then(|| Disk::mount(&written, DISK_MIB)).transpose()?;
    let clock = fails.then(|| Clock::new(folder)).transpose()?.flatten();
    let files = Files::in_folder(&written);
    // Ends after the stack: disk and clock are used until then.
    let mut faults = Faults::new(disk.flatten(), clock, &files, &names);
    let mut stack = start(arguments, cells, &files, faults.environment())?;

    let start = Instant::now();
    let noted = note_decisions(&stack, start)?;
    let all = Duration::from_secs(arguments.seconds);
    let mut run = Run {
        stack: &mut stack,
        catalogue: &catalogue,
        arguments,
        start,
        all,
        samples: Samples::new(),
    };
    let packed = run.go(cells, &mut faults);
    let memory = run.samples;
    let checked = packed.and_then(|packed| {
        check_records(&mut stack, &names, &files, &packed)?;
        Ok(packed)
    });
    let (packed, failed) = match checked {
        Ok(packed) => (packed, None),
        Err(error) => {
            keep(&stack, &files, &names, folder);
            (Vec::new(), Some(error))
        }
    };
    let packed = cells.iter().zip(packed);
    let packed = packed.map(|((name, kind), packed)| (name.clone(), *kind, packed));
    let decisions = lock(&noted);
    let report = Report {
        took: start.elapsed(),
        all,
        cells: packed.collect(),
        decisions: decisions.clone(),
        faults: faults.struck().clone(),
        left_out: match fails {
            true => faults.left_out(),
            false => Vec::new(),
        },
        complaints: complaints(&stack)?,
        memory,
    };
    Ok((report, failed))
}

/// A stack of these cells that writes these files, with this environment.
fn start(
    arguments: &Arguments,
    cells: &[(String, Kind)],
    files: &Files,
    environment: Vec<(String, String)>,
) -> Result<Stack> {
    let path = |service, key, path: &Path| (service, format!("service.{key}={}", path.display()));
    let mut settings = vec![
        path(Service::Planner, "store", &files.store),
        path(Service::Bridge, "journal", &files.journal),
    ];
    settings.extend(mix::settings(cells, arguments.place_duration));
    settings.extend(mix::exact_perception(cells));
    let options = Options {
        cells: cells.iter().map(|(name, _)| name.clone()).collect(),
        settings,
        environment,
        ..Options::default()
    };
    let mut stack = Stack::start(&options)?;
    if let Some(settings) = mix::camera_perception(cells) {
        let options = Options {
            settings,
            ..options
        };
        let name = stack.add_second(Service::Perception, &options)?;
        stack.wait_ready(&name)?;
    }
    Ok(stack)
}

struct Run<'a> {
    stack: &'a mut Stack,
    catalogue: &'a Catalogue,
    arguments: &'a Arguments,
    start: Instant,
    all: Duration,
    samples: Samples,
}

impl Run<'_> {
    /// Packs in every cell until the time is over, and meanwhile looks at the memory and strikes
    /// with faults. Gives the containers of each cell.
    fn go(&mut self, cells: &[(String, Kind)], faults: &mut Faults) -> Result<Vec<Vec<Container>>> {
        let clients = (0..cells.len()).map(|cell| self.stack.cell(cell));
        let clients = clients.collect::<Result<Vec<CellClient>>>()?;
        let packers = clients.iter().zip(cells);
        let packers = packers.map(|(client, (_, kind))| Packer::new(client.clone(), *kind));
        let packers: Vec<Packer> = packers.collect();
        let names = self.catalogue.objects.iter();
        let names: Vec<&str> = names.map(|object| &**object.item.name()).collect();
        let has_failed = AtomicBool::new(false);
        let (start, all, objects) = (self.start, self.all, self.arguments.objects);
        let goes_on = || start.elapsed() < all && !has_failed.load(Ordering::Relaxed);
        std::thread::scope(|scope| {
            let pack = |cell: usize, packer: Packer| {
                let packed = pack_cell(&packer, &names, objects, cell, &goes_on);
                if let Err(error) = &packed {
                    eprintln!("\ncell-{}: {error:#}", cell + 1);
                    has_failed.store(true, Ordering::Relaxed);
                }
                packed
            };
            let packers = packers.into_iter().enumerate();
            let threads: Vec<_> = packers
                .map(|(cell, packer)| scope.spawn(move || pack(cell, packer)))
                .collect();
            let watched = self.watch(&clients, faults, &goes_on);
            has_failed.fetch_or(watched.is_err(), Ordering::Relaxed);
            eprintln!();
            let packed = threads.into_iter().map(|thread| {
                let packed = thread.join();
                packed.map_err(|_| anyhow!("a thread panicked"))?
            });
            let packed = packed.collect::<Result<_>>();
            watched.and(packed)
        })
    }

    fn watch(
        &mut self,
        clients: &[CellClient],
        faults: &mut Faults,
        goes_on: &dyn Fn() -> bool,
    ) -> Result<()> {
        let mut next_look = Instant::now();
        while goes_on() {
            if next_look <= Instant::now() {
                self.sample()?;
                next_look += LOOK;
            }
            let left = self.all.saturating_sub(self.start.elapsed());
            eprint!("\r{:.0} s left  ", left.as_secs_f64());
            match self.arguments.faults {
                None => std::thread::sleep(LOOK.min(left)),
                Some(seconds) => {
                    let pause = seconds * rand::rng().random_range(0.5..1.5);
                    std::thread::sleep(Duration::try_from_secs_f64(pause)?.min(left));
                    faults
                        .strike(self.stack, clients)
                        .context("after a fault")?;
                }
            }
        }
        Ok(())
    }

    fn sample(&mut self) -> Result<()> {
        for name in self.stack.names() {
            let sample = (self.start.elapsed(), self.stack.resident_mib(name)?);
            self.samples
                .entry(name.to_owned())
                .or_default()
                .push(sample);
        }
        Ok(())
    }
}

fn pack_cell(
    packer: &Packer,
    names: &[&str],
    objects: usize,
    cell: usize,
    goes_on: &dyn Fn() -> bool,
) -> Result<Vec<Container>> {
    let mut packed = Vec::new();
    while goes_on() {
        let container = packed.len();
        let names = names.iter().copied().cycle();
        let names = names.skip(container * 17 + cell * 5);
        let objects: Vec<&str> = names.take(objects).collect();
        packed.push(packer.pack(&format!("soak-{cell}-{container}"), &objects)?);
    }
    Ok(packed)
}

/// Compares the planner's containers with journal and store, read without bridge and planner.
fn check_records(
    stack: &mut Stack,
    cells: &[String],
    files: &Files,
    packed: &[Vec<Container>],
) -> Result<()> {
    for name in ["planner-1", "bridge-1"] {
        stack.signal(name, Signal::SIGTERM)?;
    }
    let mut cells = cells.iter().zip(packed);
    cells.try_for_each(|(cell, packed)| records::check_ended(files, cell, packed))
}

/// Keeps logs, journal and store of a run that failed; what cannot be kept is left out.
fn keep(stack: &Stack, files: &Files, cells: &[String], folder: &Path) {
    drop(files.copied(folder, cells));
    for name in stack.names() {
        let log = stack.log(name).unwrap_or_default();
        drop(std::fs::write(folder.join(format!("{name}.log")), log));
    }
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
