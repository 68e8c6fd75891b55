//! What packing streams came to.

use std::collections::BTreeMap;

use ppnpack_packing::orders::Sharing;
use serde::Serialize;

use super::packing::{Container, Run};
use super::{Choice, Setting, StreamArguments};
use crate::comparison::WIDENED;
use crate::filling::Way;
use crate::statistics::{Mean, percentage, quantiles};

/// All that was found.
#[derive(Debug, Serialize)]
pub(super) struct Results<'a> {
    workers: usize,
    first_stream: u32,
    streams: u32,
    source: String,
    has_orders: bool,
    choice: Choice,
    way: &'a Way,
    lines: Vec<Line>,
    #[serde(skip)]
    first: Vec<Run>,
}

/// Packed in one way.
#[derive(Debug, Serialize)]
struct Line {
    setting: Setting,
    /// In which something was packed.
    used: Mean,
    /// To the first line, stream by stream.
    used_difference: Mean,
    used_difference_percent: f64,
    /// In how many containers an order is.
    containers_an_order: Mean,
    in_one_container_percent: f64,
    complete_percent: f64,
    closed: usize,
    /// How many, by the rules that closed them.
    closed_by: BTreeMap<String, usize>,
    /// How many, by their sizes.
    closed_sizes: BTreeMap<String, usize>,
    /// How much of their volume was filled, in percent; 0 where none was closed.
    filled_percent: f64,
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
    /// Searched exhaustively, as none of their proposals was valid.
    steps_widened: usize,
    unplaceable: usize,
    decision_median_s: f64,
    decision_95_s: f64,
    /// From one pick to the next, where there is an arm.
    cycle_s: Option<Mean>,
    /// Of the meshes of an item that is inside a container, closed or not.
    litres_an_item: f64,
}

impl Run {
    /// The mean over the closed containers; over the others that were begun where none was closed.
    fn mean(&self, value: impl Fn(&Container) -> f64) -> f64 {
        let containers = match self.closed.is_empty() {
            true => &self.open,
            false => &self.closed,
        };
        let begun = containers.iter().filter(|container| container.placed > 0);
        Mean::of(begun.map(value)).mean
    }

    fn all(&self) -> impl Iterator<Item = &Container> {
        self.closed.iter().chain(&self.open)
    }

    /// How many containers something was packed in.
    fn used(&self) -> f64 {
        self.all().filter(|container| container.placed > 0).count() as f64
    }
}

impl Setting {
    fn shown(self, has_orders: bool) -> String {
        match self.sharing {
            Sharing::OneOrder => format!("{}, one order at a time", self.open),
            Sharing::Shared if has_orders => format!("{}, shared", self.open),
            Sharing::Shared => self.open.to_string(),
        }
    }
}

impl Line {
    fn new(setting: Setting, runs: &[Run], first: &[Run]) -> Self {
        let cm3 = |run: &Run| run.mean(|container| container.meshes_m3 * 1e6);
        let pairs = runs.iter().zip(first);
        let difference_cm3 = Mean::of(pairs.map(|(run, first)| cm3(run) - cm3(first)));
        let compared = Mean::of(first.iter().map(cm3)).mean;
        let items = |run: &Run| run.mean(|container| container.items as f64);
        let all = || runs.iter().flat_map(Run::all);
        let closed = || runs.iter().flat_map(|run| &run.closed);
        let decisions = runs.iter().flat_map(|run| run.decision_s.iter().copied());
        let [decision_median_s, decision_95_s] = quantiles(decisions, [0.5, 0.95]);
        let with_arm = runs.iter().filter(|run| !run.cycle_s.is_empty());
        let cycles_s = with_arm.map(|run| Mean::of(run.cycle_s.iter().copied()).mean);
        let cycles_s: Vec<f64> = cycles_s.collect();
        let pairs = runs.iter().zip(first);
        let used_difference = Mean::of(pairs.map(|(run, first)| run.used() - first.used()));
        let used_first = Mean::of(first.iter().map(Run::used)).mean;
        let of_orders = || runs.iter().flat_map(|run| &run.containers_of_orders);
        let in_one = of_orders().filter(|containers| **containers == 1).count();
        let an_order =
            |run: &Run| Mean::of(run.containers_of_orders.iter().map(|of| *of as f64)).mean;
        Self {
            setting,
            used: Mean::of(runs.iter().map(Run::used)),
            used_difference_percent: 100.0 * used_difference.mean / used_first,
            used_difference,
            containers_an_order: Mean::of(runs.iter().map(an_order)),
            in_one_container_percent: percentage(in_one, of_orders().count()),
            complete_percent: percentage(
                runs.iter().map(|run| run.complete_orders).sum(),
                runs.iter().map(|run| run.orders).sum(),
            ),
            closed_by: counted(all().filter_map(|container| container.closed_by.clone())),
            closed_sizes: counted(closed().map(Container::size)),
            filled_percent: percentage_of(
                closed().map(|container| container.meshes_m3).sum(),
                closed().map(Container::volume_m3).sum(),
            ),
            closed: runs.iter().map(|run| run.closed.len()).sum(),
            meshes_cm3: Mean::of(runs.iter().map(cm3)),
            difference_percent: 100.0 * difference_cm3.mean / compared,
            difference_cm3,
            items: Mean::of(runs.iter().map(items)),
            containers_per_thousand: Mean::of(runs.iter().map(|run| 1e3 / items(run))),
            unsteady: all().map(|container| container.unsteady).sum(),
            placed: all().map(|container| container.placed).sum(),
            steps_widened: all().map(|container| container.steps_widened).sum(),
            unplaceable: runs.iter().map(|run| run.unplaceable).sum(),
            decision_median_s,
            decision_95_s,
            litres_an_item: {
                let meshes_m3: f64 = all().map(|container| container.meshes_m3).sum();
                let items: usize = all().map(|container| container.items).sum();
                meshes_m3 * 1e3 / items.max(1) as f64
            },
            cycle_s: (!cycles_s.is_empty()).then(|| Mean::of(cycles_s.into_iter())),
        }
    }
}

impl Container {
    /// Its size, for people.
    fn size(&self) -> String {
        let [x_m, y_m, z_m] = self.size_m;
        format!("{x_m} x {y_m} x {z_m} m")
    }

    fn volume_m3(&self) -> f64 {
        self.size_m.iter().product()
    }
}

fn percentage_of(part: f64, whole: f64) -> f64 {
    match whole > 0.0 {
        true => 100.0 * part / whole,
        false => 0.0,
    }
}

fn listed(counts: &BTreeMap<String, usize>) -> String {
    let counts = counts
        .iter()
        .map(|(what, count)| format!("{what}: {count}"));
    counts.collect::<Vec<String>>().join(", ")
}

/// How often each comes.
fn counted(rules: impl Iterator<Item = String>) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for rule in rules {
        *counts.entry(rule).or_default() += 1;
    }
    counts
}

impl<'a> Results<'a> {
    pub(super) fn new(arguments: &StreamArguments, way: &'a Way) -> Self {
        Self {
            workers: arguments.runs.workers(),
            first_stream: arguments.first,
            streams: arguments.streams,
            source: arguments.source.said(arguments.wanted()),
            has_orders: arguments.source.has_orders(),
            choice: arguments.choice,
            way,
            lines: Vec::new(),
            first: Vec::new(),
        }
    }

    /// Adds the runs of a line.
    pub(super) fn add(&mut self, setting: Setting, runs: Vec<Run>) {
        let first = match self.lines.is_empty() {
            true => &runs,
            false => &self.first,
        };
        self.lines.push(Line::new(setting, &runs, first));
        if self.lines.len() == 1 {
            self.first = runs;
        }
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
             {} streams of {} from stream {} on, method *{}*, buffer of {}. An item goes into {choice}. Where nothing in the buffer \
             has a valid placement in any, the fullest is closed and an empty one opened; other rules that closed containers are named below. Volumes are of closed containers: the mean of \
             each stream, then over streams; differences are to the first line, stream by stream, with 95 % intervals by Student's t. \
             *Unsteady* is what toppled by more than 30 degrees, slid by more than 2 cm or left the container when it was placed. \
             {WIDENED} Decision times are of one step on one thread, {} streams at once.\n\n\
             | open | closed | mesh volume (cm³) | difference (cm³) | | items | containers per 1,000 items | unsteady | steps widened | fit nowhere | \
             decision, median | 95 % |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n",
            self.streams,
            self.source,
            self.first_stream,
            self.way.name,
            self.way.method.buffer,
            self.workers
        );
        for line in &self.lines {
            text += &format!(
                "| {} | {} | {} | {} | {:+.1} % | {} | {} | {:.1} % ({} of {}) | {} | {} | {:.1} ms | {:.1} ms |\n",
                line.setting.shown(self.has_orders),
                line.closed,
                line.meshes_cm3.shown(0),
                line.difference_cm3.shown(0),
                line.difference_percent,
                line.items.shown(1),
                line.containers_per_thousand.shown(1),
                percentage(line.unsteady, line.placed),
                line.unsteady,
                line.placed,
                line.steps_widened,
                line.unplaceable,
                line.decision_median_s * 1e3,
                line.decision_95_s * 1e3
            );
        }
        if self.has_orders {
            text += &self.orders_markdown();
        }
        if self.lines.iter().any(|line| line.cycle_s.is_some()) {
            text += &self.arm_markdown();
        }
        text + &self.closings_markdown()
    }

    fn arm_markdown(&self) -> String {
        let mut text = "\nThe arm's planned time from one pick to the next, the mean of each stream, then over streams:\n\n\
                        | open | cycle (s) | litres an hour |\n|---|---|---|\n"
            .to_owned();
        for line in &self.lines {
            if let Some(cycle_s) = line.cycle_s {
                text += &format!(
                    "| {} | {} | {:.0} |\n",
                    line.setting.shown(self.has_orders),
                    cycle_s.shown(2),
                    line.litres_an_item * 3600.0 / cycle_s.mean
                );
            }
        }
        text
    }

    /// Why containers were closed, of which sizes.
    fn closings_markdown(&self) -> String {
        let mut text =
            "\nWhy containers were closed, of which sizes, and how much of their volume was filled:\n\n\
             | open | closed | by | sizes | filled |\n|---|---|---|---|---|\n"
                .to_owned();
        for line in &self.lines {
            text += &format!(
                "| {} | {} | {} | {} | {:.1} % |\n",
                line.setting.shown(self.has_orders),
                line.closed,
                listed(&line.closed_by),
                listed(&line.closed_sizes),
                line.filled_percent
            );
        }
        text
    }

    fn orders_markdown(&self) -> String {
        let mut text = "\nContainers in which something was packed, open ones at the end among them; differences are to the first line, stream by \
                        stream. *Complete* orders have all of their items in containers.\n\n\
                        | open | containers used | difference | | containers an order | orders in one container | complete orders |\n\
                        |---|---|---|---|---|---|---|\n"
            .to_owned();
        for line in &self.lines {
            text += &format!(
                "| {} | {} | {} | {:+.1} % | {} | {:.1} % | {:.1} % |\n",
                line.setting.shown(true),
                line.used.shown(1),
                line.used_difference.shown(1),
                line.used_difference_percent,
                line.containers_an_order.shown(2),
                line.in_one_container_percent,
                line.complete_percent
            );
        }
        text
    }
}
