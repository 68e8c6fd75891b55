//! What packing streams came to.

use serde::Serialize;

use super::{Choice, Container, Run, StreamArguments};
use crate::document;
use crate::filling::Way;
use crate::statistics::{Mean, percentage, quantiles};

/// All that was found.
#[derive(Debug, Serialize)]
pub(super) struct Results<'a> {
    machine: String,
    workers: usize,
    first_stream: u32,
    streams: u32,
    items: u32,
    choice: Choice,
    way: &'a Way,
    lines: Vec<Line>,
    #[serde(skip)]
    first: Vec<Run>,
}

/// With so many open containers.
#[derive(Debug, Serialize)]
struct Line {
    open: usize,
    closed: usize,
    /// Of a closed container: the mean over streams of their means.
    meshes_cm3: Mean,
    /// To the first line, stream by stream.
    difference_cm3: Mean,
    difference_percent: f64,
    items: Mean,
    /// Items in closed containers, and how many of these there are for a thousand.
    containers_per_thousand: Mean,
    unsteady: usize,
    placed: usize,
    unplaceable: usize,
    decision_median_s: f64,
    decision_95_s: f64,
}

impl Run {
    /// The mean over the closed containers; over those that are open where none was closed.
    fn mean(&self, value: impl Fn(&Container) -> f64) -> f64 {
        let containers = match self.closed.is_empty() {
            true => &self.open,
            false => &self.closed,
        };
        Mean::of(containers.iter().map(value)).mean
    }

    fn all(&self) -> impl Iterator<Item = &Container> {
        self.closed.iter().chain(&self.open)
    }
}

impl Line {
    fn new(open: usize, runs: &[Run], first: &[Run]) -> Self {
        let cm3 = |run: &Run| run.mean(|container| container.meshes_m3 * 1e6);
        let pairs = runs.iter().zip(first);
        let difference_cm3 = Mean::of(pairs.map(|(run, first)| cm3(run) - cm3(first)));
        let compared = Mean::of(first.iter().map(cm3)).mean;
        let items = |run: &Run| run.mean(|container| container.items as f64);
        let all = || runs.iter().flat_map(Run::all);
        let decisions = runs.iter().flat_map(|run| run.decision_s.iter().copied());
        let [decision_median_s, decision_95_s] = quantiles(decisions, [0.5, 0.95]);
        Self {
            open,
            closed: runs.iter().map(|run| run.closed.len()).sum(),
            meshes_cm3: Mean::of(runs.iter().map(cm3)),
            difference_percent: 100.0 * difference_cm3.mean / compared,
            difference_cm3,
            items: Mean::of(runs.iter().map(items)),
            containers_per_thousand: Mean::of(runs.iter().map(|run| 1e3 / items(run))),
            unsteady: all().map(|container| container.unsteady).sum(),
            placed: all().map(|container| container.placed).sum(),
            unplaceable: runs.iter().map(|run| run.unplaceable).sum(),
            decision_median_s,
            decision_95_s,
        }
    }
}

impl<'a> Results<'a> {
    pub(super) fn new(arguments: &StreamArguments, way: &'a Way) -> Self {
        Self {
            machine: document::machine(),
            workers: arguments.workers,
            first_stream: arguments.first,
            streams: arguments.streams,
            items: arguments.items,
            choice: arguments.choice,
            way,
            lines: Vec::new(),
            first: Vec::new(),
        }
    }

    /// Adds the runs with so many open containers.
    pub(super) fn add(&mut self, open: usize, runs: &[Run]) {
        if self.lines.is_empty() {
            self.first = runs.to_vec();
        }
        self.lines.push(Line::new(open, runs, &self.first));
    }

    pub(super) fn markdown(&self) -> String {
        let choice = match self.choice {
            Choice::Fullest => {
                "the fullest container in which an item of the buffer has a valid placement"
            }
            Choice::Best => "the container of the valid placement with the best value",
        };
        let mut text = format!(
            "# Streams: several containers open\n\n\
             {} streams of {} items from stream {} on, method *{}*, buffer of {}. An item goes into {choice}. Where nothing in the buffer \
             has a valid placement in any, the fullest is closed and an empty one opened. Volumes are of closed containers: the mean of \
             each stream, then over streams; differences are to the first line, stream by stream, with 95 % intervals by Student's t. \
             *Unsteady* is what toppled by more than 30 degrees, slid by more than 2 cm or left the container when it was placed. \
             Decision times are of one step on one thread, {} streams at once. Machine: {}.\n\n\
             | open | closed | mesh volume (cm³) | difference (cm³) | | items | containers per 1,000 items | unsteady | fit nowhere | \
             decision, median | 95 % |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
            self.streams,
            self.items,
            self.first_stream,
            self.way.name,
            self.way.method.buffer,
            self.workers,
            self.machine
        );
        for line in &self.lines {
            text += &format!(
                "| {} | {} | {} | {} | {:+.1} % | {} | {} | {:.1} % ({} of {}) | {} | {:.1} ms | {:.1} ms |\n",
                line.open,
                line.closed,
                line.meshes_cm3.shown(0),
                line.difference_cm3.shown(0),
                line.difference_percent,
                line.items.shown(1),
                line.containers_per_thousand.shown(1),
                percentage(line.unsteady, line.placed),
                line.unsteady,
                line.placed,
                line.unplaceable,
                line.decision_median_s * 1e3,
                line.decision_95_s * 1e3
            );
        }
        text
    }
}
