//! Streams: items that arrive one by one, packed into several open containers. One is closed, and
//! an empty one opened, where nothing in the buffer fits into any, or by a rule.

use crate::kernel::grid::Grid;
use crate::planning::containers::{Found, plan_over};
use crate::planning::plan::{Plan, PlanError, Planner};
use crate::ranking::refusal::Refusals;
use crate::ranking::step::{Candidate, Evaluated, StageError, StepInput};
use crate::scene::Scene;
use crate::scene::leaving::{Leaving, Stop};
use crate::streams::buffer::Buffer;
use crate::streams::closing::{self, Closing, ClosingRules, Fill};
use crate::streams::episode::{EpisodeError, PackingCell, Step, packed_volume};
use crate::streams::metrics::PackedVolume;
use crate::streams::orders::Orders;

/// Error of a plan for a container that is not there.
const NOT_OPEN: &str = "broken invariant \"what is planned for is open\"";

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

    fn placed_m3(&self) -> f64 {
        let items = self.steps.iter().map(|step| &step.candidate.item);
        items.map(|item| item.mesh_volume_m3()).sum()
    }

    fn fill(&self) -> Fill {
        Fill::of(self.placed_m3(), self.grid.container())
    }

    /// At which stops its items leave, as placed; `None` where none leaves at one.
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

/// Packs a stream into containers of this grid. Rules of orders that give way are kept while
/// something can be packed. `supply` brings the empty container of a number, and its planner.
///
/// # Errors
/// [`EpisodeError`] where planning, a cell or the supply failed.
pub fn play_stream<C: PackingCell>(
    grid: &Grid,
    supply: impl FnMut(usize) -> Result<(Planner, C), StageError>,
    sequence: Vec<Candidate>,
    orders: Orders,
    how: StreamPlay,
) -> Result<Stream<C>, EpisodeError> {
    let mut buffer = Buffer::new(sequence, how.buffer);
    let mut containers = Containers {
        grid,
        supply,
        open: Vec::new(),
        orders,
        closing: how.closing,
        opened: 0,
    };
    for _ in 0..how.open.max(1) {
        containers.open_next(0)?;
    }
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
            containers.open_next(step)?;
        }
        while let Some((container, why)) = containers.due_closing() {
            closed.push(containers.close(container, why));
            containers.open_next(step)?;
        }
    }
    let open = containers.open.into_iter();
    Ok(Stream {
        closed,
        open: open.map(|(_, filled)| filled).collect(),
        unplaceable,
    })
}

/// The open containers of a stream, with who plans for each.
struct Containers<'a, S, C> {
    grid: &'a Grid,
    supply: S,
    open: Vec<(Planner, Filled<C>)>,
    orders: Orders,
    closing: ClosingRules,
    opened: usize,
}

impl<S, C: PackingCell> Containers<'_, S, C>
where
    S: FnMut(usize) -> Result<(Planner, C), StageError>,
{
    fn open_next(&mut self, step: u64) -> Result<(), EpisodeError> {
        let failed = |source| EpisodeError::Cell { step, source };
        let (planner, mut cell) = (self.supply)(self.opened).map_err(failed)?;
        let filled = Filled {
            number: self.opened,
            grid: self.grid.clone(),
            scene: cell.scan().map_err(failed)?,
            cell,
            steps: Vec::new(),
            closing: None,
        };
        self.open.push((planner, filled));
        self.orders.opened();
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
        let percents: Vec<f64> = self.fills().map(|fill| fill.percent()).collect();
        let mut open: Vec<_> = self.open.iter_mut().zip(percents).enumerate().collect();
        // A stable sort: of equally full ones that which was opened first.
        open.sort_by(|(_, (_, a)), (_, (_, b))| b.total_cmp(a));
        let places: Vec<usize> = open.iter().map(|(place, _)| *place).collect();
        let attempts = self.orders.attempts(&places, candidates);
        let mut refusals = Refusals::default();
        let found = plan_over(&attempts, candidates, |at, admitted| {
            let Some((_, ((planner, filled), _))) = open.get_mut(at) else {
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

    fn fills(&self) -> impl Iterator<Item = Fill> {
        self.open.iter().map(|(_, filled)| filled.fill())
    }

    /// Finds a container that a rule closes, and why.
    fn due_closing(&self) -> Option<(usize, Closing)> {
        let by_fill = self.fills().map(|fill| self.closing.closing(&fill));
        let by_fill = by_fill.enumerate();
        let due = by_fill.filter_map(|(container, closing)| Some((container, closing?)));
        let complete = || {
            self.orders
                .complete()
                .filter(|_| self.closing.order_complete)
        };
        due.chain(complete().map(|container| (container, Closing::OrderComplete)))
            .next()
    }

    fn place(&mut self, step: Step, container: usize) -> Result<(), EpisodeError> {
        self.orders.packed(container, step.candidate.arrival);
        match self.open.get_mut(container) {
            Some((_, filled)) => filled.place(step),
            None => Err(EpisodeError::Cell {
                step: step.step,
                source: NOT_OPEN.into(),
            }),
        }
    }

    /// Finds the first of these candidates that an empty container may take, which has no valid
    /// placement there: nothing has. Where no container may take any, one that waits in vain.
    fn fits_nowhere(&self, candidates: &[Candidate]) -> Option<usize> {
        let mut open = self.open.iter();
        let empty = open.position(|(_, filled)| filled.steps.is_empty())?;
        let may_take = |held: &Candidate| self.orders.admits(true, empty, held.arrival);
        Some(candidates.iter().position(may_take).unwrap_or(0))
    }

    fn fullest(&self) -> Option<usize> {
        closing::fullest(&self.fills().collect::<Vec<_>>())
    }

    fn close(&mut self, container: usize, why: Closing) -> Filled<C> {
        self.orders.closed(container);
        let (_, mut filled) = self.open.remove(container);
        filled.closing = Some(why);
        filled
    }
}
