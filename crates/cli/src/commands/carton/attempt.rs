//! One try: the items of an order are packed in a sequence, and what was planned is done again.

use std::collections::BTreeMap;

use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_packing::checks::check::Evidence;
use ppnpack_packing::checks::trial::RIM_TOLERANCE_M;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::placement::RestingPlacement;
use ppnpack_packing::planning::method::Method;
use ppnpack_packing::ranking::step::{Candidate, StageError};
use ppnpack_packing::scene::Scene;
use ppnpack_packing::streams::carton::Sequence;
use ppnpack_packing::streams::episode::{Ending, Episode, PackingCell, Play, Step, play};
use ppnpack_physics::outcome::BodyState;
use ppnpack_physics::packing_cell::SimulatedPackingCell;
use ppnpack_physics::trial;
use ppnpack_physics::twin::TwinSettings;

use super::super::job::ALTERNATIVES;
use crate::failure::{OrInput, OrRun, Outcome};
use crate::options::Simulated;
use crate::report::{Settled, Unplaceable};

/// Standard deviation per axis with which the plan is done again beside its places, in metres.
const REPLAY_JITTER_M: f64 = 0.001;

/// A carton on the bench: what a try needs.
pub(super) struct Bench<'a> {
    pub(super) catalogue: &'a Catalogue,
    pub(super) method: &'a Method,
    pub(super) grid: &'a Grid,
    pub(super) simulated: &'a Simulated,
    /// Threads that share the simulated tries of a step.
    pub(super) threads: usize,
}

/// What a try came to.
pub(super) struct Tried {
    pub(super) episode: Episode,
    /// The cell in which the plan was done again, or else the one that was packed.
    pub(super) cell: SimulatedPackingCell,
    /// Items that do not lie in the carton as they should; none where it does.
    pub(super) left_out: Vec<Unplaceable>,
    /// Those of them that were tried, by arrival.
    pub(super) failed: Vec<usize>,
}

impl Bench<'_> {
    /// Packs the items in a sequence, and in its place what still fits where `goes_on`; `None`
    /// where it is over before.
    pub(super) fn attempt(
        &self,
        sequence: Sequence,
        goes_on: bool,
        is_over: &dyn Fn() -> bool,
    ) -> Outcome<Option<Tried>> {
        let Sequence { items, buffer } = sequence;
        let mut cell = Watched {
            cell: self.cell(0.0)?,
            is_over,
        };
        let twin = TwinSettings::of(&self.simulated.cell);
        let pool = trial::pool(self.threads).or_run()?;
        let trial = trial::check(self.method.trial, &self.method.loads, twin, pool).or_input()?;
        let proposer = self.method.proposer(self.grid, None)?;
        let mut planner = self.method.build_with(self.grid, proposer, trial)?;
        let how = Play {
            buffer,
            set_aside: if goes_on { items.len() } else { 0 },
            alternatives: ALTERNATIVES.into(),
        };
        let all = items.clone();
        let episode = match play(self.grid, &mut planner, &mut cell, items, how, &mut ()) {
            Err(_) if is_over() => return Ok(None),
            played => played.or_run()?,
        };
        let (left_out, failed) = unplaced(&all, &episode);
        if !left_out.is_empty() {
            return Ok(Some(Tried {
                episode,
                cell: cell.cell,
                left_out,
                failed,
            }));
        }
        let cell = self.replay(&episode.steps)?;
        let left_out = self.faults(&episode.steps, &cell);
        Ok(Some(Tried {
            failed: left_out.iter().map(|item| item.arrival).collect(),
            episode,
            cell,
            left_out,
        }))
    }

    fn cell(&self, jitter_m: f64) -> Outcome<SimulatedPackingCell> {
        let mut physics = self.simulated.cell.clone();
        physics.release.jitter_m = jitter_m;
        self.simulated
            .packing_cell(physics, self.grid, self.catalogue)
    }

    /// Does what was planned in an empty cell, by a robot that is not quite exact.
    fn replay(&self, steps: &[Step]) -> Outcome<SimulatedPackingCell> {
        let mut cell = self.cell(REPLAY_JITTER_M)?;
        for step in steps {
            let resting = &step.choice.resting;
            let placed = cell.place(&step.candidate, resting, &step.evidence);
            placed.map_err(anyhow::Error::from_boxed).or_run()?;
        }
        Ok(cell)
    }

    /// Gives the items that do not lie in the carton as they should, each with what is wrong.
    fn faults(&self, steps: &[Step], cell: &SimulatedPackingCell) -> Vec<Unplaceable> {
        // What still rocks may take a moment longer.
        let mut at_rest = cell.cell().clone();
        at_rest.settle();
        let rim_m = self.grid.container().z_m + RIM_TOLERANCE_M;
        let lies = |number: usize| {
            let mut contents = at_rest.contents().into_iter();
            contents.find(|body| body.id.index() == number)
        };
        let fault = |number: usize| match lies(number) {
            Some(body) if body.inside && top_m(&body) <= rim_m => None,
            Some(body) if body.inside => Some("it sticks out above the rim".to_owned()),
            _ => Some("it fell out".to_owned()),
        };
        let settled = cell.placed().iter().map(Settled::from);
        let of = |(number, (step, settled)): (usize, (&Step, Settled))| {
            let why = fault(number).or_else(|| Some(format!("it {}", settled.unsteadiness()?)));
            why.map(|why| Unplaceable::new(&step.candidate, why))
        };
        steps
            .iter()
            .zip(settled)
            .enumerate()
            .filter_map(of)
            .collect()
    }
}

/// Gives the height of the highest point of a body, in metres.
fn top_m(body: &BodyState) -> f64 {
    let vertices = body.model.mesh.vertices.iter();
    let heights_m = vertices.map(|vertex| (body.container_from_item * vertex).z);
    heights_m.fold(f64::NEG_INFINITY, f64::max)
}

/// Gives the items that an episode did not place, and the arrivals of those that had their turn.
fn unplaced(all: &[Candidate], episode: &Episode) -> (Vec<Unplaceable>, Vec<usize>) {
    let mut reasons: BTreeMap<usize, String> = BTreeMap::new();
    for aside in episode.set_aside.iter().map(Unplaceable::from) {
        reasons.insert(aside.arrival, aside.reason);
    }
    if let Ending::NothingFits(items) = &episode.ending {
        reasons.extend(
            items
                .iter()
                .map(|(held, why)| (held.arrival, why.to_string())),
        );
    }
    let placed: Vec<usize> = episode
        .steps
        .iter()
        .map(|step| step.candidate.arrival)
        .collect();
    let items = all.chunk_by(|a, b| a.arrival == b.arrival);
    let left = items.filter_map(<[Candidate]>::first);
    let left = left.filter(|held| !placed.contains(&held.arrival));
    let left = left.map(|held| {
        let reason = reasons.get(&held.arrival).cloned();
        let unknown = || "no room is left for it".to_owned();
        Unplaceable::new(held, reason.unwrap_or_else(unknown))
    });
    (left.collect(), reasons.into_keys().collect())
}

/// A cell that places nothing more once it is over.
struct Watched<'a> {
    cell: SimulatedPackingCell,
    is_over: &'a dyn Fn() -> bool,
}

impl PackingCell for Watched<'_> {
    fn scan(&mut self) -> Result<Scene, StageError> {
        self.cell.scan()
    }

    fn place(
        &mut self,
        item: &Candidate,
        resting: &RestingPlacement,
        evidence: &Evidence,
    ) -> Result<(), StageError> {
        if (self.is_over)() {
            return Err("a smaller carton does".into());
        }
        self.cell.place(item, resting, evidence)
    }

    fn is_inside(&self, arrival: usize) -> bool {
        self.cell.is_inside(arrival)
    }
}
