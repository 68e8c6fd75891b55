//! What packing streams came to, column by column.

use std::collections::BTreeMap;

use super::packing::{Container, Run};
use crate::sheet::{Cell, Column};
use crate::statistics::Mean;

/// A column of this experiment's tables.
type Measured = Column<Run>;

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
pub(super) fn volumes() -> [Measured; 13] {
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
        Measured::sum("unsteady", "", unsteady).hidden(),
        Measured::sum("placed", "", placed).hidden(),
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
pub(super) fn orders() -> [Measured; 6] {
    [
        Measured::mean("used", "containers used", 1, Run::used),
        Measured::difference("used_difference", "difference", 1, Run::used),
        Measured::change("used_difference_percent", Run::used),
        Measured::mean("containers_an_order", "containers an order", 2, |run| {
            Mean::of(run.containers_of_orders.iter().map(|of| *of as f64)).mean
        }),
        Measured::share(
            "in_one_container_percent",
            "orders in one container",
            |run| {
                let of_orders = &run.containers_of_orders;
                let in_one = of_orders.iter().filter(|containers| **containers == 1);
                [in_one.count(), of_orders.len()]
            },
        ),
        Measured::share("complete_percent", "complete orders", |run| {
            [run.complete_orders, run.orders]
        }),
    ]
}

/// Why containers were closed, and how much of their volume was filled.
pub(super) fn closings() -> [Measured; 2] {
    [
        Measured::new("closed_by", "by", |runs: &[Run]| {
            counted(all(runs).filter_map(|container| container.closed_by.clone()))
        }),
        Measured::new("filled_percent", "filled", |runs: &[Run]| {
            let filled_m3 = closed(runs).fold(0.0, |sum, container| sum + container.meshes_m3);
            let whole_m3: f64 = closed(runs).map(|container| container.volume_m3).sum();
            let percent = 100.0 * filled_m3 / whole_m3.max(f64::MIN_POSITIVE);
            Cell::new(format!("{percent:.1} %"), percent)
        }),
    ]
}
