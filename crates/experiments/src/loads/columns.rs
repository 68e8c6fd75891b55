//! What was measured, against limits and estimates, column by column.

use std::collections::BTreeMap;

use serde::Serialize;

use super::packing::{Reading, Run, State};
use crate::sheet::{Cell, Column};
use crate::statistics::quantiles;

/// A column of this experiment's tables.
type Measured<'a> = Column<'a, Run>;

/// Loads below this say little of the estimate, in kilograms.
const NOTICEABLE_KG: f64 = 0.05;

/// Limits may be exceeded by so much, as a share of them.
const TOLERATED: f64 = 0.1;

#[derive(Debug, Clone, Copy, Serialize)]
struct Excess {
    sequence: u32,
    /// Placements until then.
    placed: usize,
    object: usize,
    limit_kg: f64,
    is_still: bool,
    reading: Reading,
}

impl Excess {
    fn share(&self) -> f64 {
        self.reading.measured_kg / self.limit_kg
    }

    fn is_noticeable(&self) -> bool {
        self.share() > 1.0 + TOLERATED
    }
}

/// The greatest share of its limit that each item of a run carried.
fn greatest(run: &Run, limits_kg: &[f64]) -> Vec<Excess> {
    let mut greatest: BTreeMap<usize, Excess> = BTreeMap::new();
    for (index, state) in run.states.iter().enumerate() {
        for excess in excesses(run, index, state, limits_kg) {
            let known = greatest.entry(excess.reading.arrival).or_insert(excess);
            if excess.share() > known.share() {
                *known = excess;
            }
        }
    }
    greatest.into_values().collect()
}

fn excesses(run: &Run, index: usize, state: &State, limits_kg: &[f64]) -> Vec<Excess> {
    let of = |reading: &Reading| {
        let object = *run.objects.get(reading.arrival)?;
        Some(Excess {
            sequence: run.number,
            placed: index + 1,
            object,
            limit_kg: *limits_kg.get(object)?,
            is_still: state.is_still,
            reading: *reading,
        })
    };
    state.readings.iter().filter_map(of).collect()
}

/// Those that are exceeded noticeably.
fn noticeable(run: &Run, limits_kg: &[f64]) -> Vec<Excess> {
    let mut all = greatest(run, limits_kg);
    all.retain(Excess::is_noticeable);
    all
}

/// How many items carry noticeably more than they may at the end.
fn at_end(run: &Run, limits_kg: &[f64]) -> usize {
    let last = run.states.iter().enumerate().next_back();
    let all = last.map(|(index, state)| excesses(run, index, state, limits_kg));
    all.iter().flatten().filter(|it| it.is_noticeable()).count()
}

/// What is allowed, and what it costs.
pub(super) fn limits(limits_kg: &[f64]) -> Vec<Measured<'_>> {
    let cm3 = |run: &Run| run.meshes_m3 * 1e6;
    let count = move |run: &Run| noticeable(run, limits_kg).len();
    vec![
        Measured::mean("meshes_cm3", "mesh volume (cm³)", 0, cm3),
        Measured::difference("difference_cm3", "difference (cm³)", 0, cm3),
        Measured::change("difference_percent", cm3),
        Measured::mean("refused", "placements refused by load", 0, |run| {
            run.refused as f64
        }),
        Measured::sum("exceeded", "limits exceeded", move |run| {
            let all = greatest(run, limits_kg);
            all.iter().filter(|excess| excess.share() > 1.0).count()
        }),
        Measured::sum("exceeded_noticeably", "by more than 10 %", count),
        Measured::sum(
            "containers_noticeably",
            "containers with these",
            move |run| usize::from(count(run) > 0),
        ),
        Measured::sum("exceeded_noticeably_at_end", "at the end", move |run| {
            at_end(run, limits_kg)
        }),
        Measured::new(
            "greatest_share",
            "greatest share of a limit",
            move |runs: &[Run]| {
                let all = runs.iter().flat_map(|run| greatest(run, limits_kg));
                let share = all.map(|excess| excess.share()).fold(0.0, f64::max);
                Cell::number(share, 2)
            },
        ),
        Measured::share("unsteady_percent", "unsteady", |run| {
            [run.unsteady, run.placed]
        }),
        Measured::sum("placed", "", |run| run.placed).hidden(),
        Measured::sum("unsteady", "", |run| run.unsteady).hidden(),
        Measured::new("worst", "", move |runs: &[Run]| {
            let all = runs.iter().flat_map(|run| noticeable(run, limits_kg));
            let mut worst: Vec<Excess> = all.collect();
            worst.sort_by(|one, other| other.share().total_cmp(&one.share()));
            worst.truncate(50);
            Cell::new("", worst)
        })
        .hidden(),
    ]
}

/// Loads at the end as measured, by what was estimated.
pub(super) fn ratios() -> Vec<Measured<'static>> {
    fn noticeable(runs: &[Run]) -> impl Iterator<Item = &Reading> {
        let last = runs.iter().filter_map(|run| run.states.last());
        let readings = last.flat_map(|state| &state.readings);
        readings.filter(|reading| reading.measured_kg >= NOTICEABLE_KG)
    }
    let ratio = |key, head, share: f64| {
        Measured::new(key, head, move |runs: &[Run]| {
            let ratios = noticeable(runs).map(|it| it.measured_kg / it.estimated_kg);
            let [ratio] = quantiles(ratios, [share]);
            Cell::number(ratio, 2)
        })
    };
    let count = |key, head, is: fn(&Reading) -> bool| {
        Measured::new(key, head, move |runs: &[Run]| {
            Cell::count(noticeable(runs).filter(|reading| is(reading)).count())
        })
    };
    vec![
        count("ratios/loads", "loads", |_| true),
        ratio("ratios/median", "median", 0.5),
        ratio("ratios/most_95", "95 %", 0.95),
        ratio("ratios/most_99", "99 %", 0.99),
        ratio("ratios/greatest", "greatest", 1.0),
        count("ratios/missed", "missed", |it| {
            it.estimated_kg < 0.1 * it.measured_kg
        }),
        count("ratios/beyond_all_above", "beyond all above", |it| {
            it.measured_kg > (1.0 + TOLERATED) * it.above_kg
        }),
        Measured::share("states_in_motion_percent", "in motion", |run| {
            let moving = run.states.iter().filter(|state| !state.is_still);
            [moving.count(), run.states.len()]
        }),
        Measured::new("unbalanced_99_kg", "unbalanced", |runs: &[Run]| {
            let states = runs.iter().flat_map(|run| &run.states);
            let readings = states.flat_map(|state| &state.readings);
            let [kg] = quantiles(readings.map(|it| it.unbalanced_kg.abs()), [0.99]);
            Cell::new(format!("{:.1} g", kg * 1e3), kg)
        }),
    ]
}
