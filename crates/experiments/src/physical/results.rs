//! What all runs come to, as a document.

use std::fmt::Write;

use ppnpack_chart::{Bar, Bars};
use serde::Serialize;

use super::record::Stage;
use super::sums::{Line, Spread};
use super::{PhysicalArguments, Settings};
use crate::document;
use crate::statistics::percent;
use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_files::write_whole;

/// A row of a table: what it tells, and of a contender.
type Row<'a> = (&'a str, fn(&Line) -> String);

#[derive(Serialize)]
struct Results<'a> {
    machine: String,
    settings: &'a Settings,
    /// Objects that runs draw from: those that the arm can hold in most of the poses that they come to lie in.
    unseen_held: usize,
    others_held: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    without_network: Option<String>,
    lines: Vec<Line>,
}

/// Writes the document, the figures and the time line.
pub(super) fn publish(
    arguments: &PhysicalArguments,
    settings: &Settings,
    (unseen_held, others_held): (usize, usize),
    lines: Vec<Line>,
    without_network: Option<String>,
) -> Outcome {
    let results = Results {
        machine: document::machine(),
        settings,
        unseen_held,
        others_held,
        without_network,
        lines,
    };
    for line in &results.lines {
        let name = format!(
            "timeline-{}.svg",
            if line.method == "exhaustive" {
                "exhaustive"
            } else {
                "network"
            }
        );
        let svg = timeline(line).to_svg([720, 300]).or_run()?;
        write_whole(&arguments.out.join(name), svg.as_bytes())?;
    }
    let markdown = markdown(&results).or_run()?;
    document::publish(
        &arguments.out,
        "physical",
        &results,
        &markdown,
        arguments.json,
    )
}

/// How long the cell takes for each stage of an item.
fn timeline(line: &Line) -> Bars {
    let bar = |label: &str, value: f64| Bar {
        label: label.to_owned(),
        value,
    };
    let mut bars: Vec<Bar> = [Stage::Recognise, Stage::Plan, Stage::See]
        .into_iter()
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

fn markdown(results: &Results<'_>) -> Result<String, std::fmt::Error> {
    let settings = results.settings;
    let mut text = String::new();
    writeln!(text, "# The robot cell, simulated\n")?;
    writeln!(
        text,
        "Container 30 x 30 x 16 cm, 1 cm cells, 4 yaws, buffer {}; {} unseen objects and {} other a run{}; arm {}; \
         placement noise {:.1} mm, {:.0} % of picks miss, {:.0} % of items are dropped; depth cameras with 1 mm of noise and 5 % \
         dropouts above container and tray. Seed {}; {}. Intervals are 95 % confidence intervals, by Student's t: of a run's \
         compactness and volume over the runs, of decisions over the decisions.\n",
        settings.buffer,
        settings.unseen_count,
        settings.known_count,
        if settings.strangers {
            ", the unseen ones not known to the recogniser"
        } else {
            ""
        },
        settings.arm.as_ref().map_or("none", |arm| arm.arm.as_str()),
        settings.simulated.release.jitter_m * 1e3,
        settings.faults.missed_picks * 100.0,
        settings.faults.drops * 100.0,
        settings.seed,
        results.machine,
    )?;
    writeln!(
        text,
        "Objects are drawn from those that fit into the empty container and that the arm can hold in at least 80 % of the cases, \
         by the chances of their resting poses: {} unseen ones and {} others.\n",
        results.unseen_held, results.others_held
    )?;
    if let Some(reason) = &results.without_network {
        writeln!(text, "Without the network: {reason}.\n")?;
    }
    let rows: [Row<'_>; 21] = [
        ("runs", |line| line.runs.to_string()),
        ("items", |line| line.items.all.to_string()),
        ("placed", |line| line.items.placed.to_string()),
        ("of these outside the container", |line| {
            line.items.outside.to_string()
        }),
        ("of these leaning by over 30 degrees", |line| {
            line.items.toppled.to_string()
        }),
        ("refused with a reason", |line| {
            line.items.refused.to_string()
        }),
        ("dropped beside the container", |line| {
            line.items.lost.to_string()
        }),
        ("placements repeated after missed picks", |line| {
            line.items.repeated.to_string()
        }),
        ("runs ended by a doubtful scene", |line| {
            line.runs_ended_by_doubt.to_string()
        }),
        ("deepest overlap of two items at the end (mm)", |line| {
            format!("{:.2}", line.deepest_overlap_mm)
        }),
        (
            "farthest that a placement moved another item (mm)",
            |line| format!("{:.1}", line.greatest_disturbance_mm),
        ),
        ("compactness (%)", |line| line.compactness_percent.shown(1)),
        ("volume of meshes (l)", |line| line.volume_l.shown(2)),
        ("decision: mean (ms)", |line| line.decision_mean_ms.shown(2)),
        ("decision: median, 95 % (ms)", |line| {
            line.decision_ms.shown()
        }),
        ("decisions, of these degraded", |line| {
            format!("{}, {}", line.decisions, line.degraded_decisions)
        }),
        ("known items recognised", |line| {
            percent(line.seen.right, line.seen.known)
        }),
        ("of these within 3 mm and 3 degrees", |line| {
            percent(line.seen.good_poses, line.seen.right)
        }),
        ("unknown items called unknown", |line| {
            percent(line.seen.strangers_as_unknown, line.seen.strangers)
        }),
        (
            "inspected after the placement: as planned, moved, toppled, missing, unclear",
            |line| line.found.shown(),
        ),
        ("poses found, of these within 5 mm and 5 degrees", |line| {
            let found = &line.found;
            let good = percent(found.good_poses, found.poses);
            format!("{}, {good}", found.poses)
        }),
    ];
    table(&mut text, &results.lines, &rows)?;
    writeln!(
        text,
        "\n## Time line\n\nMedian and what 95 % stay below, in ms; the arm's cycle in s.\n"
    )?;
    let stages: [Row<'_>; 6] = [
        (Stage::Recognise.name(), |line| {
            stage(line, Stage::Recognise)
        }),
        (Stage::Plan.name(), |line| stage(line, Stage::Plan)),
        (Stage::See.name(), |line| stage(line, Stage::See)),
        (Stage::Inspect.name(), |line| stage(line, Stage::Inspect)),
        (Stage::Simulate.name(), |line| stage(line, Stage::Simulate)),
        ("arm's cycle, planned (s)", |line| line.cycle_s.shown()),
    ];
    table(&mut text, &results.lines, &stages)?;
    writeln!(text, "\n## Why items were refused\n")?;
    for line in &results.lines {
        for (reason, count) in &line.refusals {
            writeln!(text, "- {}: {count} x {reason}", line.method)?;
        }
    }
    Ok(text)
}

fn stage(line: &Line, stage: Stage) -> String {
    line.stages_ms
        .get(&stage)
        .map_or_else(String::new, Spread::shown)
}

/// A table with a column for each contender.
fn table(text: &mut String, lines: &[Line], rows: &[Row<'_>]) -> Result<(), std::fmt::Error> {
    let names: Vec<&str> = lines.iter().map(|line| line.method.as_str()).collect();
    writeln!(text, "| | {} |", names.join(" | "))?;
    writeln!(text, "|---|{}", "---|".repeat(lines.len()))?;
    for (name, cell) in rows {
        let cells: Vec<String> = lines.iter().map(cell).collect();
        writeln!(text, "| {name} | {} |", cells.join(" | "))?;
    }
    Ok(())
}
