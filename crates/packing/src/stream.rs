//! Streams: items that arrive one after another, of orders or not, packed into several open
//! containers. One is closed, and an empty one opened in its place, where nothing in the buffer has
//! a valid placement in any, or a rule says so.

use crate::buffer::Buffer;
use crate::candidate::Candidate;
use crate::closing::{self, Closing, ClosingRules, Fill};
use crate::containers::{Found, plan_over};
use crate::episode::{EpisodeError, PackingCell, Step, packed_volume};
use crate::grid::Grid;
use crate::heightmap::Scene;
use crate::leaving::{Leaving, Stop};
use crate::metrics::PackedVolume;
use crate::orders::Orders;
use crate::plan::{Plan, PlanError, Planner, StageError};
use crate::refusal::Refusals;
use crate::step::{Evaluated, StepInput};

/// Source of empty containers.
pub trait ContainerSupply {
    /// A container with its cell.
    type Cell: PackingCell;

    /// An empty container, the `number`th from 0, and who plans for it; its grid is that of the
    /// stream.
    ///
    /// # Errors
    /// What keeps it from coming.
    fn next(&mut self, number: usize, grid: &Grid) -> Result<(Planner, Self::Cell), StageError>;
}

/// Settings of a stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StreamPlay {
    /// Containers that are open at the same time, at least one.
    pub open: usize,
    /// Items that a step may choose among.
    pub buffer: usize,
    /// When one is closed though items fit into others.
    pub closing: ClosingRules,
}

/// A container and what was packed into it.
#[derive(Debug)]
pub struct Filled<C> {
    /// Its number, in the order in which they were opened.
    pub number: usize,
    /// Its grid.
    pub grid: Grid,
    /// Its cell.
    pub cell: C,
    /// Steps that packed it, in order; their numbers are those of the stream.
    pub steps: Vec<Step>,
    /// Content now.
    pub scene: Scene,
    /// Why it was closed; `None` as long as it is open.
    pub closing: Option<Closing>,
}

impl<C: PackingCell> Filled<C> {
    /// The volume of the items that are inside it.
    pub fn packed(&self) -> PackedVolume {
        packed_volume(&self.grid, &self.steps, |arrival| {
            self.cell.is_inside(arrival)
        })
    }

    /// The volume of the items that were placed in it, in cubic metres.
    fn placed_m3(&self) -> f64 {
        let items = self.steps.iter().map(|step| &step.candidate.item);
        items.map(|item| item.mesh_volume_m3()).sum()
    }

    /// Gives its filled volume.
    fn fill(&self) -> Fill {
        Fill::of(self.placed_m3(), self.grid.container())
    }

    /// At which stops its items leave, as they were placed; `None` where none is said to leave at
    /// one.
    fn leaving(&self) -> Option<Leaving> {
        let mut stops = self.steps.iter().map(|step| step.candidate.stop);
        if stops.all(|stop| stop == Stop::LAST) {
            return None;
        }
        let mut leaving = Leaving::empty(&self.grid);
        for Step {
            candidate, choice, ..
        } in &self.steps
        {
            let view = candidate.item.views().get(choice.resting.placement.yaw);
            if let Some(view) = view {
                leaving.place(view, &choice.resting, candidate.stop);
            }
        }
        Some(leaving)
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
        let scene = self.cell.scan().map_err(failed)?;
        self.scene = match self.leaving() {
            Some(leaving) => scene.with_leaving(leaving),
            None => scene,
        };
        Ok(())
    }
}

/// A stream that came to its end.
#[derive(Debug)]
pub struct Stream<C> {
    /// The containers that were closed, in order.
    pub closed: Vec<Filled<C>>,
    /// Containers that were open at the end.
    pub open: Vec<Filled<C>>,
    /// Items that have no valid placement even in an empty container.
    pub unplaceable: Vec<Candidate>,
}

/// Packs a stream into containers of this grid. Rules of orders that give way are kept as long as
/// something can be packed so.
///
/// # Errors
/// [`EpisodeError`] where planning, a cell or the supply failed.
pub fn play_stream<S: ContainerSupply>(
    grid: &Grid,
    supply: &mut S,
    sequence: Vec<Candidate>,
    orders: Orders,
    how: StreamPlay,
) -> Result<Stream<S::Cell>, EpisodeError> {
    let mut buffer = Buffer::new(sequence, how.buffer);
    let mut containers = Containers::new(grid, supply, orders, how)?;
    let mut closed = Vec::new();
    let mut unplaceable = Vec::new();
    for step in 0.. {
        if buffer.candidates().is_empty() {
            break;
        }
        containers.orders.begin(buffer.candidates());
        if let Some((container, done)) = containers.plan(step, buffer.candidates())? {
            buffer.take(done.choice.candidate);
            containers.place(done, container)?;
        } else if let Some(candidate) = containers.fits_nowhere(buffer.candidates()) {
            if let Some(dropped) = buffer.take(candidate) {
                containers.orders.dropped(dropped.arrival);
                unplaceable.push(dropped);
            }
        } else if let Some(fullest) = containers.fullest() {
            closed.push(containers.close(fullest, Closing::NothingFits));
            containers.open_next(supply, step)?;
        }
        while let Some((container, why)) = containers.due_closing() {
            closed.push(containers.close(container, why));
            containers.open_next(supply, step)?;
        }
    }
    Ok(Stream {
        closed,
        open: containers.filled,
        unplaceable,
    })
}

/// The open containers of a stream, and who plans for them.
struct Containers<'a, C> {
    grid: &'a Grid,
    planners: Vec<Planner>,
    filled: Vec<Filled<C>>,
    orders: Orders,
    closing: ClosingRules,
    opened: usize,
}

impl<'a, C: PackingCell> Containers<'a, C> {
    fn new<S: ContainerSupply<Cell = C>>(
        grid: &'a Grid,
        supply: &mut S,
        orders: Orders,
        how: StreamPlay,
    ) -> Result<Self, EpisodeError> {
        let mut containers = Self {
            grid,
            planners: Vec::new(),
            filled: Vec::new(),
            orders,
            closing: how.closing,
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
        let (planner, mut cell) = supply.next(number, self.grid).map_err(failed)?;
        let scene = cell.scan().map_err(failed)?;
        self.planners.push(planner);
        self.orders.opened();
        self.filled.push(Filled {
            number,
            grid: self.grid.clone(),
            cell,
            steps: Vec::new(),
            scene,
            closing: None,
        });
        self.opened += 1;
        Ok(())
    }

    /// Plans a step: the container, by its index, and what is packed into it; `None` where no
    /// candidate has a valid placement in any that may take it.
    fn plan(
        &mut self,
        number: u64,
        candidates: &[Candidate],
    ) -> Result<Option<(usize, Step)>, EpisodeError> {
        let percent = |filled: &Filled<C>| filled.fill().percent();
        let open = self.filled.iter().zip(&mut self.planners).enumerate();
        let mut open: Vec<_> = open.collect();
        // A stable sort: of equally full ones that which was opened first.
        open.sort_by(|(_, (a, _)), (_, (b, _))| percent(b).total_cmp(&percent(a)));
        let places: Vec<usize> = open.iter().map(|(place, _)| *place).collect();
        let attempts = self.orders.attempts(&places, candidates);
        let mut refusals = Refusals::default();
        let found = plan_over(&attempts, candidates, |at, admitted| {
            let Some((_, (filled, planner))) = open.get_mut(at) else {
                return Ok(Plan::default());
            };
            let plan = planner.plan(&StepInput {
                step: number,
                ..StepInput::new(&filled.grid, &filled.scene, admitted)
            })?;
            refusals.add(plan.refusals());
            Ok::<_, PlanError>(plan.clone())
        })?;
        let step = |found: Found| {
            let choice = found.plan.choice()?;
            let held = found.candidates.get(choice.candidate)?;
            let is_it =
                |other: &Candidate| (other.arrival, other.pose) == (held.arrival, held.pose);
            let candidate = candidates.iter().position(is_it)?;
            let choice = Evaluated {
                candidate,
                ..choice
            };
            let step = Step {
                timings: found.timings,
                refusals,
                ..Step::new(number, held.clone(), choice, &found.plan)
            };
            Some((*places.get(found.container)?, step))
        };
        Ok(found.and_then(step))
    }

    /// A container that a rule closes, and why.
    fn due_closing(&self) -> Option<(usize, Closing)> {
        let each = self.filled.iter().enumerate();
        let mut by_fill = each.filter_map(|(container, filled)| {
            let closing = self.closing.closing(&filled.fill())?;
            Some((container, closing))
        });
        by_fill.next().or_else(|| {
            let complete = self.orders.complete();
            let complete = complete.filter(|_| self.closing.order_complete)?;
            Some((complete, Closing::OrderComplete))
        })
    }

    fn place(&mut self, step: Step, container: usize) -> Result<(), EpisodeError> {
        self.orders.packed(container, step.candidate.arrival);
        match self.filled.get_mut(container) {
            Some(filled) => filled.place(step),
            None => Ok(()),
        }
    }

    /// The first of these candidates that an empty container may take, which has no valid placement
    /// there: nothing has. Where no container may take any, one that waits in vain.
    fn fits_nowhere(&self, candidates: &[Candidate]) -> Option<usize> {
        let mut empty = self.filled.iter().enumerate();
        let (empty, _) = empty.find(|(_, filled)| filled.steps.is_empty())?;
        let may_take = |held: &Candidate| self.orders.admits(true, empty, held.arrival);
        Some(candidates.iter().position(may_take).unwrap_or(0))
    }

    /// The fullest container; of equal ones that which was opened first.
    fn fullest(&self) -> Option<usize> {
        let fills: Vec<Fill> = self.filled.iter().map(Filled::fill).collect();
        closing::fullest(&fills)
    }

    fn close(&mut self, container: usize, why: Closing) -> Filled<C> {
        self.planners.remove(container);
        self.orders.closed(container);
        let mut filled = self.filled.remove(container);
        filled.closing = Some(why);
        filled
    }
}
