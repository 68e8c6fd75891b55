//! What packing streams came to.

use std::collections::BTreeMap;

use ppnpack_packing::orders::Sharing;
use serde::Serialize;

use super::packing::{Container, Run};
use super::{Setting, StreamArguments};
use crate::comparison::WIDENED;
use crate::filling::Way;
use crate::sheet::{Cell, Column, Lines};
use crate::statistics::Mean;

/// A column of this experiment's tables.
type Measured<'a> = Column<'a, Run>;

/// All that was found.
#[derive(Debug, Serialize)]
pub(super) struct Results<'a> {
    workers: usize,
    first_stream: u32,
    streams: u32,
    source: String,
    has_orders: bool,
    way: &'a Way,
    lines: Lines<Run>,
    #[serde(skip)]
    pub(super) text: String,
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

/// How often each comes, with what comes first.
fn counted(what: impl Iterator<Item = String>) -> Cell {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for one in what {
        *counts.entry(one).or_default() += 1;
    }
    let shown = counts
        .iter()
        .map(|(what, count)| format!("{what}: {count}"));
    Cell::new(shown.collect::<Vec<String>>().join(", "), counts)
}

fn all(runs: &[Run]) -> impl Iterator<Item = &Container> {
    runs.iter().flat_map(Run::all)
}

fn closed(runs: &[Run]) -> impl Iterator<Item = &Container> {
    runs.iter().flat_map(|run| &run.closed)
}

/// What closed containers hold.
fn volumes() -> [Measured<'static>; 13] {
    let of_all = |run: &Run, value: fn(&Container) -> usize| run.all().map(value).sum::<usize>();
    let unsteady = move |run: &Run| of_all(run, |it| it.unsteady);
    let placed = move |run: &Run| of_all(run, |it| it.placed);
    let cm3 = |run: &Run| run.mean(|container| container.meshes_m3 * 1e6);
    let items = |run: &Run| run.mean(|container| container.items as f64);
    [
        Measured::sum("closed", "closed", |run| run.closed.len()),
        Measured::mean("meshes_cm3", "mesh volume (cm³)", 0, cm3),
        Measured::difference("difference_cm3", "difference (cm³)", 0, cm3),
        Measured::change("difference_percent", cm3),
        Measured::mean("items", "items", 1, items),
        Measured::mean(
            "containers_per_thousand",
            "containers per 1,000 items",
            1,
            move |run| 1e3 / items(run),
        ),
        Measured::share("unsteady_percent", "unsteady", move |run| {
            [unsteady(run), placed(run)]
        }),
        Measured::sum("unsteady", "", unsteady).shown_if(false),
        Measured::sum("placed", "", placed).shown_if(false),
        Measured::sum("steps_widened", "steps widened", move |run| {
            of_all(run, |it| it.steps_widened)
        }),
        Measured::sum("unplaceable", "fit nowhere", |run| run.unplaceable),
        Measured::time("decision_median_s", "decision, median", (0.5, 1), |run| {
            &run.decision_s
        }),
        Measured::time("decision_95_s", "95 %", (0.95, 1), |run| &run.decision_s),
    ]
}

/// How many containers orders take.
fn orders() -> [Measured<'static>; 6] {
    let percent = |key, head, of_run: fn(&Run) -> [usize; 2]| {
        Measured::new(key, head, move |runs: &[Run], _| {
            let counts = runs.iter().map(of_run);
            let [part, whole] = counts.fold([0; 2], |[a, b], [c, d]| [a + c, b + d]);
            Cell::percent(part, whole)
        })
    };
    [
        Measured::mean("used", "containers used", 1, Run::used),
        Measured::difference("used_difference", "difference", 1, Run::used),
        Measured::change("used_difference_percent", Run::used),
        Measured::mean("containers_an_order", "containers an order", 2, |run| {
            Mean::of(run.containers_of_orders.iter().map(|of| *of as f64)).mean
        }),
        percent(
            "in_one_container_percent",
            "orders in one container",
            |run| {
                let of_orders = &run.containers_of_orders;
                let in_one = of_orders.iter().filter(|containers| **containers == 1);
                [in_one.count(), of_orders.len()]
            },
        ),
        percent("complete_percent", "complete orders", |run| {
            [run.complete_orders, run.orders]
        }),
    ]
}

/// The arm's planned time from one pick to the next, where there is an arm.
fn cycles() -> [Measured<'static>; 2] {
    fn cycle_s(runs: &[Run]) -> Mean {
        let with_arm = runs.iter().filter(|run| !run.cycle_s.is_empty());
        Mean::of(with_arm.map(|run| Mean::of(run.cycle_s.iter().copied()).mean))
    }
    [
        Measured::new("cycle_s", "cycle (s)", |runs: &[Run], _| {
            Cell::mean(cycle_s(runs), 2)
        }),
        Measured::new("litres_an_hour", "litres an hour", |runs: &[Run], _| {
            let meshes_m3: f64 = all(runs).map(|container| container.meshes_m3).sum();
            let items: usize = all(runs).map(|container| container.items).sum();
            let litres_an_item = meshes_m3 * 1e3 / items.max(1) as f64;
            let litres = litres_an_item * 3600.0 / cycle_s(runs).mean;
            Cell::new(format!("{litres:.0}"), litres)
        }),
    ]
}

/// Why containers were closed, of which sizes, and how much of their volume was filled.
fn closings() -> [Measured<'static>; 3] {
    [
        Measured::new("closed_by", "by", |runs: &[Run], _| {
            counted(all(runs).filter_map(|container| container.closed_by.clone()))
        }),
        Measured::new("closed_sizes", "sizes", |runs: &[Run], _| {
            counted(closed(runs).map(Container::size))
        }),
        Measured::new("filled_percent", "filled", |runs: &[Run], _| {
            let filled_m3 = closed(runs).fold(0.0, |sum, container| sum + container.meshes_m3);
            let whole_m3: f64 = closed(runs).map(Container::volume_m3).sum();
            let percent = 100.0 * filled_m3 / whole_m3.max(f64::MIN_POSITIVE);
            Cell::new(format!("{percent:.1} %"), percent)
        }),
    ]
}

impl<'a> Results<'a> {
    /// Of the runs by the settings of the lines.
    pub(super) fn new(
        arguments: &StreamArguments,
        way: &'a Way,
        runs: Vec<(Setting, Vec<Run>)>,
    ) -> Self {
        let has_orders = arguments.source.has_orders();
        let workers = arguments.runs.workers();
        let source = arguments.source.said(arguments.wanted());
        let has_arm = runs
            .iter()
            .any(|(_, runs)| runs.iter().any(|run| !run.cycle_s.is_empty()));
        let settings: Vec<Setting> = runs.iter().map(|(setting, _)| *setting).collect();
        let runs = runs
            .into_iter()
            .map(|(setting, runs)| (setting.shown(has_orders), runs));
        let mut lines = Lines::new("name", runs.collect());
        lines.keep("setting", settings);
        let mut text = format!(
            "# Streams: several containers open\n\n\
             {} streams of {source} from stream {} on, method *{}*, buffer of {}. An item goes into the fullest container in which an item of the buffer has a valid placement. Where nothing in the buffer \
             has a valid placement in any, the fullest is closed and an empty one opened; other rules that closed containers are named below. Volumes are of closed containers: the mean of \
             each stream, then over streams; differences are to the first line, stream by stream, with 95 % intervals by Student's t. \
             *Unsteady* is what toppled by more than 30 degrees, slid by more than 2 cm or left the container when it was placed. \
             {WIDENED} Decision times are of one step on one thread, {workers} streams at once.\n\n{}",
            arguments.streams,
            arguments.first,
            way.name,
            way.method.buffer,
            lines.table("open", &volumes()),
        );
        if has_orders {
            text += &format!(
                "\nContainers in which something was packed, open ones at the end among them; differences are to the first line, stream by \
                 stream. *Complete* orders have all of their items in containers.\n\n{}",
                lines.table("open", &orders())
            );
        }
        if has_arm {
            text += &format!(
                "\nThe arm's planned time from one pick to the next, the mean of each stream, then over streams:\n\n{}",
                lines.table("open", &cycles())
            );
        }
        text += &format!(
            "\nWhy containers were closed, of which sizes, and how much of their volume was filled:\n\n{}",
            lines.table("open", &closings())
        );
        Self {
            workers,
            first_stream: arguments.first,
            streams: arguments.streams,
            source,
            has_orders,
            way,
            lines,
            text,
        }
    }
}
