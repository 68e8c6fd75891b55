//! Episodes: a sequence is packed until it ends or nothing in the buffer has a valid placement.

use crate::checks::check::Evidence;
use crate::kernel::grid::Grid;
use crate::kernel::heightmap::Heightmap;
use crate::kernel::placement::RestingPlacement;
use crate::planning::plan::{Plan, PlanError, Planner, Reason};
use crate::ranking::refusal::Refusals;
use crate::ranking::step::{Candidate, Evaluated, StageError, StepInput, Timings};
use crate::scene::Scene;
use crate::streams::buffer::Buffer;
use crate::streams::metrics::{Metrics, PackedVolume};

/// The cell that an episode is played in: simulated, real, or only imagined. Errors are what kept
/// it from doing what it was asked for.
pub trait PackingCell {
    /// Gives what the container holds now.
    fn scan(&mut self) -> Result<Scene, StageError>;

    /// Places an item and waits until that is done; the choice's evidence says how, where known.
    fn place(
        &mut self,
        item: &Candidate,
        resting: &RestingPlacement,
        evidence: &Evidence,
    ) -> Result<(), StageError>;

    /// Whether an item that was placed, by its arrival, is inside the container now.
    fn is_inside(&self, arrival: usize) -> bool;
}

/// Why an episode could not go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EpisodeError {
    /// Planning failed.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The cell failed.
    #[error("the cell failed at step {step}: {source}")]
    Cell {
        /// Number of the step, from 0.
        step: u64,
        /// Error of the cell.
        source: StageError,
    },
}

/// One packed item.
#[derive(Debug, Clone)]
pub struct Step {
    /// Number of the step, from 0.
    pub step: u64,
    /// The item.
    pub candidate: Candidate,
    /// Placement, with the value of the objective.
    pub choice: Evaluated,
    /// Findings of the checks about the choice.
    pub evidence: Evidence,
    /// The next best valid placements.
    pub alternatives: Vec<Evaluated>,
    /// Time from the heightmap to the choice.
    pub timings: Timings,
    /// Why it was not planned as was asked for, where it was not.
    pub degraded: Vec<String>,
    /// Whether none of the proposals was valid, so that all placements were searched.
    pub is_widened: bool,
    /// Placements that were refused before the step was decided.
    pub refusals: Refusals,
}

impl Step {
    pub(crate) fn new(step: u64, candidate: Candidate, choice: Evaluated, plan: &Plan) -> Self {
        Self {
            step,
            candidate,
            choice,
            evidence: plan.evidence().cloned().unwrap_or_default(),
            alternatives: plan.alternatives().copied().collect(),
            timings: plan.timings(),
            degraded: plan.degraded().to_vec(),
            is_widened: plan.is_widened(),
            refusals: plan.refusals().clone(),
        }
    }

    /// The planned time of the arm's cycle, in seconds, where there is an arm.
    pub fn cycle_s(&self) -> Option<f64> {
        self.evidence.cycle.as_ref().map(|cycle| cycle.cycle_s)
    }
}

/// An item set aside for the next container, as nothing in the buffer had a valid placement.
#[derive(Debug, Clone)]
pub struct SetAside {
    /// The item, in the pose in which it was offered.
    pub candidate: Candidate,
    /// Why it had no valid placement in that pose, where that is known.
    pub reason: Option<Reason>,
    /// Before which step it was set aside.
    pub step: u64,
}

/// Why an episode ended.
#[derive(Debug, Clone)]
pub enum Ending {
    /// The whole sequence is packed.
    AllPacked,
    /// All that was not set aside is packed.
    OthersSetAside,
    /// Nothing in the buffer has a valid placement; per item the reason, in the offered pose.
    NothingFits(Vec<(Candidate, Reason)>),
}

/// A finished episode.
#[derive(Debug, Clone)]
pub struct Episode {
    /// The steps in order.
    pub steps: Vec<Step>,
    /// Items that were set aside for the next container, in this order.
    pub set_aside: Vec<SetAside>,
    /// Why it ended.
    pub ending: Ending,
    /// The scene at the end.
    pub scene: Scene,
    /// Figures of the result.
    pub metrics: Metrics,
    /// Placements that were refused before the steps were decided, over all steps.
    pub refusals: Refusals,
}

impl Episode {
    /// How many steps were searched exhaustively as none of their proposals was valid.
    pub fn steps_widened(&self) -> usize {
        steps_widened(&self.steps)
    }
}

/// How many of these steps were searched exhaustively as none of their proposals was valid.
pub fn steps_widened(steps: &[Step]) -> usize {
    steps.iter().filter(|step| step.is_widened).count()
}

/// Watches an episode as it goes.
pub trait Observer {
    /// A step was planned and carried out; `input` is what it was planned on.
    fn on_step(&mut self, step: &Step, input: &StepInput<'_>);
}

impl Observer for () {
    fn on_step(&mut self, _step: &Step, _input: &StepInput<'_>) {}
}

/// Settings of an episode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Play {
    /// Items that a step may choose among.
    pub buffer: usize,
    /// Items that may be set aside where nothing in the buffer has a valid placement.
    pub set_aside: usize,
    /// Valid placements that are wanted beside each choice.
    pub alternatives: usize,
}

impl Play {
    /// Choosing among so many items; none may be set aside, and only the best placement is wanted.
    pub fn with_buffer(buffer: usize) -> Self {
        Self {
            buffer,
            set_aside: 0,
            alternatives: 0,
        }
    }
}

/// Plays an episode.
///
/// Neighbours of one arrival are the poses of one item ([`Candidate`]). Where nothing in the buffer
/// fits, its largest item is set aside, as often as may be, and the next one arrives.
///
/// # Errors
/// [`EpisodeError`] where planning or the cell failed; what was packed until then is lost to the caller, but not to
/// the observer.
pub fn play(
    grid: &Grid,
    planner: &mut Planner,
    cell: &mut dyn PackingCell,
    sequence: Vec<Candidate>,
    how: Play,
    observer: &mut dyn Observer,
) -> Result<Episode, EpisodeError> {
    let mut buffer = Buffer::new(sequence, how.buffer);
    let mut steps: Vec<Step> = Vec::new();
    let mut set_aside: Vec<SetAside> = Vec::new();
    let mut refusals = Refusals::default();
    let mut scene = scan(cell, 0)?;
    let ending = loop {
        let step = steps.len() as u64;
        if buffer.candidates().is_empty() {
            break match set_aside.is_empty() {
                true => Ending::AllPacked,
                false => Ending::OthersSetAside,
            };
        }
        let input = StepInput {
            step,
            alternatives: how.alternatives,
            ..StepInput::new(grid, &scene, buffer.candidates())
        };
        let plan = planner.plan(&input)?;
        refusals.add(plan.refusals());
        let chosen = plan.choice().and_then(|choice| {
            let candidate = input.candidates.get(choice.candidate)?;
            Some((choice, candidate.clone()))
        });
        let Some((choice, candidate)) = chosen else {
            let unplaced = unplaced(&input, plan);
            let may_set_aside = set_aside.len() < how.set_aside;
            let Some((index, item)) = largest(&unplaced).filter(|_| may_set_aside) else {
                let reasons = unplaced.into_iter();
                let reasons = reasons.filter_map(|(_, item)| Some((item.candidate, item.reason?)));
                break Ending::NothingFits(reasons.collect());
            };
            set_aside.push(item.clone());
            buffer.take(*index);
            continue;
        };
        let done = Step::new(step, candidate, choice, plan);
        cell.place(&done.candidate, &choice.resting, &done.evidence)
            .map_err(|source| EpisodeError::Cell { step, source })?;
        observer.on_step(&done, &input);
        steps.push(done);
        buffer.take(choice.candidate);
        scene = scan(cell, step)?;
    };
    let packed = packed_volume(grid, &steps, |arrival| cell.is_inside(arrival));
    let metrics = Metrics::new(grid, scene.heightmap(), packed);
    Ok(Episode {
        steps,
        set_aside,
        ending,
        scene,
        metrics,
        refusals,
    })
}

/// The items of a step without a choice by arrival, as offered, with indices into the candidates.
fn unplaced(input: &StepInput<'_>, plan: &Plan) -> Vec<(usize, SetAside)> {
    let mut last = None;
    let items = input.candidates.iter().enumerate();
    let items = items.filter(|(_, held)| last.replace(held.arrival) != Some(held.arrival));
    let item = |(index, held): (usize, &Candidate)| {
        let report = plan.candidates().get(index);
        let item = SetAside {
            candidate: held.clone(),
            reason: report.and_then(|report| report.reason.clone()),
            step: input.step,
        };
        (index, item)
    };
    items.map(item).collect()
}

/// The item that is least likely to fit later: the largest, of several the earliest.
fn largest(unplaced: &[(usize, SetAside)]) -> Option<&(usize, SetAside)> {
    let volume_m3 = |(_, item): &(usize, SetAside)| item.candidate.item.mesh_volume_m3();
    // Of equal ones, `min_by` gives the first.
    let items = unplaced.iter();
    items.min_by(|one, other| volume_m3(other).total_cmp(&volume_m3(one)))
}

fn scan(cell: &mut dyn PackingCell, step: u64) -> Result<Scene, EpisodeError> {
    cell.scan()
        .map_err(|source| EpisodeError::Cell { step, source })
}

/// The volume of the items that are inside the container, of those that were placed.
pub fn packed_volume(
    grid: &Grid,
    steps: &[Step],
    is_inside: impl Fn(usize) -> bool,
) -> PackedVolume {
    let resolution = grid.resolution();
    let voxel_m3 = resolution.cell_m() * resolution.cell_m() * resolution.height_unit_m();
    let mut packed = PackedVolume::default();
    let inside = steps
        .iter()
        .filter(|step| is_inside(step.candidate.arrival));
    for step in inside {
        let item = &step.candidate.item;
        let view = item.views().get(step.choice.resting.placement.yaw);
        packed.items += 1;
        packed.voxels_m3 += view.map_or(0.0, |view| view.voxel_count() as f64 * voxel_m3);
        packed.meshes_m3 += item.mesh_volume_m3();
    }
    packed
}

/// A cell without physics: an item stays exactly where it was placed.
#[derive(Debug, Clone)]
pub struct IdealCell {
    grid: Grid,
    scene: Scene,
    placed: Vec<usize>,
}

impl IdealCell {
    /// An empty cell.
    pub fn new(grid: &Grid) -> Self {
        Self::holding(grid, Scene::from_heightmap(Heightmap::empty(grid)))
    }

    /// A cell whose container holds something already, of which no item counts as placed.
    pub fn holding(grid: &Grid, scene: Scene) -> Self {
        Self {
            grid: grid.clone(),
            scene,
            placed: Vec::new(),
        }
    }
}

impl PackingCell for IdealCell {
    fn scan(&mut self) -> Result<Scene, StageError> {
        Ok(self.scene.clone())
    }

    fn place(
        &mut self,
        item: &Candidate,
        resting: &RestingPlacement,
        _evidence: &Evidence,
    ) -> Result<(), StageError> {
        let view = item.item.view(resting.placement.yaw)?;
        debug_assert!(view.fits_at(&self.grid, resting.resting_height));
        let mut heightmap = self.scene.heightmap().clone();
        heightmap.place(view, resting);
        self.scene = Scene::from_heightmap(heightmap);
        self.placed.push(item.arrival);
        Ok(())
    }

    fn is_inside(&self, arrival: usize) -> bool {
        self.placed.contains(&arrival)
    }
}
