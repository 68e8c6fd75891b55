//! What all runs come to, as a document.

use std::collections::BTreeMap;
use std::fmt::Write;

use ppnpack_picture::{Bar, Bars, Size};
use serde::Serialize;

use super::record::{End, ItemRecord, RunRecord, SeenAs, Stage};
use super::{PhysicalArguments, Settings};
use crate::commands::experiment::document;
use crate::commands::experiment::statistics::{Mean, percent};
use crate::failure::{OrRun, Outcome};
use crate::output::write_whole;

/// How far a pose may be off, in metres and radians.
const GOOD_POSE: (f64, f64) = (0.003, 0.053);

/// What the runs of a contender come to.
#[derive(Debug, Serialize)]
pub(super) struct Line {
    method: String,
    runs: usize,
    items: Items,
    seen: Seen,
    /// Per run, in percent.
    compactness_percent: Mean,
    /// Per run, in litres.
    volume_l: Mean,
    /// Per decision.
    decision_ms: Spread,
    decision_mean_ms: Mean,
    degraded_decisions: usize,
    decisions: usize,
    /// The planned time of the arm's cycle.
    cycle_s: Spread,
    stages_ms: BTreeMap<Stage, Spread>,
    deepest_overlap_mm: f64,
    greatest_disturbance_mm: f64,
    runs_ended_by_doubt: usize,
    refusals: BTreeMap<String, usize>,
    records: Vec<RunRecord>,
}

/// What became of the items.
#[derive(Debug, Default, Serialize)]
struct Items {
    all: usize,
    placed: usize,
    /// Of those that were placed: not inside the container.
    outside: usize,
    /// Of those that were placed: leaning by more than 30 degrees.
    toppled: usize,
    refused: usize,
    lost: usize,
    /// Attempts beyond the first.
    repeated: usize,
}

/// How items were seen on the tray.
#[derive(Debug, Default, Serialize)]
struct Seen {
    /// Those that can be recognised.
    known: usize,
    right: usize,
    /// Of the right ones: within 3 mm and 3 degrees.
    good_poses: usize,
    wrong: usize,
    known_as_unknown: usize,
    /// Those that cannot.
    strangers: usize,
    strangers_as_unknown: usize,
    not_found: usize,
}

/// The median of some values, and what 95 % of them stay below.
#[derive(Debug, Clone, Copy, Default, Serialize)]
struct Spread {
    median: f64,
    most: f64,
    count: usize,
}

impl Spread {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.collect();
        values.sort_by(f64::total_cmp);
        let count = values.len();
        let at = |share: f64| {
            let index = ((count as f64 - 1.0) * share).round().max(0.0) as usize;
            values.get(index).copied().unwrap_or_default()
        };
        Self {
            median: at(0.5),
            most: at(0.95),
            count,
        }
    }

    fn shown(&self) -> String {
        if self.count == 0 {
            "–".to_owned()
        } else {
            format!("{:.1}, {:.1}", self.median, self.most)
        }
    }
}

impl Line {
    pub(super) fn new(method: &str, records: Vec<RunRecord>) -> Self {
        let items = || records.iter().flat_map(|run| &run.items);
        let decisions = || records.iter().flat_map(|run| &run.decisions);
        let stage = |stage: Stage| {
            let times_s = records.iter().filter_map(|run| run.stages_s.get(&stage));
            Spread::of(times_s.flatten().map(|time_s| time_s * 1e3))
        };
        let disturbances = items().filter_map(|item| match item.end {
            End::Placed { disturbance_m, .. } => Some(disturbance_m * 1e3),
            _ => None,
        });
        let overlaps = records.iter().map(|run| run.deepest_overlap_m * 1e3);
        Self {
            method: method.to_owned(),
            runs: records.len(),
            items: Items::of(items()),
            seen: Seen::of(items()),
            compactness_percent: Mean::of(records.iter().map(|run| run.compactness * 100.0)),
            volume_l: Mean::of(records.iter().map(|run| run.volume_m3 * 1e3)),
            decision_ms: Spread::of(decisions().map(|decision| decision.total_s() * 1e3)),
            decision_mean_ms: Mean::of(decisions().map(|decision| decision.total_s() * 1e3)),
            degraded_decisions: decisions().filter(|it| !it.degraded.is_empty()).count(),
            decisions: decisions().count(),
            cycle_s: Spread::of(
                decisions()
                    .map(|decision| decision.cycle_s)
                    .filter(|cycle_s| *cycle_s > 0.0),
            ),
            stages_ms: Stage::ALL.map(|name| (name, stage(name))).into(),
            deepest_overlap_mm: overlaps.fold(0.0, f64::max),
            greatest_disturbance_mm: disturbances.fold(0.0, f64::max),
            runs_ended_by_doubt: records.iter().filter(|run| run.doubt.is_some()).count(),
            refusals: refusals(items()),
            records,
        }
    }
}

/// Reasons for which items were refused, and how many were.
fn refusals<'a>(items: impl Iterator<Item = &'a ItemRecord>) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for item in items {
        if let End::Refused { reason } = &item.end {
            *counts.entry(reason.clone()).or_default() += 1;
        }
    }
    counts
}

impl Items {
    fn of<'a>(items: impl Iterator<Item = &'a ItemRecord>) -> Self {
        let mut sums = Self::default();
        for item in items {
            sums.all += 1;
            sums.repeated += item.attempts.saturating_sub(1) as usize;
            match &item.end {
                End::Placed {
                    is_inside,
                    tilt_rad,
                    ..
                } => {
                    sums.placed += 1;
                    sums.outside += usize::from(!is_inside);
                    sums.toppled += usize::from(*tilt_rad > 30_f64.to_radians());
                }
                End::Refused { .. } | End::Waiting => sums.refused += 1,
                End::Lost { .. } => sums.lost += 1,
            }
        }
        sums
    }
}

impl Seen {
    fn of<'a>(items: impl Iterator<Item = &'a ItemRecord>) -> Self {
        let mut sums = Self::default();
        for item in items {
            match (&item.seen_as, item.is_known) {
                (SeenAs::Nothing, _) => sums.not_found += 1,
                (SeenAs::Unknown, false) => sums.strangers_as_unknown += 1,
                (SeenAs::Unknown, true) => sums.known_as_unknown += 1,
                (
                    SeenAs::Object {
                        position_off_m,
                        angle_off_rad,
                        ..
                    },
                    true,
                ) => {
                    let off = position_off_m.zip(*angle_off_rad);
                    sums.right += usize::from(off.is_some());
                    sums.wrong += usize::from(off.is_none());
                    let is_good = |(off_m, off_rad)| off_m <= GOOD_POSE.0 && off_rad <= GOOD_POSE.1;
                    sums.good_poses += usize::from(off.is_some_and(is_good));
                }
                (SeenAs::Object { .. }, false) => {}
            }
            sums.known += usize::from(item.is_known);
            sums.strangers += usize::from(!item.is_known);
        }
        sums
    }
}

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
        let svg = timeline(line).to_svg(Size::new(720, 300).or_run()?);
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
        ..Bar::default()
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
        decimals: 1,
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
         dropouts above container and tray. Seed {}; {}.\n",
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
    if settings.arm.is_some() {
        writeln!(
            text,
            "Objects are drawn from those that the arm can hold in at least 80 % of the cases, by the chances of their \
             resting poses: {} unseen ones and {} others.\n",
            results.unseen_held, results.others_held
        )?;
    }
    if let Some(reason) = &results.without_network {
        writeln!(text, "Without the network: {reason}.\n")?;
    }
    type Cell = fn(&Line) -> String;
    let rows: [(&str, Cell); 19] = [
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
    ];
    table(&mut text, &results.lines, &rows)?;
    writeln!(
        text,
        "\n## Time line\n\nMedian and what 95 % stay below, in ms; the arm's cycle in s.\n"
    )?;
    let stages: [(&str, Cell); 5] = [
        (Stage::Recognise.name(), |line| {
            stage(line, Stage::Recognise)
        }),
        (Stage::Plan.name(), |line| stage(line, Stage::Plan)),
        (Stage::See.name(), |line| stage(line, Stage::See)),
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
fn table(
    text: &mut String,
    lines: &[Line],
    rows: &[(&str, fn(&Line) -> String)],
) -> Result<(), std::fmt::Error> {
    let names: Vec<&str> = lines.iter().map(|line| line.method.as_str()).collect();
    writeln!(text, "| | {} |", names.join(" | "))?;
    writeln!(text, "|---|{}", "---|".repeat(lines.len()))?;
    for (name, cell) in rows {
        let cells: Vec<String> = lines.iter().map(cell).collect();
        writeln!(text, "| {name} | {} |", cells.join(" | "))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_is_median_and_95_percent() {
        let spread = Spread::of((0..=100).rev().map(f64::from));
        assert_eq!(
            (spread.median, spread.most, spread.count),
            (50.0, 95.0, 101)
        );
        assert_eq!(Spread::of(std::iter::empty()).shown(), "–");
    }

    #[test]
    fn every_item_is_counted_once() {
        let item = |end, seen_as, is_known| ItemRecord {
            object: "a".to_owned(),
            is_known,
            seen_as,
            attempts: 2,
            end,
        };
        let placed = |is_inside, tilt_rad| End::Placed {
            is_inside,
            slide_m: 0.0,
            tilt_rad,
            disturbance_m: 0.002,
        };
        let object = |off: Option<f64>| SeenAs::Object {
            name: "a".to_owned(),
            position_off_m: off,
            angle_off_rad: off,
        };
        let lost = End::Lost {
            failure: "dropped".to_owned(),
        };
        let refused = End::Refused {
            reason: "no room".to_owned(),
        };
        let record = RunRecord {
            items: vec![
                item(placed(true, 0.0), object(Some(0.001)), true),
                item(placed(false, 1.0), object(None), true),
                item(lost, SeenAs::Unknown, false),
                item(refused, SeenAs::Nothing, true),
            ],
            ..RunRecord::default()
        };
        let line = Line::new("exhaustive", vec![record]);
        let items = &line.items;
        assert_eq!(
            (items.all, items.placed, items.outside, items.toppled),
            (4, 2, 1, 1)
        );
        assert_eq!((items.refused, items.lost, items.repeated), (1, 1, 4));
        let seen = &line.seen;
        assert_eq!(
            (seen.known, seen.right, seen.good_poses, seen.wrong),
            (3, 1, 1, 1)
        );
        assert_eq!(
            (seen.strangers, seen.strangers_as_unknown, seen.not_found),
            (1, 1, 1)
        );
        assert_eq!(line.refusals, BTreeMap::from([("no room".to_owned(), 1)]));
    }
}
