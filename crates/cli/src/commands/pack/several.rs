//! `ppnpack pack --open`: a sequence packed into one container after another, several of which may be open at the same time.

use std::time::Instant;

use indicatif::ProgressBar;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_packing::check::Evidence;
use ppnpack_packing::closing::ClosingRules;
use ppnpack_packing::containers::ContainerChoice;
use ppnpack_packing::episode::{PackingCell, Step};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::metrics::Metrics;
use ppnpack_packing::orders::{ContainerRules, Orders};
use ppnpack_packing::placement::RestingPlacement;
use ppnpack_packing::plan::{Candidate, Planner, StageError};
use ppnpack_packing::stream::{ContainerSupply, Filled, StreamPlay, play_stream};
use ppnpack_physics::packing_cell::SimulatedPackingCell;

use super::super::job::ResultOptions;
use super::{content, moves, settled};
use crate::failure::{OrRun, Outcome};
use crate::options::Simulated;
use crate::progress;
use crate::report::{ArmWork, EndingSummary, Packing, Settings, Unplaceable};
use crate::simulation::empty_cell;

/// Of an item that no container takes.
const FITS_NOWHERE: &str = "it has no valid placement in an empty container";

/// What is packed, and with what.
pub(super) struct Job<'a> {
    pub(super) catalogue: &'a Catalogue,
    pub(super) settings: Settings,
    /// Makes who plans for a container.
    pub(super) planner: &'a dyn Fn() -> Outcome<Planner>,
    pub(super) work: Option<ArmWork>,
}

/// Packs all of a job into containers of which so many are open at the same time, and reports on each.
pub(super) fn pack(job: &Job<'_>, open: u8, results: &ResultOptions) -> Outcome {
    let Settings { sequence, grid, .. } = &job.settings;
    let started = Instant::now();
    let bar = progress::bar("Packing", sequence.objects.len() as u64);
    let orders = Orders::new(ContainerRules::default(), std::iter::empty());
    let items = sequence.candidates(job.catalogue);
    let how = StreamPlay {
        open: usize::from(open),
        buffer: job.settings.method.method.buffer,
        choice: ContainerChoice::Fullest,
        closing: ClosingRules::default(),
        expected_percent: 100.0,
    };
    let sizes = std::slice::from_ref(grid);
    let mut supply = Supply { job, bar: &bar };
    let stream = play_stream(sizes, &mut supply, items, orders, how).or_run()?;
    bar.finish_and_clear();
    let filled = stream.closed.into_iter().chain(stream.open);
    let mut begun: Vec<Filled<_>> = filled.filter(|filled| !filled.steps.is_empty()).collect();
    begun.sort_by_key(|filled| filled.number);
    let packings = begun.into_iter();
    let packings = packings.map(|filled| packing(job, filled, started));
    let packings: Vec<Packing> = packings.collect();
    let left = stream.unplaceable.iter();
    let left = left.map(|candidate| Unplaceable::new(candidate, FITS_NOWHERE.to_owned()));
    results.publish_several(&packings, left.collect(), open, &job.settings)
}

/// What became of a container; its steps are numbered anew.
fn packing(job: &Job<'_>, filled: Filled<WatchedCell<'_>>, started: Instant) -> Packing {
    let packed = filled.packed();
    let Filled {
        grid,
        cell: WatchedCell { cell, .. },
        steps,
        scene,
        closing,
        ..
    } = filled;
    let numbered = steps.into_iter().zip(0..);
    let numbered = numbered.map(|(step, number)| Step {
        step: number,
        ..step
    });
    Packing {
        settings: job.settings.clone(),
        steps: numbered.collect(),
        settled: cell.placed().iter().map(settled).collect(),
        moves: cell.placed().iter().map(moves).collect(),
        ending: match closing {
            Some(why) => EndingSummary::Closed {
                why: why.to_string(),
            },
            None => EndingSummary::AllPacked,
        },
        set_aside: Vec::new(),
        metrics: Metrics::new(&grid, scene.heightmap(), packed),
        scene,
        contents: cell.contents().into_iter().map(content).collect(),
        took: started.elapsed(),
        arm: job.work.clone(),
    }
}

/// Brings empty containers.
struct Supply<'a> {
    job: &'a Job<'a>,
    bar: &'a ProgressBar,
}

impl<'a> ContainerSupply for Supply<'a> {
    type Cell = WatchedCell<'a>;

    fn next(
        &mut self,
        number: usize,
        grid: &Grid,
    ) -> Result<(Planner, WatchedCell<'a>), StageError> {
        let planner = (self.job.planner)().map_err(|failure| failure.to_string())?;
        let simulated = &self.job.settings.simulated;
        let mut settings = simulated.cell.clone();
        // Each container is another draw of what is random.
        settings.seed = settings.seed.wrapping_add(number as u64);
        let simulated = Simulated {
            cell: settings,
            ..simulated.clone()
        };
        let cell = empty_cell(self.job.catalogue, grid, &simulated);
        let cell = cell.map_err(|failure| failure.to_string())?;
        let bar = self.bar;
        Ok((planner, WatchedCell { cell, bar }))
    }
}

/// A cell that shows how far the packing is.
struct WatchedCell<'a> {
    cell: SimulatedPackingCell,
    bar: &'a ProgressBar,
}

impl PackingCell for WatchedCell<'_> {
    fn scan(&mut self) -> Result<Scene, StageError> {
        self.cell.scan()
    }

    fn place(
        &mut self,
        item: &Candidate,
        resting: &RestingPlacement,
        evidence: &Evidence,
    ) -> Result<(), StageError> {
        self.bar.inc(1);
        self.cell.place(item, resting, evidence)
    }

    fn is_inside(&self, arrival: usize) -> bool {
        self.cell.is_inside(arrival)
    }
}
