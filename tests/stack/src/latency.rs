//! The times of plans, from the request to the answer.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_packing::checks::stability::{PhysicalStability, PhysicalStabilitySettings};
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::planning::plan::Planner;
use ppnpack_packing::ranking::proposals::ProposeAll;
use ppnpack_packing::ranking::search::{Search, SearchSettings};
use ppnpack_packing::ranking::step::{Candidate, StepInput};
use ppnpack_wire::{convert, v1};

use crate::cell::CellClient;

/// Times of many plans, sorted.
#[derive(Debug, Clone, Default)]
pub(crate) struct Times(Vec<Duration>);

impl Times {
    pub(crate) fn new(mut times: Vec<Duration>) -> Self {
        times.sort_unstable();
        Self(times)
    }

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

    pub(crate) fn shown(&self, share: f64) -> String {
        format!("{:.2}", self.percentile_ms(share))
    }
}

/// The times of the plans of one container.
#[derive(Debug, Clone, Default)]
pub(crate) struct Measured {
    /// The times from the request to the answer, as the controller sees them.
    pub(crate) asked: Vec<Duration>,
    /// The times of the same steps planned in this process.
    pub(crate) in_process: Vec<Duration>,
    /// The times of the planner's stages.
    pub(crate) stages: BTreeMap<String, Vec<Duration>>,
    /// The number of steps planned in another way than was asked for.
    pub(crate) degraded: usize,
}

/// Packs `objects` into a new container, and measures each plan. With `twin` each step is planned
/// in this process too, on the same heightmap: the decisions must be the same.
pub(crate) fn pack_container(
    cell: &CellClient,
    session_id: &str,
    objects: &[&str],
    mut twin: Option<&mut Twin<'_>>,
) -> Result<Measured> {
    cell.renew()?;
    cell.begin(session_id, objects, false)?;
    let mut measured = Measured::default();
    loop {
        // Until perception has seen the container, a plan waits for it: that wait is no part of
        // planning.
        let least_state_number = cell.state()?.state_number;
        let heightmap = cell.ask(v1::HeightmapRequest {
            least_state_number,
            ..v1::HeightmapRequest::default()
        })?;
        let asked = Instant::now();
        let decision = cell.plan()?;
        measured.asked.push(asked.elapsed());
        let Some(decision) = decision else {
            return Ok(measured);
        };
        for stage in &decision.stages {
            let times = measured.stages.entry(stage.stage.clone()).or_default();
            times.push(Duration::from_nanos(stage.duration_ns));
        }
        measured.degraded += usize::from(!decision.degraded.is_empty());
        if let Some(twin) = &mut twin {
            let heightmap = heightmap.heightmap.context("perception told none")?;
            let took = twin.plan(&heightmap, &decision, objects)?;
            measured.in_process.push(took);
        }
        cell.carry_out(&decision)?;
    }
}

/// The planner in this process, for comparison.
pub(crate) struct Twin<'a> {
    catalogue: &'a Catalogue,
    grid: Grid,
    planner: Planner,
}

impl<'a> Twin<'a> {
    /// The exhaustive search of the reference setting.
    pub(crate) fn new(catalogue: &'a Catalogue) -> Result<Self> {
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
            let arrival = item_id.strip_prefix("item-").context("an unknown item")?;
            let arrival: usize = arrival.parse()?;
            let name = objects.get(arrival).context("an unknown item")?;
            let (_, object) = self.catalogue.find(name).context("an unknown object")?;
            Ok(Candidate::new(arrival, object.item.clone()))
        };
        let candidates = decision.buffer.iter().map(candidate);
        let candidates: Vec<Candidate> = candidates.collect::<Result<_>>()?;
        let input = StepInput {
            step: decision.step,
            ..StepInput::new(&self.grid, &scene, &candidates)
        };
        let started = Instant::now();
        let choice = self.planner.plan(&input)?.choice();
        let took = started.elapsed();
        let choice = choice.context("the stack placed what cannot be placed")?;
        let placement = convert::placement::write_resting(&choice.resting);
        let item = decision.buffer.get(choice.candidate);
        ensure!(
            item == Some(&decision.item_id) && decision.placement == Some(placement),
            "step {}: the stack decided {:?}, the same search in this process {choice:?}",
            decision.step,
            decision.placement
        );
        Ok(took)
    }
}
