//! How long plans take, from the request to the answer.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::plan::Planner;
use ppnpack_packing::proposals::ProposeAll;
use ppnpack_packing::search::{Search, SearchSettings};
use ppnpack_packing::stability::{PhysicalStability, PhysicalStabilitySettings};
use ppnpack_packing::step::{Candidate, StepInput};
use ppnpack_wire::{convert, v1};

use crate::cell::CellClient;

/// Times of many plans, sorted.
#[derive(Debug, Clone, Default)]
pub(crate) struct Times(Vec<Duration>);

impl Times {
    /// The times.
    pub(crate) fn new(mut times: Vec<Duration>) -> Self {
        times.sort_unstable();
        Self(times)
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.0.len()
    }

    /// The time that this share of them does not exceed, in milliseconds.
    pub(crate) fn percentile_ms(&self, share: f64) -> f64 {
        let last = self.0.len().saturating_sub(1);
        let index = (share * last as f64).round() as usize;
        self.0
            .get(index)
            .map_or(f64::NAN, |time| time.as_secs_f64() * 1e3)
    }

    /// The same as it stands in a table.
    pub(crate) fn shown(&self, share: f64) -> String {
        format!("{:.2}", self.percentile_ms(share))
    }
}

/// The plans of the same steps through two stacks; times in milliseconds.
#[derive(Debug, Clone)]
pub(crate) struct Compared {
    /// How many steps.
    pub(crate) plans: usize,
    /// The median of the other stack.
    pub others_p50_ms: f64,
    /// The median of this one.
    pub own_p50_ms: f64,
    /// How much longer this one took for the same step: the median in the middle, between the ends of its 95 % interval.
    pub(crate) difference_ms: [f64; 3],
}

impl Compared {
    /// By the times of the same steps.
    pub(crate) fn new(others: &[Duration], own: &[Duration]) -> Self {
        let ms = |took: &Duration| took.as_secs_f64() * 1e3;
        let differences = own.iter().zip(others);
        let mut differences: Vec<f64> = differences
            .map(|(own, other)| ms(own) - ms(other))
            .collect();
        differences.sort_unstable_by(f64::total_cmp);
        let median_ms = |times: &[Duration]| Times::new(times.to_vec()).percentile_ms(0.5);
        Self {
            plans: differences.len(),
            others_p50_ms: median_ms(others),
            own_p50_ms: median_ms(own),
            difference_ms: median_with_interval(&differences),
        }
    }
}

/// The median of sorted values, between the ends of its 95 % interval by order statistics: how many of so many values lie below the median
/// is binomial. Not numbers where there are none.
fn median_with_interval(sorted: &[f64]) -> [f64; 3] {
    let count = sorted.len() as f64;
    let half = 1.96 * count.sqrt() / 2.0;
    let last = count - 1.0;
    let at = |rank: f64| sorted.get(rank.clamp(0.0, last.max(0.0)) as usize);
    let ranks = [last / 2.0 - half, last / 2.0, last / 2.0 + half];
    ranks.map(|rank| at(rank.round()).copied().unwrap_or(f64::NAN))
}

/// What the plans of one container took.
#[derive(Debug, Clone, Default)]
pub(crate) struct Measured {
    /// From the request for a plan to its answer, as the controller sees it.
    pub(crate) asked: Vec<Duration>,
    /// The same steps planned in this process.
    pub(crate) in_process: Vec<Duration>,
    /// What the planner spent on each stage of a decision.
    pub(crate) stages: BTreeMap<String, Vec<Duration>>,
    /// Steps planned in another way than was asked for.
    pub(crate) degraded: usize,
}

/// A container that is packed step by step, each plan of which is measured.
pub(crate) struct Packing<'a> {
    cell: &'a CellClient,
    objects: &'a [&'a str],
    measured: Measured,
}

impl<'a> Packing<'a> {
    /// Begins to pack `objects` into a new container.
    pub(crate) fn begin(
        cell: &'a CellClient,
        session_id: &str,
        objects: &'a [&'a str],
    ) -> Result<Self> {
        cell.renew()?;
        cell.begin(session_id, objects, false)?;
        Ok(Self {
            cell,
            objects,
            measured: Measured::default(),
        })
    }

    /// Plans and places the next item; says whether there was one. With `twin` the step is also planned in this process, on the same
    /// heightmap; where the search is exhaustive the decisions must be the same.
    pub(crate) fn step(&mut self, twin: Option<&mut Twin<'_>>) -> Result<bool> {
        let Self {
            cell,
            objects,
            measured,
        } = self;
        // Until perception has seen the container, a plan waits for it: that wait is no part of planning.
        let least_state_number = cell.state()?.state_number;
        let heightmap = cell.ask(v1::HeightmapRequest {
            least_state_number,
            ..v1::HeightmapRequest::default()
        })?;
        let asked = Instant::now();
        let decision = cell.plan()?;
        measured.asked.push(asked.elapsed());
        let Some(decision) = decision else {
            return Ok(false);
        };
        for stage in &decision.stages {
            let times = measured.stages.entry(stage.stage.clone()).or_default();
            times.push(Duration::from_nanos(stage.duration_ns));
        }
        measured.degraded += usize::from(!decision.degraded.is_empty());
        if let Some(twin) = twin {
            let heightmap = heightmap
                .heightmap
                .context("perception told no heightmap")?;
            measured
                .in_process
                .push(twin.plan(&heightmap, &decision, objects)?);
        }
        let outcome = cell.place(&decision)?;
        cell.report(&decision, outcome)?;
        Ok(true)
    }

    /// What its plans took.
    pub(crate) fn measured(self) -> Measured {
        self.measured
    }
}

/// The planner in this process, for comparison.
pub(crate) struct Twin<'a> {
    catalogue: &'a Catalogue,
    grid: Grid,
    planner: Planner,
    is_exhaustive: bool,
}

impl<'a> Twin<'a> {
    /// The exhaustive search of the reference setting. Where the stack searches exhaustively too, the decisions are
    /// compared.
    pub(crate) fn new(catalogue: &'a Catalogue, is_exhaustive: bool) -> Result<Self> {
        let grid = Grid::reference();
        let settings = SearchSettings::default();
        let search = Search::new(&grid, &settings)?.bounded();
        let stability = PhysicalStability::new(PhysicalStabilitySettings::default());
        let planner = Planner::new(
            Box::new(ProposeAll),
            Box::new(search),
            vec![Box::new(stability)],
            settings.order,
            settings.seed,
        );
        Ok(Self {
            catalogue,
            grid,
            planner,
            is_exhaustive,
        })
    }

    fn plan(
        &mut self,
        heightmap: &v1::Heightmap,
        decision: &v1::Decision,
        objects: &[&str],
    ) -> Result<Duration> {
        let (grid, scene) = convert::scene::read_required("scene", heightmap.scene.as_ref())?;
        ensure!(grid == self.grid, "the stack uses another grid");
        let candidate = |item_id: &String| {
            let arrival: usize = item_id
                .strip_prefix("item-")
                .context("an unknown item")?
                .parse()?;
            let name = objects.get(arrival).context("an unknown item")?;
            let (_, object) = self.catalogue.find(name).context("an unknown object")?;
            Ok(Candidate::new(arrival, object.item.clone()))
        };
        let candidates: Vec<Candidate> = decision
            .buffer
            .iter()
            .map(candidate)
            .collect::<Result<_>>()?;
        let input = StepInput {
            step: decision.step,
            ..StepInput::new(&self.grid, &scene, &candidates)
        };
        let started = Instant::now();
        let choice = self.planner.plan(&input)?.choice();
        let took = started.elapsed();
        if self.is_exhaustive {
            let choice = choice.context("the stack placed what cannot be placed")?;
            let placement = convert::placement::write_resting(&choice.resting);
            let item = decision.buffer.get(choice.candidate);
            ensure!(
                item == Some(&decision.item_id) && decision.placement == Some(placement),
                "step {}: the stack decided {:?}, the same search in this process {:?}",
                decision.step,
                decision.placement,
                choice
            );
        }
        Ok(took)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_compared_one_by_one() {
        let ms = |times: &[u64]| -> Vec<Duration> {
            times.iter().map(|ms| Duration::from_millis(*ms)).collect()
        };
        // One step takes long in both.
        let (others, own) = (ms(&[1, 50, 3, 4, 5]), ms(&[3, 52, 5, 6, 7]));
        let compared = Compared::new(&others, &own);
        assert_eq!(compared.plans, 5);
        assert!((compared.others_p50_ms - 4.0).abs() < 1e-9);
        assert!((compared.own_p50_ms - 6.0).abs() < 1e-9);
        for difference_ms in compared.difference_ms {
            assert!((difference_ms - 2.0).abs() < 1e-9, "{compared:?}");
        }
        assert!(Compared::new(&[], &[]).difference_ms[1].is_nan());
    }

    #[test]
    fn the_interval_of_a_median_has_as_many_values_as_the_binomial_says() {
        let sorted: Vec<f64> = (0..100).map(f64::from).collect();
        assert_eq!(median_with_interval(&sorted), [40.0, 50.0, 59.0]);
    }
}
