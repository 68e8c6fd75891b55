//! What a step is planned on: the buffer, and what the open containers look like.

use std::ops::Range;
use std::time::{Duration, Instant};

use ppnpack_packing::blocked::block;
use ppnpack_packing::heightmap::{Scene, Surface};
use ppnpack_packing::orders::{Attempt, Orders};
use ppnpack_packing::step::Candidate;
use ppnpack_wire::v1::Status;

use super::CellPlanner;
use super::counts;
use super::footprint::footprint;
use super::refusal::Refusal;
use crate::planning::Step;
use crate::scenes::Seen;
use crate::step_plan::{BufferItem, ContainerStep, StepPlan};
use ppnpack_protocol::session::{ItemState, SessionError, SessionItem};

/// How long a step waits for the heightmaps of all open containers. Then it goes on with those that there are.
const ALL_PATIENCE: Duration = Duration::from_secs(1);

/// How long one of several is waited for before the others are looked at.
const SLICE: Duration = Duration::from_millis(100);

/// What a step is planned on.
pub(super) struct Prepared {
    pub(super) items: Vec<SessionItem>,
    /// The items in their order, each in all the poses in which it may be packed.
    pub(super) candidates: Vec<Candidate>,
    /// The open containers that can be planned on; at least one.
    pub(super) containers: Vec<PreparedContainer>,
    /// Which open containers cannot be planned on, and why.
    pub(super) left_out: Vec<String>,
    /// What the open containers may take; `None` where each may take all.
    pub(super) orders: Option<Orders>,
    /// Of the step.
    pub(super) number: u64,
    pub(super) deadline: Instant,
}

/// An open container, as a step finds it.
pub(super) struct PreparedContainer {
    /// Its place among all that are open, by which orders know it.
    at: usize,
    pub(super) name: String,
    pub(super) seen: Seen,
    /// What was seen, with everything blocked that must stay free.
    pub(super) scene: Scene,
}

/// A container by its name, and what it looks like, or why that is not known.
type Sight = (String, Result<Seen, Refusal>);

impl Prepared {
    pub(super) fn step<'a>(
        &self,
        scene: &'a Scene,
        candidates: &'a [Candidate],
        alternatives: usize,
    ) -> Step<'a> {
        Step {
            scene,
            candidates,
            number: self.number,
            alternatives,
            deadline: Some(self.deadline),
        }
    }

    /// The step over all containers.
    pub(super) fn step_plan(&self, alternatives: usize, may_give_way: bool) -> StepPlan<'_> {
        let containers = self.containers.iter().map(|container| ContainerStep {
            name: &container.name,
            scene: &container.scene,
        });
        let attempts = self.attempts(may_give_way).into_iter().map(|attempt| {
            let containers = self.containers.iter();
            let admitted = containers.map(|container| self.admitted(container, attempt));
            admitted.collect()
        });
        StepPlan {
            containers: containers.collect(),
            candidates: &self.candidates,
            attempts: attempts.collect(),
            number: self.number,
            alternatives,
            deadline: Some(self.deadline),
        }
    }

    /// The items, as decisions name them.
    pub(super) fn buffer_items(&self) -> Vec<BufferItem<'_>> {
        let items = self.items.iter().map(|item| BufferItem {
            item_id: &item.item_id,
            object: &item.object,
            arrival: item.arrival,
        });
        items.collect()
    }

    /// The tries to pack something, until one finds anything. The last of them is of all items.
    fn attempts(&self, may_give_way: bool) -> Vec<Attempt> {
        let Some(orders) = &self.orders else {
            return vec![Attempt::STRICT];
        };
        let containers = self.containers.iter().map(|container| container.at);
        let containers: Vec<usize> = containers.collect();
        let mut attempts = orders.attempts(&containers, &self.candidates);
        if !may_give_way {
            attempts.retain(|attempt| !attempt.gives_way);
            let is_staged = attempts.len() > 1;
            attempts.extend(is_staged.then_some(Attempt::STRICT));
        }
        attempts
    }

    /// Which of the candidates a container may take in a try.
    fn admitted(&self, container: &PreparedContainer, attempt: Attempt) -> Vec<usize> {
        let candidates = self.candidates.iter().enumerate();
        let admitted = candidates.filter(|(_, held)| {
            let orders = self.orders.as_ref();
            orders.is_none_or(|orders| orders.admits(attempt, container.at, held.arrival))
        });
        admitted.map(|(index, _)| index).collect()
    }

    /// By which rule a container may not take an item, for people; `None` where it may, or with `gives_way` where that rule gives way.
    pub(super) fn barred(
        &self,
        item: &SessionItem,
        container: usize,
        gives_way: bool,
    ) -> Option<String> {
        let PreparedContainer { at, name, .. } = self.containers.get(container)?;
        let bar = self.orders.as_ref()?.bar(*at, item.arrival)?;
        let told = match name.as_str() {
            "" => bar.to_string(),
            name => format!("container {name}: {bar}"),
        };
        (!gives_way || !bar.gives_way()).then_some(told)
    }
}

/// The candidates of an item, in the order of its poses.
pub(super) fn poses_of(candidates: &[Candidate], item: &SessionItem) -> Range<usize> {
    let is_of = |held: &&Candidate| held.arrival == item.arrival;
    let before = candidates.iter().take_while(|held| !is_of(held));
    let first = before.count();
    let poses = candidates.iter().skip(first).take_while(is_of);
    first..first + poses.count()
}

impl CellPlanner {
    /// Gets what a step is planned on; waits for heightmaps until the deadline.
    ///
    /// # Errors
    /// [`Status::Conflict`] where no container is open, [`Status::Unavailable`] where none can be planned on.
    pub(super) fn prepare(
        &mut self,
        items: Vec<SessionItem>,
        deadline: Instant,
    ) -> Result<Prepared, Refusal> {
        let candidates = self.candidates_of(&items)?;
        let open = self.open_by_fullness();
        let (containers, left_out) = self.prepare_containers(&open, deadline)?;
        let mut orders = self.orders(&open);
        if let Some(orders) = &mut orders {
            orders.begin(&candidates);
        }
        Ok(Prepared {
            items,
            candidates,
            containers,
            left_out,
            orders,
            number: self.session.step(),
            deadline,
        })
    }

    /// Items as a step may choose them, in their order, each in all the poses in which it may be packed.
    pub(super) fn candidates_of(
        &mut self,
        items: &[SessionItem],
    ) -> Result<Vec<Candidate>, Refusal> {
        let mut candidates = Vec::new();
        for item in items {
            candidates.extend(self.candidates(item)?);
        }
        Ok(candidates)
    }

    /// The open containers that can be planned on, the fullest first, and why the others cannot.
    fn prepare_containers(
        &mut self,
        open: &[String],
        deadline: Instant,
    ) -> Result<(Vec<PreparedContainer>, Vec<String>), Refusal> {
        let is_only = open.len() == 1;
        let (mut containers, mut left_out) = (Vec::new(), Vec::new());
        for (at, (name, seen)) in self.see(open, deadline)?.into_iter().enumerate() {
            match seen {
                Ok(seen) => containers.push(self.prepare_container(at, name, seen, deadline)?),
                Err(refusal) => {
                    counts::stale_scenes(&self.cell, 1);
                    if is_only {
                        return Err(refusal);
                    }
                    left_out.push(format!("container {name} is left out: {}", refusal.message));
                }
            }
        }
        match (containers.is_empty(), left_out.is_empty()) {
            (false, _) => Ok((containers, left_out)),
            (true, false) => Err(Refusal::unavailable(left_out.join("; "))),
            (true, true) => Err(Refusal::new(
                Status::Conflict,
                "no container is open: open one first",
            )),
        }
    }

    /// What containers look like now, or why that is not known. One is waited for until the deadline, several for a while.
    fn see(&mut self, open: &[String], deadline: Instant) -> Result<Vec<Sight>, Refusal> {
        let now = Instant::now();
        let (until, slice) = match open.len() {
            1 => (deadline, Duration::MAX),
            _ => {
                let left = deadline.saturating_duration_since(now);
                (now + ALL_PATIENCE.min(left / 2), SLICE)
            }
        };
        let mut seen: Vec<Sight> = Vec::new();
        for name in open {
            let first = self.seen_within(name, slice, deadline)?;
            seen.push((name.clone(), first));
        }
        while Instant::now() < until && !self.own.interruption.is_asked_for() {
            let mut unseen = seen.iter_mut().filter(|(_, seen)| seen.is_err()).peekable();
            if unseen.peek().is_none() {
                break;
            }
            for (name, seen) in unseen {
                *seen = self.seen_within(name, slice, until)?;
            }
        }
        Ok(seen)
    }

    fn seen_within(
        &mut self,
        name: &str,
        slice: Duration,
        deadline: Instant,
    ) -> Result<Result<Seen, Refusal>, SessionError> {
        let least = self.session.least_state_number(name);
        let slice = Instant::now().checked_add(slice);
        let until = slice.map_or(deadline, |slice| slice.min(deadline));
        Ok(self.place_of(name)?.seen(least, until))
    }

    fn prepare_container(
        &mut self,
        at: usize,
        name: String,
        mut seen: Seen,
        deadline: Instant,
    ) -> Result<PreparedContainer, Refusal> {
        let has_bounds = seen.scene.surface().is_some_and(Surface::has_bounds);
        if let Some(content) = self.content(&name, has_bounds, deadline) {
            seen.scene = seen.scene.with_content(content);
        }
        let place = self.place_of(&name)?;
        seen.scene = place.complete(seen.scene);
        if let Some(leaving) = self.leaving(&name)? {
            seen.scene = seen.scene.with_leaving(leaving);
        }
        let scene = self.blocked(&name, &seen.scene)?;
        Ok(PreparedContainer {
            at,
            name,
            seen,
            scene,
        })
    }

    /// The scene of a container with everything blocked that must stay free.
    fn blocked(&mut self, name: &str, scene: &Scene) -> Result<Scene, Refusal> {
        let mut regions = self.session.container(name)?.keep_out.clone();
        let packed = self.session.packed_in(name);
        let fragile: Vec<SessionItem> = packed
            .filter(|item| item.rules.is_fragile)
            .cloned()
            .collect();
        let grid = self.place_of(name)?.planning.grid().clone();
        for item in &fragile {
            if let ItemState::Packed {
                placement,
                pose,
                planned,
                container_from_item,
                ..
            } = &item.state
            {
                let shape = self.heightmaps(item, *pose)?;
                let moved = container_from_item.isometry() * planned.inverse();
                if let Some(view) = shape.views().get(placement.placement.yaw) {
                    regions.push(footprint(placement, view, &grid, &moved));
                }
            }
        }
        if regions.is_empty() {
            return Ok(scene.clone());
        }
        Ok(block(scene, &grid, &regions))
    }
}
