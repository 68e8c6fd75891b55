//! What was measured, against limits and estimates.

use std::collections::BTreeMap;

use ppnpack_chart::{Bar, Bars};
use serde::Serialize;

use super::LoadsArguments;
use super::packing::{Reading, Run, State};
use crate::filling::Way;
use crate::statistics::{Mean, percentage, quantiles};

/// Loads below this say little of the estimate, in kilograms.
const NOTICEABLE_KG: f64 = 0.05;

/// Limits may be exceeded by so much, as a share of them.
const TOLERATED: f64 = 0.1;

/// All that was found.
#[derive(Debug, Serialize)]
pub(super) struct Results<'a> {
    first_case: u32,
    cases: u32,
    items: u32,
    least_factor: f64,
    greatest_factor: f64,
    limits_seed: u64,
    way: &'a Way,
    lines: Vec<Line>,
    #[serde(skip)]
    first: Vec<Run>,
}

#[derive(Debug, Serialize)]
struct Line {
    /// None without limits.
    margin: Option<f64>,
    meshes_cm3: Mean,
    /// To the line without limits, sequence by sequence.
    difference_cm3: Mean,
    difference_percent: f64,
    placed: usize,
    unsteady: usize,
    refused: Mean,
    /// Items that carried more than they may after some placement.
    exceeded: usize,
    exceeded_noticeably: usize,
    /// Containers with such an item.
    containers_noticeably: usize,
    /// Items that carry that much more at the end.
    exceeded_noticeably_at_end: usize,
    /// The greatest share of its limit that an item carried.
    greatest_share: f64,
    states: usize,
    states_in_motion: usize,
    /// Of the whole mass that presses and is pressed: 99 % of the loads are measured at least so well, in kilograms.
    unbalanced_99_kg: f64,
    ratios: Ratios,
    /// Those of which a limit is exceeded most.
    worst: Vec<Excess>,
}

/// Loads at the end as measured, by what was estimated.
#[derive(Debug, Serialize)]
struct Ratios {
    loads: usize,
    median: f64,
    most_95: f64,
    most_99: f64,
    greatest: f64,
    /// Estimated at less than a tenth of what they are.
    missed: usize,
    /// More than a tenth above all that was thought to rest there.
    beyond_all_above: usize,
}

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

impl Ratios {
    fn of(runs: &[Run]) -> Self {
        let last = runs.iter().filter_map(|run| run.states.last());
        let readings = last.flat_map(|state| &state.readings);
        let noticeable: Vec<&Reading> = readings
            .filter(|reading| reading.measured_kg >= NOTICEABLE_KG)
            .collect();
        let ratios = noticeable
            .iter()
            .map(|reading| reading.measured_kg / reading.estimated_kg);
        let [median, most_95, most_99, greatest] = quantiles(ratios, [0.5, 0.95, 0.99, 1.0]);
        let count = |is: fn(&Reading) -> bool| noticeable.iter().filter(|of| is(of)).count();
        Self {
            loads: noticeable.len(),
            median,
            most_95,
            most_99,
            greatest,
            missed: count(|of| of.estimated_kg < 0.1 * of.measured_kg),
            beyond_all_above: count(|of| of.measured_kg > (1.0 + TOLERATED) * of.above_kg),
        }
    }
}

impl Line {
    fn new(margin: Option<f64>, runs: &[Run], first: &[Run], limits_kg: &[f64]) -> Self {
        let cm3 = |run: &Run| run.meshes_m3 * 1e6;
        let meshes_cm3 = Mean::of(runs.iter().map(cm3));
        let pairs = runs.iter().zip(first);
        let difference_cm3 = Mean::of(pairs.map(|(run, first)| cm3(run) - cm3(first)));
        let compared = Mean::of(first.iter().map(cm3)).mean;
        let of_runs: Vec<Vec<Excess>> = runs.iter().map(|run| greatest(run, limits_kg)).collect();
        let is_noticeable = |excess: &&Excess| excess.share() > 1.0 + TOLERATED;
        let at_end = runs.iter().filter_map(|run| {
            let last = run.states.last()?;
            let all = excesses(run, run.states.len() - 1, last, limits_kg);
            Some(all.iter().filter(is_noticeable).count())
        });
        let all = || of_runs.iter().flatten();
        let mut worst: Vec<Excess> = all().filter(is_noticeable).copied().collect();
        worst.sort_by(|one, other| other.share().total_cmp(&one.share()));
        worst.truncate(50);
        let states = || runs.iter().flat_map(|run| &run.states);
        let unbalanced = states().flat_map(|state| &state.readings);
        let unbalanced = unbalanced.map(|reading| reading.unbalanced_kg.abs());
        let [unbalanced_99_kg] = quantiles(unbalanced, [0.99]);
        Self {
            margin,
            meshes_cm3,
            difference_percent: 100.0 * difference_cm3.mean / compared,
            difference_cm3,
            placed: runs.iter().map(|run| run.placed).sum(),
            unsteady: runs.iter().map(|run| run.unsteady).sum(),
            refused: Mean::of(runs.iter().map(|run| run.refused as f64)),
            exceeded: all().filter(|excess| excess.share() > 1.0).count(),
            exceeded_noticeably: all().filter(is_noticeable).count(),
            containers_noticeably: of_runs
                .iter()
                .filter(|of_run| of_run.iter().any(|excess| is_noticeable(&excess)))
                .count(),
            exceeded_noticeably_at_end: at_end.sum(),
            greatest_share: all().map(Excess::share).fold(0.0, f64::max),
            states: states().count(),
            states_in_motion: states().filter(|state| !state.is_still).count(),
            unbalanced_99_kg,
            ratios: Ratios::of(runs),
            worst,
        }
    }

    fn name(&self) -> String {
        self.margin
            .map_or_else(|| "no limits".to_owned(), |margin| margin.to_string())
    }
}

impl<'a> Results<'a> {
    pub(super) fn new(arguments: &LoadsArguments, way: &'a Way) -> Self {
        let limits = arguments.limits;
        Self {
            first_case: arguments.sequences.first,
            cases: arguments.sequences.cases,
            items: arguments.items,
            least_factor: limits.least_factor,
            greatest_factor: limits.greatest_factor,
            limits_seed: limits.limits_seed,
            way,
            lines: Vec::new(),
            first: Vec::new(),
        }
    }

    /// Adds the runs of a line.
    pub(super) fn add(&mut self, margin: Option<f64>, runs: Vec<Run>, limits_kg: &[f64]) {
        let first = match self.lines.is_empty() {
            true => &runs,
            false => &self.first,
        };
        let line = Line::new(margin, &runs, first, limits_kg);
        self.lines.push(line);
        if self.lines.len() == 1 {
            self.first = runs;
        }
    }

    /// How many containers had an item that carried noticeably more than it may.
    pub(super) fn chart(&self) -> Bars {
        let bar = |line: &Line| Bar {
            label: match line.margin {
                Some(margin) => format!("margin {margin}"),
                None => "no limits".to_owned(),
            },
            value: line.containers_noticeably as f64,
        };
        Bars {
            title: "An item carried over 110 % of what it may".to_owned(),
            value_label: "Containers".to_owned(),
            bars: self.lines.iter().map(bar).collect(),
        }
    }

    pub(super) fn markdown(&self) -> String {
        let mut text = format!(
            "# Loads: measured, estimated, allowed\n\n\
             {} containers of up to {} items, sequences from {} on, method *{}*. Each object may carry between {} and {} times its own mass, a \
             factor drawn once an object (seed {}), or what the catalogue says. Loads are measured in the simulated cell, at rest, after every \
             placement: the vertical forces, friction among them, with which other items press an item down. Impacts are not measured. Limits \
             *exceeded* are items that carried more after any placement. Differences are to packing without limits, sequence by sequence, \
             with 95 % intervals by Student's t.\n\n\
             | margin | mesh volume (cm³) | difference (cm³) | | placements refused by load | limits exceeded | by more than 10 % | containers \
             with these | at the end | greatest share of a limit | unsteady |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
            self.cases,
            self.items,
            self.first_case,
            self.way.name,
            self.least_factor,
            self.greatest_factor,
            self.limits_seed
        );
        for line in &self.lines {
            text += &format!(
                "| {} | {} | {} | {:+.1} % | {} | {} | {} | {} of {} | {} | {:.2} | {:.1} % ({} of {}) |\n",
                line.name(),
                line.meshes_cm3.shown(0),
                line.difference_cm3.shown(0),
                line.difference_percent,
                line.refused.shown(0),
                line.exceeded,
                line.exceeded_noticeably,
                line.containers_noticeably,
                self.cases,
                line.exceeded_noticeably_at_end,
                line.greatest_share,
                percentage(line.unsteady, line.placed),
                line.unsteady,
                line.placed
            );
        }
        text += "\nLoads of at least 50 g at the end, as measured, by what is estimated from where all items lie then. *Missed* are those estimated at \
                 less than a tenth; *beyond all above* those more than 10 % greater than the mass of all that was thought to rest there. *In \
                 motion* are placements after which something still moved; *unbalanced* says how exact the measure is: the difference between \
                 what an item is held up with and what it weighs and carries, for 99 % of them.\n\n\
                 | margin | loads | median | 95 % | 99 % | greatest | missed | beyond all above | in motion | unbalanced |\n\
                 |---|---|---|---|---|---|---|---|---|---|\n";
        for line in &self.lines {
            let ratios = &line.ratios;
            text += &format!(
                "| {} | {} | {:.2} | {:.2} | {:.2} | {:.2} | {} | {} | {} of {} | {:.1} g |\n",
                line.name(),
                ratios.loads,
                ratios.median,
                ratios.most_95,
                ratios.most_99,
                ratios.greatest,
                ratios.missed,
                ratios.beyond_all_above,
                line.states_in_motion,
                line.states,
                line.unbalanced_99_kg * 1e3
            );
        }
        text
    }
}
