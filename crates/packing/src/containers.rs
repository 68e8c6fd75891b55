//! A step over several containers that are open at the same time.
//!
//! Each has a planner of its own, and all plan for the same buffer. The fullest in which an item of the buffer has a valid
//! placement takes one: gaps are filled before room is begun.

use crate::candidate::Candidate;
use crate::episode::Step;
use crate::grid::Grid;
use crate::heightmap::Scene;
use crate::orders::Orders;
use crate::plan::{PlanError, Planner, Timings};
use crate::refusal::Refusals;
use crate::step::{Evaluated, StepInput};

/// An open container, as a step finds it.
#[derive(Debug, Clone, Copy)]
pub struct OpenContainer<'a> {
    /// Its grid.
    pub grid: &'a Grid,
    /// Its content.
    pub scene: &'a Scene,
    /// How much of it is filled, in percent of its volume.
    pub filled_percent: f64,
}

/// What a step over open containers is planned on, and what is asked of it.
#[derive(Debug, Clone, Copy)]
pub struct ContainersStep<'a> {
    /// The open containers, in the order in which they were opened.
    pub containers: &'a [OpenContainer<'a>],
    /// The buffer.
    pub candidates: &'a [Candidate],
    /// Which container may take an item at all, wherever it would lie there; the step of these orders began.
    pub orders: &'a Orders,
    /// Number of the step, which stochastic parts mix into their seed.
    pub step: u64,
}

impl ContainersStep<'_> {
    /// Plans the step with a planner for each container: the container, by its index, and what is packed into it; `None` where no
    /// candidate has a valid placement in any that may take it. Rules of orders that give way are kept as long as something can be
    /// packed so. The choice's candidate is an index into those of the step, whose times and refusals are those of all containers.
    ///
    /// # Errors
    /// [`PlanError`] where a container does not match its grid or a stage failed.
    pub fn plan(&self, planners: &mut [Planner]) -> Result<Option<(usize, Step)>, PlanError> {
        let containers: Vec<usize> = (0..self.containers.len()).collect();
        let mut open: Vec<_> = self.containers.iter().zip(planners).enumerate().collect();
        // A stable sort: of equally full ones that which was opened first.
        open.sort_by(|(_, (a, _)), (_, (b, _))| b.filled_percent.total_cmp(&a.filled_percent));
        let (mut timings, mut refusals) = (Timings::default(), Refusals::default());
        for gives_way in self.orders.attempts(&containers, self.candidates) {
            for (container, (at, planner)) in &mut open {
                let candidates = self.candidates.iter().enumerate();
                let admitted = candidates
                    .filter(|(_, held)| self.orders.admits(*gives_way, *container, held.arrival));
                let (indices, admitted): (Vec<usize>, Vec<Candidate>) =
                    admitted.map(|(index, held)| (index, held.clone())).unzip();
                let plan = planner.plan(&StepInput {
                    step: self.step,
                    ..StepInput::new(at.grid, at.scene, &admitted)
                })?;
                timings += plan.timings();
                refusals.add(plan.refusals());
                let chosen = plan.choice().and_then(|choice| {
                    let candidate = *indices.get(choice.candidate)?;
                    let held = admitted.get(choice.candidate)?;
                    Some((
                        held,
                        Evaluated {
                            candidate,
                            ..choice
                        },
                    ))
                });
                if let Some((held, choice)) = chosen {
                    let step = Step {
                        timings,
                        refusals,
                        ..Step::new(self.step, held.clone(), choice, plan)
                    };
                    return Ok(Some((*container, step)));
                }
            }
        }
        Ok(None)
    }
}
