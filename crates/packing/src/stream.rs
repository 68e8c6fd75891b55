//! Streams: items that arrive one after another, packed into several open containers. One is closed, and an empty one opened in its
//! place, where nothing in the buffer has a valid placement in any.

use crate::buffer::Buffer;
use crate::candidate::Candidate;
use crate::containers::{Chosen, ContainerChoice, Effort, OpenContainer, OpenContainers};
use crate::episode::{EpisodeError, PackingCell, Step, packed_volume};
use crate::grid::Grid;
use crate::heightmap::Scene;
use crate::metrics::PackedVolume;
use crate::plan::{Planner, StageError, StepInput};

/// Where empty containers come from.
pub trait ContainerSupply {
    /// A container with its cell.
    type Cell: PackingCell;

    /// An empty container, the `number`th from 0, and who plans for it.
    ///
    /// # Errors
    /// What keeps it from coming.
    fn next(&mut self, number: usize) -> Result<(Planner, Self::Cell), StageError>;
}

/// How a stream is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamPlay {
    /// Containers that are open at the same time, at least one.
    pub open: usize,
    /// Items that a step may choose among.
    pub buffer: usize,
    /// Which of the containers an item goes into.
    pub choice: ContainerChoice,
}

/// A container and what was packed into it.
#[derive(Debug)]
pub struct Filled<C> {
    /// Its number, in the order in which they were opened.
    pub number: usize,
    /// Its cell.
    pub cell: C,
    /// What was packed into it, in order; the numbers of the steps are those of the stream.
    pub steps: Vec<Step>,
    /// What it holds now.
    pub scene: Scene,
}

impl<C: PackingCell> Filled<C> {
    /// The volume of the items that are inside it.
    pub fn packed(&self, grid: &Grid) -> PackedVolume {
        packed_volume(grid, &self.steps, |arrival| self.cell.is_inside(arrival))
    }

    /// The volume of the items that were placed in it, in cubic metres.
    fn placed_m3(&self) -> f64 {
        let items = self.steps.iter().map(|step| &step.candidate.item);
        items.map(|item| item.mesh_volume_m3()).sum()
    }

    fn place(&mut self, step: Step) -> Result<(), EpisodeError> {
        let number = step.step;
        let failed = |source| EpisodeError::Cell {
            step: number,
            source,
        };
        let (held, at) = (&step.candidate, &step.choice.resting);
        let placed = self.cell.place(held, at, &step.evidence);
        placed.map_err(failed)?;
        self.steps.push(step);
        self.scene = self.cell.scan().map_err(failed)?;
        Ok(())
    }
}

/// A stream that came to its end.
#[derive(Debug)]
pub struct Stream<C> {
    /// The containers that were closed, in order.
    pub closed: Vec<Filled<C>>,
    /// Those that were open at the end.
    pub open: Vec<Filled<C>>,
    /// Items that have no valid placement even in an empty container.
    pub unplaceable: Vec<Candidate>,
}

/// Packs a stream.
///
/// # Errors
/// [`EpisodeError`] where planning, a cell or the supply failed.
pub fn play_stream<S: ContainerSupply>(
    grid: &Grid,
    supply: &mut S,
    sequence: Vec<Candidate>,
    how: StreamPlay,
) -> Result<Stream<S::Cell>, EpisodeError> {
    let mut buffer = Buffer::new(sequence, how.buffer);
    let mut containers = Containers::new(supply, how)?;
    let mut closed = Vec::new();
    let mut unplaceable = Vec::new();
    for step in 0.. {
        if buffer.candidates().is_empty() {
            break;
        }
        let (chosen, effort) = containers.plan(grid, step, buffer.candidates())?;
        if let Some(chosen) = chosen {
            let taken = buffer.take(chosen.placement.candidate);
            if let Some(candidate) = taken {
                containers.place(done(step, candidate, &chosen, effort), chosen.container)?;
            }
        } else if containers.has_empty() {
            unplaceable.extend(buffer.take(0));
        } else {
            closed.extend(containers.close_fullest());
            containers.open_next(supply, step)?;
        }
    }
    Ok(Stream {
        closed,
        open: containers.filled,
        unplaceable,
    })
}

fn done(step: u64, candidate: Candidate, chosen: &Chosen, effort: Effort) -> Step {
    Step {
        step,
        candidate,
        choice: chosen.placement,
        evidence: chosen.evidence.clone(),
        alternatives: Vec::new(),
        timings: effort.timings,
        degraded: chosen.degraded.clone(),
        refusals: effort.refusals,
    }
}

/// The open containers of a stream, and who plans for them.
struct Containers<C> {
    planners: OpenContainers,
    filled: Vec<Filled<C>>,
    choice: ContainerChoice,
    opened: usize,
}

impl<C: PackingCell> Containers<C> {
    fn new<S: ContainerSupply<Cell = C>>(
        supply: &mut S,
        how: StreamPlay,
    ) -> Result<Self, EpisodeError> {
        let mut containers = Self {
            planners: OpenContainers::default(),
            filled: Vec::new(),
            choice: how.choice,
            opened: 0,
        };
        for _ in 0..how.open.max(1) {
            containers.open_next(supply, 0)?;
        }
        Ok(containers)
    }

    fn open_next<S: ContainerSupply<Cell = C>>(
        &mut self,
        supply: &mut S,
        step: u64,
    ) -> Result<(), EpisodeError> {
        let failed = |source| EpisodeError::Cell { step, source };
        let number = self.opened;
        let (planner, mut cell) = supply.next(number).map_err(failed)?;
        let scene = cell.scan().map_err(failed)?;
        self.planners.open(planner);
        self.filled.push(Filled {
            number,
            cell,
            steps: Vec::new(),
            scene,
        });
        self.opened += 1;
        Ok(())
    }

    fn plan(
        &mut self,
        grid: &Grid,
        step: u64,
        candidates: &[Candidate],
    ) -> Result<(Option<Chosen>, Effort), EpisodeError> {
        let open = self.filled.iter().map(|filled| OpenContainer {
            grid,
            scene: &filled.scene,
            filled_m3: filled.placed_m3(),
        });
        let open: Vec<_> = open.collect();
        let Some(first) = open.first() else {
            return Ok((None, Effort::default()));
        };
        let input = StepInput {
            step,
            ..StepInput::new(grid, first.scene, candidates)
        };
        Ok(self.planners.plan(&open, &input, self.choice)?)
    }

    fn place(&mut self, step: Step, container: usize) -> Result<(), EpisodeError> {
        self.planners.changed(container);
        match self.filled.get_mut(container) {
            Some(filled) => filled.place(step),
            None => Ok(()),
        }
    }

    fn has_empty(&self) -> bool {
        self.filled.iter().any(|filled| filled.steps.is_empty())
    }

    /// Takes the fullest container away; of equal ones that which was opened first.
    fn close_fullest(&mut self) -> Option<Filled<C>> {
        let placed_m3: Vec<f64> = self.filled.iter().map(Filled::placed_m3).collect();
        let filled = placed_m3.iter().enumerate();
        // Of equal ones, `min_by` gives the first.
        let (fullest, _) = filled.min_by(|(_, a), (_, b)| b.total_cmp(a))?;
        self.planners.close(fullest);
        Some(self.filled.remove(fullest))
    }
}
