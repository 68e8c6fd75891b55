//! The results of a long run, as tables.

use std::collections::BTreeMap;
use std::time::Duration;

use anyhow::{Result, ensure};

use crate::faults::Struck;
use crate::latency::Times;
use crate::mix::Kind;
use crate::packer::{Container, Decided};

/// The memory of each process at some moments since the start, in MiB.
pub(crate) type Samples = BTreeMap<String, Vec<(Duration, f64)>>;

pub(crate) struct Report {
    /// The time that it took.
    pub(crate) took: Duration,
    /// The time that it was to take; decisions and memory are told by tenths of it.
    pub(crate) all: Duration,
    /// The containers of each cell; none where the run failed, as their ends are not known then.
    pub(crate) cells: Vec<(String, Kind, Vec<Container>)>,
    pub(crate) decisions: Vec<Decided>,
    pub(crate) faults: Struck,
    /// The faults that were not possible here, and why.
    pub(crate) left_out: Vec<&'static str>,
    /// The number of warnings and errors in each process's log.
    pub(crate) complaints: BTreeMap<String, usize>,
    pub(crate) memory: Samples,
}

impl Report {
    /// Decisions that were made in another way than was asked for.
    fn degraded(&self) -> usize {
        let degraded = self.decisions.iter().filter(|decided| decided.is_degraded);
        degraded.count()
    }

    fn tenth_of(&self, at: Duration) -> usize {
        ((at.as_secs_f64() / self.all.as_secs_f64() * 10.0) as usize).min(9)
    }

    /// The mean memory of a process in each tenth of the time, in MiB.
    fn tenths_mib(&self, samples: &[(Duration, f64)]) -> [f64; 10] {
        std::array::from_fn(|tenth| {
            let of_tenth = samples.iter().filter(|(at, _)| self.tenth_of(*at) == tenth);
            let of_tenth: Vec<f64> = of_tenth.map(|(_, mib)| *mib).collect();
            of_tenth.iter().sum::<f64>() / of_tenth.len().max(1) as f64
        })
    }

    /// Checks that no memory grew by more than so many MiB, all served again within so many
    /// seconds, and nothing was degraded without faults.
    ///
    /// # Errors
    /// The first that is not so.
    pub(crate) fn check(&self, most_growth_mib: f64, recovery_s: f64) -> Result<()> {
        for (name, samples) in &self.memory {
            let [first_mib, .., last_mib] = self.tenths_mib(samples);
            let grown_mib = last_mib - first_mib;
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
        let degraded = self.degraded();
        ensure!(
            !self.faults.is_empty() || degraded == 0,
            "{degraded} decisions were degraded"
        );
        Ok(())
    }

    pub(crate) fn print(&self) {
        let containers = || self.cells.iter().flat_map(|(.., containers)| containers);
        let (took_s, degraded) = (self.took.as_secs_f64(), self.degraded());
        if self.cells.is_empty() {
            println!("It failed after {took_s:.0} s: what became of the containers is not known.");
        } else {
            println!(
                "{} containers with {} items in {} cells, {took_s:.0} s.",
                containers().count(),
                containers().map(|it| it.packed.len()).sum::<usize>(),
                self.cells.len(),
            );
        }
        println!("{degraded} decisions degraded.\n");
        print_table(
            "cell | containers | items | missing | left the cell | failures acknowledged | set aside",
            self.cells.iter().map(|(name, kind, containers)| {
                let sum = |of: fn(&Container) -> usize| {
                    let sum: usize = containers.iter().map(of).sum();
                    sum.to_string()
                };
                vec![
                    format!("{name}, {kind:?}"),
                    containers.len().to_string(),
                    sum(|container| container.packed.len()),
                    sum(|container| container.missing.len()),
                    sum(|container| container.lost.len()),
                    sum(|container| container.acknowledged),
                    sum(|container| container.set_aside),
                ]
            }),
        );
        for left_out in &self.left_out {
            println!("Left out: {left_out}.\n");
        }
        print_table(
            "fault | times | served again after, at most (s) | waited for",
            self.faults.iter().map(|(what, recovered)| {
                vec![
                    what.clone(),
                    recovered.count.to_string(),
                    format!("{:.2}", recovered.longest_s),
                    recovered.waited_for.to_owned(),
                ]
            }),
        );
        print_table(
            "tenth of the time | decisions | p50 (ms) | p99 (ms) | max (ms)",
            (0..10).map(|tenth| {
                let decisions = self.decisions.iter();
                let of_tenth = decisions.filter(|it| self.tenth_of(it.at) == tenth);
                let times = Times::new(of_tenth.map(|decided| decided.took).collect());
                let mut row = vec![(tenth + 1).to_string(), times.count().to_string()];
                row.extend([0.5, 0.99, 1.0].map(|share| times.shown(share)));
                row
            }),
        );
        print_table(
            "process | first tenth (MiB) | fifth | last | most | warnings and errors",
            self.memory.iter().map(|(name, samples)| {
                let [first, _, _, _, fifth, .., last] = self.tenths_mib(samples);
                let most = samples.iter().map(|(_, mib)| *mib).fold(0.0, f64::max);
                let complaints = self.complaints.get(name).copied().unwrap_or_default();
                let mut row = vec![name.clone()];
                row.extend([first, fifth, last, most].map(|mib| format!("{mib:.1}")));
                row.push(complaints.to_string());
                row
            }),
        );
    }
}

/// Prints a table, as pages of results have it, where it has rows.
pub(crate) fn print_table(header: &str, rows: impl IntoIterator<Item = Vec<String>>) {
    let mut rows = rows.into_iter().peekable();
    if rows.peek().is_none() {
        return;
    }
    println!("| {header} |");
    println!("|{}", "---|".repeat(header.split('|').count()));
    for row in rows {
        println!("| {} |", row.join(" | "));
    }
    println!();
}
