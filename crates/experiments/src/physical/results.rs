//! What all runs come to, as a document.

use ppnpack_chart::{Bar, Bars};
use ppnpack_cli::failure::Outcome;
use serde::Serialize;

use super::record::Stage;
use super::sums::{Line, Spread};
use super::{PhysicalArguments, Settings};
use crate::document;
use crate::statistics::percent;

#[derive(Serialize)]
pub(super) struct Results<'a> {
    pub(super) settings: &'a Settings,
    /// Objects that runs draw from: those that the arm can hold in most of the poses that they come to lie in.
    pub(super) unseen_held: usize,
    pub(super) others_held: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) without_network: Option<String>,
    pub(super) lines: Vec<Line>,
}

/// Writes the document, the figures and the time line.
pub(super) fn publish(arguments: &PhysicalArguments, results: &Results<'_>) -> Outcome {
    let folder = arguments.out.folder("physical");
    for line in &results.lines {
        let name = format!("timeline-{}", line.key);
        document::figure(&folder, &name, timeline(line).to_svg([720, 300]))?;
    }
    arguments
        .out
        .publish("physical", results, &markdown(results))
}

/// How long the cell takes for each stage of an item.
fn timeline(line: &Line) -> Bars {
    let bar = |label: &str, value: f64| Bar {
        label: label.to_owned(),
        value,
    };
    let stages = [Stage::Recognise, Stage::Plan, Stage::See].into_iter();
    let mut bars: Vec<Bar> = stages
        .filter_map(|stage| Some(bar(stage.name(), line.stages_ms.get(&stage)?.median)))
        .collect();
    if line.cycle_s.count > 0 {
        bars.push(bar("arm's cycle, planned", line.cycle_s.median * 1e3));
    }
    Bars {
        title: format!("An item's way: {}", line.method),
        value_label: "Median (ms)".to_owned(),
        bars,
    }
}

fn markdown(results: &Results<'_>) -> String {
    let settings = results.settings;
    let strangers = match settings.strangers {
        true => ", the unseen ones not known to the recogniser",
        false => "",
    };
    let mut text = format!(
        "# The robot cell, simulated\n\n\
         Container 30 x 30 x 16 cm, {:.1} mm cells, {} yaws, buffer {}; {} unseen objects and {} other a run{strangers}; arm {}; \
         placement noise {:.1} mm, {:.0} % of picks miss, {:.0} % of items are dropped; depth cameras with 1 mm of noise and 5 % \
         dropouts above container and tray. Seed {}. Intervals are 95 % confidence intervals, by Student's t: of a run's \
         compactness and volume over the runs, of decisions over the decisions.\n\n\
         Objects are drawn from those that fit into the empty container and that the arm can hold in at least 80 % of the cases, \
         by the chances of their resting poses: {} unseen ones and {} others.\n\n",
        settings.grid.cell_m * 1e3,
        settings.grid.yaws,
        settings.buffer,
        settings.unseen_count,
        settings.known_count,
        settings.arm.as_ref().map_or("none", |arm| arm.arm.as_str()),
        settings.simulated.release.jitter_m * 1e3,
        settings.faults.missed_picks * 100.0,
        settings.faults.drops * 100.0,
        settings.seed,
        results.unseen_held,
        results.others_held
    );
    if let Some(reason) = &results.without_network {
        text += &format!("Without the network: {reason}.\n\n");
    }
    text += &table(&results.lines, came_to);
    text += "\n## Time line\n\nMedian and what 95 % stay below, in ms; the arm's cycle in s.\n\n";
    text += &table(&results.lines, times);
    text += "\n## Why items were refused\n\n";
    for line in &results.lines {
        for (reason, count) in &line.refusals {
            text += &format!("- {}: {count} x {reason}\n", line.method);
        }
    }
    text
}

/// A cell of a contender's column, after the name of its row.
type Cell = (&'static str, String);

/// What the runs of a contender came to.
fn came_to(line: &Line) -> [Cell; 22] {
    let (items, seen, found) = (&line.items, &line.seen, &line.found);
    let count = |name, count: usize| (name, count.to_string());
    let good_found = percent(found.good_poses, found.poses);
    [
        count("runs", line.runs),
        count("items", items.all),
        count("placed", items.placed),
        count("of these outside the container", items.outside),
        count("of these leaning by over 30 degrees", items.toppled),
        (
            "leaning, of those placed",
            percent(items.toppled, items.placed),
        ),
        count("refused with a reason", items.refused),
        count("dropped beside the container", items.lost),
        count("placements repeated after missed picks", items.repeated),
        count("runs ended by a doubtful scene", line.runs_ended_by_doubt),
        (
            "deepest overlap of two items at the end (mm)",
            format!("{:.2}", line.deepest_overlap_mm),
        ),
        (
            "farthest that a placement moved another item (mm)",
            format!("{:.1}", line.greatest_disturbance_mm),
        ),
        (
            "compactness of meshes by floor (%)",
            line.compactness_percent.shown(1),
        ),
        ("volume of meshes (l)", line.volume_l.shown(2)),
        ("decision: mean (ms)", line.decision_mean_ms.shown(2)),
        ("decision: median, 95 % (ms)", line.decision_ms.shown()),
        (
            "decisions, of these degraded, widened to an exhaustive search",
            format!(
                "{}, {}, {}",
                line.decisions, line.degraded_decisions, line.widened_decisions
            ),
        ),
        ("known items recognised", percent(seen.right, seen.known)),
        (
            "of these within 3 mm and 3 degrees",
            percent(seen.good_poses, seen.right),
        ),
        (
            "unknown items called unknown",
            percent(seen.strangers_as_unknown, seen.strangers),
        ),
        (
            "inspected after the placement: as planned, moved, toppled, missing, unclear",
            found.shown(),
        ),
        (
            "poses found, of these within 5 mm and 5 degrees",
            format!("{}, {good_found}", found.poses),
        ),
    ]
}

/// How long a contender's stages took.
fn times(line: &Line) -> [Cell; 6] {
    let shown = |stage: Stage| {
        let spread = line.stages_ms.get(&stage);
        (stage.name(), spread.map_or_else(String::new, Spread::shown))
    };
    let [recognise, plan, see, inspect, simulate] = Stage::ALL.map(shown);
    let cycle = ("arm's cycle, planned (s)", line.cycle_s.shown());
    [recognise, plan, see, inspect, simulate, cycle]
}

/// A table with a column for each contender.
fn table<const N: usize>(lines: &[Line], cells: fn(&Line) -> [Cell; N]) -> String {
    let mut head = ["| |".to_owned(), "|---|".to_owned()];
    let mut rows = [const { String::new() }; N];
    for line in lines {
        head[0] += &format!(" {} |", line.method);
        head[1] += "---|";
        for (row, (name, cell)) in rows.iter_mut().zip(cells(line)) {
            if row.is_empty() {
                *row = format!("| {name} |");
            }
            *row += &format!(" {cell} |");
        }
    }
    format!("{}\n{}\n", head.join("\n"), rows.join("\n"))
}
