//! What the runs of a contender come to.

use std::collections::BTreeMap;

use serde::Serialize;

use super::record::{End, FoundKind, ItemRecord, RunRecord, SeenAs, Stage};
use crate::statistics::{Mean, nearest_rank};

/// How far a pose may be off, in metres and radians.
const GOOD_POSE: (f64, f64) = (0.003, 0.053);

/// The same for a pose found after a placement.
const GOOD_FOUND: (f64, f64) = (0.005, 0.088);

#[derive(Debug, Serialize)]
pub(super) struct Line {
    pub(super) method: String,
    /// What files are named by.
    #[serde(skip)]
    pub(super) key: &'static str,
    pub(super) runs: usize,
    pub(super) items: Items,
    pub(super) seen: Seen,
    pub(super) found: FoundItems,
    /// Per run, in percent.
    pub(super) compactness_percent: Mean,
    /// Per run, in litres.
    pub(super) volume_l: Mean,
    /// Per decision.
    pub(super) decision_ms: Spread,
    pub(super) decision_mean_ms: Mean,
    pub(super) degraded_decisions: usize,
    /// Searched exhaustively, as none of their proposals was valid.
    pub(super) widened_decisions: usize,
    pub(super) decisions: usize,
    /// The planned time of the arm's cycle.
    pub(super) cycle_s: Spread,
    pub(super) stages_ms: BTreeMap<Stage, Spread>,
    pub(super) deepest_overlap_mm: f64,
    pub(super) greatest_disturbance_mm: f64,
    pub(super) runs_ended_by_doubt: usize,
    pub(super) refusals: BTreeMap<String, usize>,
    pub(super) records: Vec<RunRecord>,
}

/// What became of the items.
#[derive(Debug, Default, Serialize)]
pub(super) struct Items {
    pub(super) all: usize,
    pub(super) placed: usize,
    /// Of those that were placed: not inside the container.
    pub(super) outside: usize,
    /// Of those that were placed: leaning by more than 30 degrees.
    pub(super) toppled: usize,
    pub(super) refused: usize,
    pub(super) lost: usize,
    /// Attempts beyond the first.
    pub(super) repeated: usize,
}

/// How items were seen on the tray.
#[derive(Debug, Default, Serialize)]
pub(super) struct Seen {
    /// Those that can be recognised.
    pub(super) known: usize,
    pub(super) right: usize,
    /// Of the right ones: within 3 mm and 3 degrees.
    pub(super) good_poses: usize,
    pub(super) wrong: usize,
    pub(super) known_as_unknown: usize,
    /// Those that cannot.
    pub(super) strangers: usize,
    pub(super) strangers_as_unknown: usize,
    pub(super) not_found: usize,
}

/// How placed items were found by inspection.
#[derive(Debug, Default, Serialize)]
pub(super) struct FoundItems {
    pub(super) kinds: BTreeMap<FoundKind, usize>,
    /// With a pose, of items that were recognised rightly; of these, within 5 mm and 5 degrees of the truth.
    pub(super) poses: usize,
    pub(super) good_poses: usize,
}

impl FoundItems {
    fn of<'a>(items: impl Iterator<Item = &'a ItemRecord>) -> Self {
        let mut sums = Self::default();
        for found in items.filter_map(|item| item.found.as_ref()) {
            *sums.kinds.entry(found.kind).or_default() += 1;
            if let Some((off_m, off_rad)) = found.position_off_m.zip(found.angle_off_rad) {
                sums.poses += 1;
                let is_good = off_m <= GOOD_FOUND.0 && off_rad <= GOOD_FOUND.1;
                sums.good_poses += usize::from(is_good);
            }
        }
        sums
    }

    pub(super) fn shown(&self) -> String {
        let count = |kind| self.kinds.get(&kind).copied().unwrap_or_default();
        FoundKind::ALL
            .map(|kind| count(kind).to_string())
            .join(", ")
    }
}

/// The median of some values, and what 95 % of them stay below.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(super) struct Spread {
    pub(super) median: f64,
    pub(super) most: f64,
    pub(super) count: usize,
}

impl Spread {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.collect();
        values.sort_by(f64::total_cmp);
        Self {
            median: nearest_rank(&values, 0.5).unwrap_or_default(),
            most: nearest_rank(&values, 0.95).unwrap_or_default(),
            count: values.len(),
        }
    }

    pub(super) fn shown(&self) -> String {
        match self.count {
            0 => "–".to_owned(),
            _ => format!("{:.1}, {:.1}", self.median, self.most),
        }
    }
}

impl Line {
    pub(super) fn new(method: &str, key: &'static str, records: Vec<RunRecord>) -> Self {
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
        let cycles_s = decisions().map(|decision| decision.cycle_s);
        let overlaps = records.iter().map(|run| run.deepest_overlap_m * 1e3);
        Self {
            method: method.to_owned(),
            key,
            runs: records.len(),
            items: Items::of(items()),
            seen: Seen::of(items()),
            found: FoundItems::of(items()),
            compactness_percent: Mean::of(records.iter().map(|run| run.compactness * 100.0)),
            volume_l: Mean::of(records.iter().map(|run| run.volume_m3 * 1e3)),
            decision_ms: Spread::of(decisions().map(|decision| decision.total_s() * 1e3)),
            decision_mean_ms: Mean::of(decisions().map(|decision| decision.total_s() * 1e3)),
            degraded_decisions: decisions().filter(|it| !it.degraded.is_empty()).count(),
            widened_decisions: decisions().filter(|it| it.is_widened).count(),
            decisions: decisions().count(),
            cycle_s: Spread::of(cycles_s.filter(|cycle_s| *cycle_s > 0.0)),
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
            match &item.seen_as {
                SeenAs::Nothing => sums.not_found += 1,
                SeenAs::Unknown if item.is_known => sums.known_as_unknown += 1,
                SeenAs::Unknown => sums.strangers_as_unknown += 1,
                SeenAs::Object {
                    position_off_m,
                    angle_off_rad,
                    ..
                } if item.is_known => {
                    let off = position_off_m.zip(*angle_off_rad);
                    sums.right += usize::from(off.is_some());
                    sums.wrong += usize::from(off.is_none());
                    let is_good = |(off_m, off_rad)| off_m <= GOOD_POSE.0 && off_rad <= GOOD_POSE.1;
                    sums.good_poses += usize::from(off.is_some_and(is_good));
                }
                SeenAs::Object { .. } => {}
            }
            sums.known += usize::from(item.is_known);
            sums.strangers += usize::from(!item.is_known);
        }
        sums
    }
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
        let line = Line::new("tried", "tried", vec![record]);
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
