//! What the runs of a contender come to, column by column.

use std::collections::BTreeMap;

use super::record::{DecisionRecord, End, ItemRecord, RunRecord, SeenAs};
use crate::sheet::{Cell, Column};
use crate::statistics::{Mean, nearest_rank};

type Measured = Column<'static, RunRecord>;

/// How far a pose may be off, in metres and radians.
const GOOD_POSE: (f64, f64) = (0.003, 0.053);

/// The same for a pose found after a placement.
const GOOD_FOUND: (f64, f64) = (0.005, 0.088);

/// Leaning by more than this, in degrees, an item counts as toppled.
const TOPPLED_DEG: f64 = 30.0;

fn decisions(runs: &[RunRecord]) -> impl Iterator<Item = &DecisionRecord> {
    runs.iter().flat_map(|run| &run.decisions)
}

/// How many items are so.
fn items(key: &'static str, head: &'static str, is: fn(&ItemRecord) -> bool) -> Measured {
    Measured::sum(key, head, move |run| count(run, is))
}

/// How many of some items are so.
fn share(
    key: &'static str,
    head: &'static str,
    [part, whole]: [fn(&ItemRecord) -> bool; 2],
) -> Measured {
    Measured::share(key, head, move |run| [count(run, part), count(run, whole)])
}

fn count(run: &RunRecord, is: fn(&ItemRecord) -> bool) -> usize {
    run.items.iter().filter(|item| is(item)).count()
}

/// How many decisions are so.
fn decided(key: &'static str, head: &'static str, is: fn(&DecisionRecord) -> bool) -> Measured {
    Measured::sum(key, head, move |run| {
        run.decisions.iter().filter(|decision| is(decision)).count()
    })
}

/// The median of some values, and what 95 % of them stay below.
fn spread(values: impl Iterator<Item = f64>) -> Cell {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let [median, most] = [0.5, 0.95].map(|share| nearest_rank(&values, share));
    let shown = match (median, most) {
        (Some(median), Some(most)) => format!("{median:.1}, {most:.1}"),
        _ => "–".to_owned(),
    };
    let kept = serde_json::json!({ "median": median, "most": most, "count": values.len() });
    Cell::new(shown, kept)
}

fn is_placed(item: &ItemRecord) -> bool {
    matches!(item.end, End::Placed { .. })
}

fn is_toppled(item: &ItemRecord) -> bool {
    matches!(item.end, End::Placed { tilt_rad, .. } if tilt_rad > TOPPLED_DEG.to_radians())
}

/// How far the pose of an item that was recognised rightly is off, in metres and radians.
fn off(item: &ItemRecord) -> Option<(f64, f64)> {
    match &item.seen_as {
        SeenAs::Object {
            position_off_m,
            angle_off_rad,
            ..
        } if item.is_known => position_off_m.zip(*angle_off_rad),
        _ => None,
    }
}

/// The same of the pose that was found after the placement.
fn found_off(item: &ItemRecord) -> Option<(f64, f64)> {
    let found = item.found.as_ref()?;
    found.position_off_m.zip(found.angle_off_rad)
}

fn is_within((off_m, off_rad): (f64, f64), (most_m, most_rad): (f64, f64)) -> bool {
    off_m <= most_m && off_rad <= most_rad
}

/// How many items the inspection found so.
fn found(key: &'static str, head: &'static str, kind: &'static str) -> Measured {
    Measured::sum(key, head, move |run| {
        let found = run.items.iter().filter_map(|item| item.found.as_ref());
        found.filter(|found| found.kind == kind).count()
    })
}

/// The greatest of a length of each run, kept and shown in millimetres.
fn greatest_mm(
    key: &'static str,
    head: &'static str,
    decimals: usize,
    length_m: fn(&RunRecord) -> f64,
) -> Measured {
    Measured::new(key, head, move |runs| {
        let lengths_mm = runs.iter().map(|run| length_m(run) * 1e3);
        Cell::number(lengths_mm.fold(0.0, f64::max), decimals)
    })
}

fn disturbance_m(run: &RunRecord) -> f64 {
    let disturbances_m = run.items.iter().map(|item| match item.end {
        End::Placed { disturbance_m, .. } => disturbance_m,
        _ => 0.0,
    });
    disturbances_m.fold(0.0, f64::max)
}

/// What the runs of a contender came to.
pub(super) fn came_to() -> Vec<Measured> {
    vec![
        Measured::sum("runs", "runs", |_| 1),
        items("items/all", "items", |_| true),
        items("items/placed", "placed", is_placed),
        items("items/outside", "of these outside the container", |item| {
            matches!(
                item.end,
                End::Placed {
                    is_inside: false,
                    ..
                }
            )
        }),
        items(
            "items/toppled",
            "of these leaning by over 30 degrees",
            is_toppled,
        ),
        share(
            "items/toppled_percent",
            "leaning, of those placed",
            [is_toppled, is_placed],
        ),
        items("items/refused", "refused with a reason", |item| {
            matches!(item.end, End::Refused { .. } | End::Waiting)
        }),
        items("items/lost", "dropped beside the container", |item| {
            matches!(item.end, End::Lost { .. })
        }),
        Measured::sum(
            "items/repeated",
            "placements repeated after missed picks",
            |run| {
                let attempts = run.items.iter().map(|item| item.attempts);
                attempts.map(|it| it.saturating_sub(1) as usize).sum()
            },
        ),
        Measured::sum(
            "runs_ended_by_doubt",
            "runs ended by a doubtful scene",
            |run| usize::from(run.doubt.is_some()),
        ),
        greatest_mm(
            "deepest_overlap_mm",
            "deepest overlap of two items at the end (mm)",
            2,
            |run| run.deepest_overlap_m,
        ),
        greatest_mm(
            "greatest_disturbance_mm",
            "farthest that a placement moved another item (mm)",
            1,
            disturbance_m,
        ),
        Measured::mean(
            "compactness_percent",
            "compactness of meshes by floor (%)",
            1,
            |run| run.compactness * 100.0,
        ),
        Measured::mean("volume_l", "volume of meshes (l)", 2, |run| {
            run.volume_m3 * 1e3
        }),
        Measured::new("decision_mean_ms", "decision: mean (ms)", |runs| {
            let times_ms = decisions(runs).map(|decision| decision.total_s() * 1e3);
            Cell::mean(Mean::of(times_ms), 2)
        }),
        Measured::new("decision_ms", "decision: median, 95 % (ms)", |runs| {
            spread(decisions(runs).map(|decision| decision.total_s() * 1e3))
        }),
        decided("decisions", "decisions", |_| true),
        decided("degraded_decisions", "of these degraded", |decision| {
            !decision.degraded.is_empty()
        }),
        decided(
            "widened_decisions",
            "widened to an exhaustive search",
            |decision| decision.is_widened,
        ),
        share(
            "seen/right_percent",
            "known items recognised",
            [|item| off(item).is_some(), |item| item.is_known],
        ),
        share(
            "seen/good_poses_percent",
            "of these within 3 mm and 3 degrees",
            [
                |item| off(item).is_some_and(|off| is_within(off, GOOD_POSE)),
                |item| off(item).is_some(),
            ],
        ),
        share(
            "seen/strangers_as_unknown_percent",
            "unknown items called unknown",
            [
                |item| !item.is_known && item.seen_as == SeenAs::Unknown,
                |item| !item.is_known,
            ],
        ),
        found("found/as_planned", "inspected: as planned", "as_planned"),
        found("found/moved", "moved", "moved"),
        found("found/toppled", "toppled", "toppled"),
        found("found/missing", "missing", "missing"),
        found("found/unclear", "unclear", "unclear"),
        share(
            "found/good_poses_percent",
            "poses found within 5 mm and 5 degrees",
            [
                |item| found_off(item).is_some_and(|off| is_within(off, GOOD_FOUND)),
                |item| found_off(item).is_some(),
            ],
        ),
        Measured::new("refusals", "", |runs| {
            let items = runs.iter().flat_map(|run| &run.items);
            let mut counts = BTreeMap::<&str, usize>::new();
            for item in items {
                if let End::Refused { reason } = &item.end {
                    *counts.entry(reason.as_str()).or_default() += 1;
                }
            }
            Cell::new("", counts)
        })
        .hidden(),
    ]
}

/// How long a contender's stages took.
pub(super) fn times() -> Vec<Measured> {
    let stage = |key, head, stage: &'static str| {
        Measured::new(key, head, move |runs: &[RunRecord]| {
            let times_s = runs.iter().filter_map(|run| run.stages_s.get(stage));
            spread(times_s.flatten().map(|time_s| time_s * 1e3))
        })
    };
    vec![
        stage("stages_ms/recognise", "tray: cloud to items", "recognise"),
        stage("stages_ms/plan", "request to decision", "plan"),
        stage("stages_ms/see", "container: cloud to heightmap", "see"),
        stage("stages_ms/inspect", "placed to inspected", "inspect"),
        stage("stages_ms/simulate", "simulated placement", "simulate"),
        Measured::new("cycle_s", "arm's cycle, planned (s)", |runs| {
            let cycles_s = decisions(runs).map(|decision| decision.cycle_s);
            spread(cycles_s.filter(|cycle_s| *cycle_s > 0.0))
        }),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sheet::Lines;

    #[test]
    fn every_item_is_counted_once() {
        let item = |end, seen_as, is_known| ItemRecord {
            object: "a".to_owned(),
            is_known,
            seen_as,
            attempts: 2,
            end,
            found: None,
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
        let mut lines = Lines::new("method", vec![("tried".to_owned(), vec![record])]);
        let table = lines.upright(&came_to());
        let kept = serde_json::to_value(&lines).unwrap();
        let (items, seen) = (&kept[0]["items"], &kept[0]["seen"]);
        for (key, count) in [
            ("all", 4),
            ("placed", 2),
            ("outside", 1),
            ("toppled", 1),
            ("refused", 1),
            ("lost", 1),
            ("repeated", 4),
        ] {
            assert_eq!(items[key], count, "{key}");
        }
        assert!(table.contains("| known items recognised | 33.3 % (1 of 3) |"));
        assert_eq!(seen["good_poses_percent"], 100.0);
        assert_eq!(seen["strangers_as_unknown_percent"], 100.0);
        assert_eq!(kept[0]["greatest_disturbance_mm"], 2.0);
        assert_eq!(kept[0]["refusals"]["no room"], 1);
    }

    #[test]
    fn a_spread_is_median_and_95_percent() {
        let run = |value: f64| RunRecord {
            stages_s: BTreeMap::from([("plan".to_owned(), vec![value / 1e3])]),
            ..RunRecord::default()
        };
        let runs = (0..=100).rev().map(f64::from).map(run).collect();
        let mut lines = Lines::new("method", vec![("tried".to_owned(), runs)]);
        let table = lines.upright(&times());
        assert!(
            table.contains("| request to decision | 50.0, 95.0 |"),
            "{table}"
        );
        assert!(table.contains("| placed to inspected | – |"), "{table}");
    }
}
