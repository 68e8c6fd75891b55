//! A step over several containers that are open at the same time.
//!
//! Each has a planner of its own, and all plan for the same buffer. The fullest in which an item of the buffer has a valid
//! placement takes one: gaps are filled before room is begun.

use crate::candidate::Candidate;
use crate::episode::Step;
use crate::grid::Grid;
use crate::heightmap::Scene;
use crate::plan::{Plan, PlanError, Planner, Timings};
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
#[derive(Clone, Copy)]
pub struct ContainersStep<'a> {
    /// The open containers, in the order in which they were opened.
    pub containers: &'a [OpenContainer<'a>],
    /// The buffer.
    pub candidates: &'a [Candidate],
    /// Whether a container may take an item at all, wherever it would lie there.
    pub admits: &'a dyn Fn(usize, &Candidate) -> bool,
    /// Number of the step, which stochastic parts mix into their seed.
    pub step: u64,
}

/// What planning a step took, over all containers.
#[derive(Debug, Clone, Default)]
pub struct Effort {
    /// Time per stage.
    pub timings: Timings,
    /// Placements that were refused before the step was decided.
    pub refusals: Refusals,
}

impl Effort {
    fn add(&mut self, plan: &Plan) {
        self.timings += plan.timings();
        self.refusals.add(plan.refusals());
    }
}

impl ContainersStep<'_> {
    /// Plans the step with a planner for each container: the container, by its index, and what is packed into it; `None` where no
    /// candidate has a valid placement in any that may take it. The choice's candidate is an index into those of the step.
    ///
    /// # Errors
    /// [`PlanError`] where a container does not match its grid or a stage failed.
    pub fn plan(
        &self,
        planners: &mut [Planner],
        effort: &mut Effort,
    ) -> Result<Option<(usize, Step)>, PlanError> {
        let mut open: Vec<_> = self.containers.iter().zip(planners).enumerate().collect();
        // A stable sort: of equally full ones that which was opened first.
        open.sort_by(|(_, (a, _)), (_, (b, _))| b.filled_percent.total_cmp(&a.filled_percent));
        for (container, (at, planner)) in open {
            let candidates = self.candidates.iter().enumerate();
            let admitted = candidates.filter(|(_, held)| (self.admits)(container, held));
            let (indices, admitted): (Vec<usize>, Vec<Candidate>) =
                admitted.map(|(index, held)| (index, held.clone())).unzip();
            let plan = planner.plan(&StepInput {
                step: self.step,
                ..StepInput::new(at.grid, at.scene, &admitted)
            })?;
            effort.add(plan);
            let Some(choice) = plan.choice() else {
                continue;
            };
            let taken = indices.get(choice.candidate);
            if let Some((index, held)) = taken.zip(admitted.get(choice.candidate)) {
                let choice = Evaluated {
                    candidate: *index,
                    ..choice
                };
                let step = Step {
                    timings: effort.timings,
                    refusals: effort.refusals.clone(),
                    ..Step::new(self.step, held.clone(), choice, plan)
                };
                return Ok(Some((container, step)));
            }
        }
        Ok(None)
    }
}
