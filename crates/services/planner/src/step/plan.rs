//! A step over the open containers of a cell, and what is found: the same when it is planned and
//! when it is planned again.

use std::time::Instant;

use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::planning::containers::plan_over;
pub(crate) use ppnpack_packing::planning::containers::{Attempt as AttemptPlan, Found};
use ppnpack_packing::planning::plan::Plan;
use ppnpack_packing::ranking::step::{Candidate, Evaluated, StepInput};
use ppnpack_packing::scene::Scene;
use ppnpack_wire::{convert, v1};

/// The input of a step over the open containers.
pub(crate) struct StepPlan {
    /// The items of the buffer, as decisions name them.
    pub(crate) items: Vec<v1::RecordedItem>,
    /// The items in their order, each in all the poses in which it may be packed.
    pub(crate) candidates: Vec<Candidate>,
    /// The open containers, the fullest first.
    pub(crate) containers: Vec<ContainerStep>,
    /// The attempts to pack something: they are made until one finds anything.
    pub(crate) attempts: Vec<AttemptPlan>,
    pub(crate) number: u64,
    pub(crate) alternatives: usize,
    pub(crate) deadline: Option<Instant>,
    pub(crate) takes_untried: bool,
}

/// A container as a step is planned on it.
#[derive(Clone)]
pub(crate) struct ContainerStep {
    pub(crate) name: String,
    pub(crate) grid: Grid,
    pub(crate) scene: Scene,
}

/// A planner in each container.
pub(crate) trait PlansContainers {
    type Error;

    fn plan_in(&mut self, container: &str, input: &StepInput<'_>) -> Result<Plan, Self::Error>;
}

impl StepPlan {
    /// Plans the step: gives what the first attempt finds that has a placement, else the last one.
    /// `None` where there is no container.
    pub(crate) fn plan<P: PlansContainers>(
        &self,
        planner: &mut P,
    ) -> Result<Option<Found>, P::Error> {
        plan_over(
            &self.attempts,
            &self.candidates,
            |container, admitted| match self.containers.get(container) {
                Some(at) => planner.plan_in(&at.name, &self.input(at, &at.scene, admitted)),
                None => Ok(Plan::default()),
            },
        )
    }

    /// Gives the step in a container, on a scene of it and with some of the candidates.
    pub(crate) fn input<'a>(
        &self,
        container: &'a ContainerStep,
        scene: &'a Scene,
        candidates: &'a [Candidate],
    ) -> StepInput<'a> {
        StepInput {
            step: self.number,
            alternatives: self.alternatives,
            deadline: self.deadline,
            takes_untried: self.takes_untried,
            ..StepInput::new(&container.grid, scene, candidates)
        }
    }

    /// Gives the choice of the step as a decision with all that follows from the input; without
    /// names, times and states. `None` where nothing was chosen.
    pub(crate) fn decision(&self, found: &Found) -> Option<v1::Decision> {
        let (
            items,
            Found {
                plan, candidates, ..
            },
        ) = (&self.items, found);
        let container = self.containers.get(found.container)?;
        let choice = plan.choice()?;
        let held = candidates.get(choice.candidate)?;
        let item = items.iter().find(|item| is_of(item, held))?;
        let frame = held
            .item
            .container_from_item(&container.grid, &choice.resting)?;
        let evidence = plan.evidence();
        let frame = evidence.map_or(frame, |evidence| evidence.lower(frame));
        let container_from_item = held.lying.own_frame(&frame);
        let cycle = evidence.and_then(|evidence| evidence.cycle.as_ref());
        let settling = evidence.and_then(|evidence| evidence.settling.as_ref());
        let load = evidence.and_then(|evidence| evidence.load.as_ref());
        let alternatives = plan.alternatives();
        Some(v1::Decision {
            item_id: item.item_id.clone(),
            object: item.object.clone(),
            placement: Some(convert::placement::write_resting(&choice.resting)),
            container_from_item: Some(convert::pose::write(&container_from_item)),
            value: choice.value,
            alternatives: alternatives
                .map(|other| write_ranked(items, candidates, other))
                .collect(),
            buffer: items.iter().map(|item| item.item_id.clone()).collect(),
            is_widened: plan.is_widened(),
            cycle: cycle.map(|cycle| Box::new(convert::cycle::write(cycle))),
            settling: settling.map(convert::settling::write),
            load: load.map(|load| Box::new(convert::load::write(load))),
            pose: u32::try_from(held.pose).unwrap_or(u32::MAX),
            container: container.name.clone(),
            ..v1::Decision::default()
        })
    }
}

fn is_of(item: &v1::RecordedItem, held: &Candidate) -> bool {
    usize::try_from(item.arrival) == Ok(held.arrival)
}

/// Writes a placement of one of these candidates as one of its item.
pub(crate) fn write_ranked(
    items: &[v1::RecordedItem],
    candidates: &[Candidate],
    ranked: &Evaluated,
) -> v1::RankedPlacement {
    let held = candidates.get(ranked.candidate);
    let position = |held: &Candidate| items.iter().position(|item| is_of(item, held));
    let item = held.and_then(position).unwrap_or_default();
    convert::placement::write_ranked_item(ranked, item, held.map_or(0, |held| held.pose))
}
