//! What a long run comes to: as JSON, or as tables.

use std::collections::BTreeMap;
use std::time::Duration;

use anyhow::{Result, ensure};
use serde::Serialize;

use crate::faults::{Recovered, Struck};
use crate::latency::Times;
use crate::mix::Kind;
use crate::soak::{Container, Decided};

/// The memory of each process at some moments since the start, in MiB.
pub type Samples = BTreeMap<String, Vec<(Duration, f64)>>;

/// What a long run comes to.
#[derive(Debug, Serialize)]
pub struct Report {
    /// How long it took.
    pub seconds: f64,
    /// What was packed, per cell.
    pub cells: BTreeMap<String, Packed>,
    /// Decisions that were made in another way than was asked for.
    pub degraded: usize,
    /// What was done to the stack.
    pub faults: Struck,
    /// What could not be done to it here, and why.
    pub left_out: Vec<&'static str>,
    /// Lines of the logs that warn or tell of an error, per process.
    pub complaints: BTreeMap<String, usize>,
    /// Decision times of each tenth of the time.
    pub decisions: Vec<Tenth>,
    /// Per process, in MiB.
    pub memory: BTreeMap<String, Memory>,
}

/// What was packed in a cell.
#[derive(Debug, Serialize)]
pub struct Packed {
    /// What the cell is.
    pub kind: Kind,
    /// How many containers.
    pub containers: usize,
    /// How many items.
    pub items: usize,
    /// Items that the inspection did not find.
    pub missing: usize,
    /// Items that left the cell.
    pub lost: usize,
    /// Times that the automatic mode failed for one of these, and that was acknowledged.
    pub acknowledged: usize,
    /// Items that were set aside.
    pub set_aside: usize,
    /// Items of which was not seen what they are.
    pub unrecognised: usize,
}

/// Decisions of a tenth of the time.
#[derive(Debug, Serialize)]
pub struct Tenth {
    decisions: usize,
    p50_ms: f64,
    p99_ms: f64,
    max_ms: f64,
}

/// What a process had in memory: the mean of each tenth of the time.
#[derive(Debug, Serialize)]
pub struct Memory {
    tenths_mib: Vec<f64>,
    max_mib: f64,
}

impl Packed {
    /// All that was packed in a cell.
    pub fn new(kind: Kind, containers: &[Container]) -> Self {
        let sum = |of: fn(&Container) -> usize| containers.iter().map(of).sum();
        Self {
            kind,
            containers: containers.len(),
            items: sum(|container| container.packed.len()),
            missing: sum(|container| container.missing.len()),
            lost: sum(|container| container.lost.len()),
            acknowledged: sum(|container| container.acknowledged),
            set_aside: sum(|container| container.set_aside),
            unrecognised: sum(|container| container.unrecognised),
        }
    }
}

impl Tenth {
    /// The tenths of a run that took so long.
    pub fn all(decisions: &[Decided], all: Duration) -> Vec<Self> {
        (0..10)
            .map(|tenth| Self::new(decisions, all, tenth))
            .collect()
    }

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
    /// The memory of each process in a run that took so long.
    pub fn all(samples: &Samples, all: Duration) -> BTreeMap<String, Self> {
        let samples = samples.iter();
        samples
            .map(|(name, samples)| (name.clone(), Self::new(samples, all)))
            .collect()
    }

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

    fn grown_mib(&self) -> f64 {
        let (first, last) = (self.tenths_mib.first(), self.tenths_mib.last());
        last.zip(first).map_or(0.0, |(last, first)| last - first)
    }
}

fn tenth_of(at: Duration, all: Duration) -> usize {
    ((at.as_secs_f64() / all.as_secs_f64() * 10.0) as usize).min(9)
}

impl Report {
    /// Checks that nothing kept growing by more than so many MiB, all served again within so many seconds, and without faults
    /// nothing was degraded.
    ///
    /// # Errors
    /// The first that is not so.
    pub fn check(&self, most_growth_mib: f64, recovery_s: f64) -> Result<()> {
        for (name, memory) in &self.memory {
            let grown_mib = memory.grown_mib();
            ensure!(
                grown_mib <= most_growth_mib,
                "{name} grew by {grown_mib:.1} MiB"
            );
        }
        for (what, recovered) in &self.faults {
            let longest_s = recovered.longest_s;
            ensure!(
                longest_s <= recovery_s,
                "{what}: once it took {longest_s:.1} s to serve again, the longest of it {}",
                recovered.waited_for
            );
        }
        ensure!(
            !self.faults.is_empty() || self.degraded == 0,
            "{} decisions were degraded",
            self.degraded
        );
        Ok(())
    }

    /// Prints it as tables.
    pub fn print(&self) {
        self.print_cells();
        self.print_faults();
        self.print_decisions();
        self.print_memory();
    }

    fn print_cells(&self) {
        if self.cells.is_empty() {
            println!(
                "It failed after {:.0} s: what became of the containers is not known. {} decisions degraded.",
                self.seconds, self.degraded
            );
            return;
        }
        let sum = |of: fn(&Packed) -> usize| self.cells.values().map(of).sum::<usize>();
        println!(
            "{} containers with {} items in {} cells, {:.0} s; {} decisions degraded.\n",
            sum(|cell| cell.containers),
            sum(|cell| cell.items),
            self.cells.len(),
            self.seconds,
            self.degraded
        );
        println!(
            "| cell | containers | items | missing | left the cell | failures acknowledged | set aside | not recognised |"
        );
        println!("|---|---|---|---|---|---|---|---|");
        for (name, cell) in &self.cells {
            println!(
                "| {name}, {:?} | {} | {} | {} | {} | {} | {} | {} |",
                cell.kind,
                cell.containers,
                cell.items,
                cell.missing,
                cell.lost,
                cell.acknowledged,
                cell.set_aside,
                cell.unrecognised
            );
        }
        println!();
    }

    fn print_faults(&self) {
        for left_out in &self.left_out {
            println!("Left out: {left_out}.\n");
        }
        if self.faults.is_empty() {
            return;
        }
        println!("| fault | times | served again after, at most (s) | waited for |");
        println!("|---|---|---|---|");
        for (what, recovered) in &self.faults {
            let Recovered {
                count,
                longest_s,
                waited_for,
            } = recovered;
            println!("| {what} | {count} | {longest_s:.2} | {waited_for} |");
        }
        println!();
    }

    fn print_decisions(&self) {
        println!("| tenth of the time | decisions | p50 (ms) | p99 (ms) | max (ms) |");
        println!("|---|---|---|---|---|");
        for (index, tenth) in self.decisions.iter().enumerate() {
            println!(
                "| {} | {} | {:.2} | {:.2} | {:.2} |",
                index + 1,
                tenth.decisions,
                tenth.p50_ms,
                tenth.p99_ms,
                tenth.max_ms
            );
        }
        println!();
    }

    fn print_memory(&self) {
        println!("| process | first tenth (MiB) | fifth | last | most | warnings and errors |");
        println!("|---|---|---|---|---|---|");
        for (name, memory) in &self.memory {
            let tenth = |index: usize| memory.tenths_mib.get(index).copied().unwrap_or(f64::NAN);
            let complaints = self.complaints.get(name).copied().unwrap_or_default();
            println!(
                "| {name} | {:.1} | {:.1} | {:.1} | {:.1} | {complaints} |",
                tenth(0),
                tenth(4),
                tenth(9),
                memory.max_mib
            );
        }
    }
}
