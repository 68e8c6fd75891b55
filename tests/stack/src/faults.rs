//! Faults at random, while a stack packs.

use std::collections::BTreeMap;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1;
use rand::RngExt;
use rand::seq::IndexedRandom;

use crate::cell::CellClient;
use crate::clock::{self, Clock};
use crate::disk::Disk;
use crate::process::Signal;
use crate::records::{self, Files};
use crate::stack::Stack;

/// The maximum time for which a process is stopped, a disk full or a cell held.
const LONGEST: Duration = Duration::from_secs(3);

/// The time to wait for an answer before a service is asked afresh.
const ASKED_AGAIN: Duration = Duration::from_secs(1);

const PAUSE: Duration = Duration::from_millis(10);

/// The time after which a service counts as dead.
const GIVEN_UP: Duration = Duration::from_secs(60);

/// The instances that write to the disk.
const WRITERS: [&str; 2] = ["bridge-1", "planner-1"];

const FAULTS: [(Fault, u32); 6] = [
    (Fault::Kill, 10),
    (Fault::Stop, 6),
    (Fault::Hold, 4),
    (Fault::Disk, 4),
    (Fault::Clock, 3),
    (Fault::KillAll, 1),
];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fault {
    /// A process is killed and started again.
    Kill,
    /// All processes are killed at once and started again; between, journal and store are read.
    KillAll,
    /// A process is stopped for a while.
    Stop,
    /// A cell is held for a while, and somebody has a hand in it.
    Hold,
    /// The disk of journal and store is full for a while; now and then a writer is killed
    /// meanwhile.
    Disk,
    /// The clock is set, and the next time put back.
    Clock,
}

/// The times that a fault struck, and the longest until fresh requests to all services succeeded.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Recovered {
    pub(crate) count: usize,
    /// The longest, in seconds.
    pub(crate) longest_s: f64,
    /// The service that was waited for the longest then.
    pub(crate) waited_for: &'static str,
}

/// The faults that struck a stack, by name.
pub(crate) type Struck = BTreeMap<String, Recovered>;

pub(crate) struct Faults {
    /// The disk of journal and store; `None` where it cannot be filled.
    disk: Option<Disk>,
    /// The clock of the services; `None` where it cannot be set.
    clock: Option<Clock>,
    files: Files,
    cells: Vec<String>,
    is_clock_off: bool,
    struck: Struck,
}

impl Faults {
    /// Faults for a stack of these cells that writes these files.
    pub(crate) fn new(
        disk: Option<Disk>,
        clock: Option<Clock>,
        files: &Files,
        cells: &[String],
    ) -> Self {
        Self {
            disk,
            clock,
            files: files.clone(),
            cells: cells.to_owned(),
            is_clock_off: false,
            struck: Struck::new(),
        }
    }

    pub(crate) fn environment(&self) -> Vec<(String, String)> {
        let clock = self.clock.as_ref();
        clock.map(Clock::environment).unwrap_or_default()
    }

    pub(crate) fn struck(&self) -> &Struck {
        &self.struck
    }

    /// The faults that are not possible here, and why.
    pub(crate) fn left_out(&self) -> Vec<&'static str> {
        let disk = "full disks: mounting a file system needs root";
        let clock = "clock steps: libfaketime is not there";
        let left_out = [
            self.disk.is_none().then_some(disk),
            self.clock.is_none().then_some(clock),
        ];
        left_out.into_iter().flatten().collect()
    }

    /// Strikes the stack with a fault, and waits until it serves again.
    ///
    /// # Errors
    /// Where it does not, or was killed and left files that disagree.
    pub(crate) fn strike(&mut self, stack: &mut Stack, cells: &[CellClient]) -> Result<()> {
        let is_possible = |fault: &Fault| match fault {
            Fault::Disk => self.disk.is_some(),
            Fault::Clock => self.clock.is_some(),
            _ => true,
        };
        let possible: Vec<_> = FAULTS
            .iter()
            .filter(|(fault, _)| is_possible(fault))
            .collect();
        let mut random = rand::rng();
        let (fault, _) = possible.choose_weighted(&mut random, |(_, weight)| *weight)?;
        let what = match fault {
            Fault::Kill => kill(stack)?,
            Fault::KillAll => self.kill_all(stack)?,
            Fault::Stop => stop(stack)?,
            Fault::Hold => hold(cells.choose(&mut random).context("there are no cells")?)?,
            Fault::Disk => self.fill(stack)?,
            Fault::Clock => self.set_clock()?,
        };
        let ended = Instant::now();
        let waits = cells.iter().map(|cell| {
            let waits = waits_of(cell);
            waits.with_context(|| format!("{what}, then {}", cell.cell()))
        });
        let waits = waits.collect::<Result<Vec<_>>>()?;
        let longest = waits.into_iter().flatten().max_by_key(|(_, wait)| *wait);
        let took_s = ended.elapsed().as_secs_f64();
        let recovered = self.struck.entry(what).or_default();
        recovered.count += 1;
        if took_s > recovered.longest_s {
            recovered.longest_s = took_s;
            recovered.waited_for = longest.map_or("", |(service, _)| service);
        }
        Ok(())
    }

    fn kill_all(&self, stack: &mut Stack) -> Result<String> {
        let names: Vec<String> = stack.names().map(str::to_owned).collect();
        for name in &names {
            stack.signal(name, Signal::SIGKILL)?;
        }
        records::check_killed(&self.files, &self.cells)?;
        for name in &names {
            stack.restart(name)?;
        }
        Ok("all killed at once".to_owned())
    }

    fn fill(&self, stack: &mut Stack) -> Result<String> {
        let disk = self.disk.as_ref().context("there is no disk to fill")?;
        disk.fill()?;
        thread::sleep(span());
        let killed = rand::rng().random_bool(0.5).then(|| any(&WRITERS));
        let killed = killed.transpose()?;
        if let Some(name) = killed {
            stack.signal(name, Signal::SIGKILL)?;
        }
        disk.free()?;
        match killed {
            None => Ok("a disk full".to_owned()),
            Some(name) => {
                stack.restart(name)?;
                Ok(format!("a disk full, {name} killed meanwhile"))
            }
        }
    }

    fn set_clock(&mut self) -> Result<String> {
        let clock = self.clock.as_ref().context("there is no clock to set")?;
        let is_put_back = self.is_clock_off;
        self.is_clock_off = !is_put_back;
        let step = if is_put_back {
            clock::TRUE
        } else {
            any(&clock::STEPS)?
        };
        clock.step(step)?;
        Ok(match is_put_back {
            true => "the clock put back".to_owned(),
            false => format!("the clock set by {step}"),
        })
    }
}

/// Measures the time that each service takes to answer for a cell.
fn waits_of(cell: &CellClient) -> Result<[(&'static str, Duration); 3]> {
    let begun = Instant::now();
    ask_afresh(cell, &v1::SessionRequest::default()).context("the planner")?;
    let planner = begun.elapsed();
    ask_afresh(cell, &v1::CellStateRequest::default()).context("the bridge")?;
    let bridge = begun.elapsed();
    ask_afresh(cell, &v1::HeightmapRequest::default()).context("perception")?;
    let perception = begun.elapsed();
    Ok([
        ("planner", planner),
        ("bridge", bridge - planner),
        ("perception", perception - bridge),
    ])
}

/// Asks until it is answered: requests on their way through a router that was killed are lost, and
/// a service that has just begun refuses them.
fn ask_afresh<R: Request + Clone>(cell: &CellClient, request: &R) -> Result<()> {
    let until = Instant::now() + GIVEN_UP;
    loop {
        match cell.ask_within(request.clone(), ASKED_AGAIN) {
            Err(_) if Instant::now() < until => thread::sleep(PAUSE),
            answered => return answered.map(|_| ()).map_err(Into::into),
        }
    }
}

fn span() -> Duration {
    LONGEST.mul_f64(rand::rng().random_range(0.1..1.0))
}

fn any<T: Copy>(of: &[T]) -> Result<T> {
    let one = of.choose(&mut rand::rng());
    one.copied().context("there is nothing to choose from")
}

fn any_process(stack: &Stack) -> Result<String> {
    let names: Vec<&str> = stack.names().collect();
    Ok(any(&names)?.to_owned())
}

fn kill(stack: &mut Stack) -> Result<String> {
    let name = any_process(stack)?;
    stack.kill(&name)?;
    Ok(format!("{name} killed"))
}

fn stop(stack: &mut Stack) -> Result<String> {
    let name = any_process(stack)?;
    stack.signal(&name, Signal::SIGSTOP)?;
    thread::sleep(span());
    stack.signal(&name, Signal::SIGCONT)?;
    Ok(format!("{name} stopped"))
}

/// Holds a cell for a while, waits until its robot stands, says that there was a hand in it, and
/// lets it go on.
fn hold(cell: &CellClient) -> Result<String> {
    cell.hold("a hand is in the cell")?;
    while !cell.state()?.executing_placement_id.is_empty() {
        thread::sleep(Duration::from_millis(20));
    }
    thread::sleep(span());
    cell.patiently(|cell| Ok(cell.ask(v1::ChangedRequest::default())?))?;
    cell.resume()?;
    Ok("a cell held, a hand in it".to_owned())
}
