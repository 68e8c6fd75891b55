//! The input of a step: the buffer, and the pictures of the open containers.

use std::ops::Range;
use std::time::{Duration, Instant};

use ppnpack_packing::ranking::step::Candidate;
use ppnpack_packing::scene::Scene;
use ppnpack_packing::scene::blocked::block;
use ppnpack_packing::streams::orders::Orders;
use ppnpack_wire::v1::{self, Status};

use super::footprint::footprint;
use super::plan::{ContainerStep, StepPlan};
use super::{NotPlanned, Stepper};
use crate::counts;
use crate::fill::open_by_fullness;
use crate::orders::orders;
use crate::refusal::Refusal;
use crate::scenes::Seen;
use ppnpack_protocol::session::item::arrival;
use ppnpack_protocol::session::{Packed, SessionError, message};

/// Maximum time of looking into the open containers, after which another step may be planned.
const LOOK_LIMIT: Duration = Duration::from_secs(2);

/// Maximum wait of a step for the heightmaps of all open containers. Then it goes on.
const ALL_PATIENCE: Duration = Duration::from_secs(1);

/// Maximum wait for one of several before the others are looked at.
const SLICE: Duration = Duration::from_millis(100);

/// Pause before containers that were not seen are looked at again.
const PAUSE: Duration = Duration::from_millis(20);

/// The input of a step.
pub(super) struct Prepared {
    pub(super) items: Vec<v1::SessionItem>,
    pub(super) plan: StepPlan,
    /// Each container of the plan: its place among all that are open, by which orders know it, and
    /// its picture without anything blocked.
    pub(super) seen: Vec<(usize, Seen)>,
    /// The open containers that cannot be planned on, and why.
    pub(super) left_out: Vec<String>,
    /// The orders that containers are bound to; `None` where each may take all.
    orders: Option<Orders>,
}

/// The open containers, as a step sees them.
pub(super) struct Sights {
    /// All that are open, the fullest first.
    open: Vec<String>,
    containers: Vec<PreparedContainer>,
    /// Why the others are left out.
    left_out: Vec<String>,
}

/// A container of the plan, its place among all that are open, and what was seen in it.
type PreparedContainer = (ContainerStep, (usize, Seen));

/// A container by its name, and what it looks like, or why that is not known.
type Sight = (String, Result<Seen, Refusal>);

impl Prepared {
    /// Names the rule, for people, by which a container may not take an item; `None` where it may,
    /// or with `gives_way` where that rule gives way.
    pub(super) fn barred(
        &self,
        item: &v1::SessionItem,
        container: usize,
        gives_way: bool,
    ) -> Option<String> {
        let (at, _) = self.seen.get(container)?;
        let name = &self.plan.containers.get(container)?.name;
        let bar = self.orders.as_ref()?.bar(*at, arrival(item))?;
        let told = match name.as_str() {
            "" => bar.to_string(),
            name => format!("container {name}: {bar}"),
        };
        (!gives_way || !bar.gives_way()).then_some(told)
    }
}

/// Finds the candidates of an item, in the order of its poses.
pub(super) fn poses_of(candidates: &[Candidate], item: &v1::SessionItem) -> Range<usize> {
    let is_of = |held: &&Candidate| held.arrival == arrival(item);
    let before = candidates.iter().take_while(|held| !is_of(held));
    let first = before.count();
    let poses = candidates.iter().skip(first).take_while(is_of);
    first..first + poses.count()
}

impl Stepper {
    /// Looks into the open containers; waits for heightmaps for a while.
    ///
    /// # Errors
    /// [`NotPlanned`] where no container is open or seen, or the session cannot be that of the cell.
    pub(super) fn look(&mut self, deadline: Instant) -> Result<Sights, NotPlanned> {
        let deadline = deadline.min(Instant::now() + LOOK_LIMIT);
        self.must_be_newest(deadline)?;
        let containers = &self.containers;
        let size = |name: &str| {
            let own = containers.iter().find(|own| own.name == name)?;
            Some(own.planning.grid().container())
        };
        let open = open_by_fullness(&self.session, &mut self.shapes, size);
        let (containers, left_out) = self.prepare_containers(&open, deadline)?;
        Ok(Sights {
            open,
            containers,
            left_out,
        })
    }

    /// Gets the input of a step with these items of the buffer.
    pub(super) fn prepare(
        &mut self,
        sights: &Sights,
        items: Vec<v1::SessionItem>,
        alternatives: usize,
        deadline: Instant,
    ) -> Result<Prepared, Refusal> {
        let mut candidates = Vec::new();
        for item in &items {
            candidates.extend(self.shapes.candidates(item)?);
        }
        let (containers, seen): (Vec<ContainerStep>, Vec<(usize, Seen)>) =
            sights.containers.iter().cloned().unzip();
        let rules = &self.settings.rules;
        let mut orders = orders(rules, &self.session, &mut self.shapes, &sights.open);
        if let Some(orders) = &mut orders {
            orders.begin(&candidates);
        }
        let places: Vec<usize> = seen.iter().map(|(at, _)| *at).collect();
        let no_orders = Orders::default();
        let rules = orders.as_ref().unwrap_or(&no_orders);
        let mut attempts = rules.attempts(&places, &candidates);
        if !sights.left_out.is_empty() {
            // What a rule would give way to is not known before all containers were seen.
            attempts.truncate(1);
        }
        let named = items.iter().map(|item| v1::RecordedItem {
            item_id: item.item_id.clone(),
            object: item.object.clone(),
            arrival: item.arrival,
        });
        Ok(Prepared {
            plan: StepPlan {
                items: named.collect(),
                attempts,
                candidates,
                containers,
                number: self.session.step(),
                alternatives,
                deadline: Some(deadline),
                takes_untried: false,
            },
            items,
            seen,
            left_out: sights.left_out.clone(),
            orders,
        })
    }

    /// Gives the open containers to plan on, the fullest first, and why the others are left out.
    fn prepare_containers(
        &mut self,
        open: &[String],
        deadline: Instant,
    ) -> Result<(Vec<PreparedContainer>, Vec<String>), NotPlanned> {
        let is_only = open.len() == 1;
        let (mut containers, mut left_out) = (Vec::new(), Vec::new());
        let sights = self.see(open, deadline)?;
        self.must_not_be_ahead()?;
        for (at, (name, seen)) in sights.into_iter().enumerate() {
            match seen {
                Ok(seen) => {
                    let (container, seen) = self.prepare_container(name, seen)?;
                    containers.push((container, (at, seen)));
                }
                Err(refusal) => {
                    counts::stale_scenes(&self.cell, 1);
                    if is_only {
                        return Err(NotPlanned::Unseen(refusal));
                    }
                    left_out.push(format!("container {name} is left out: {}", refusal.message));
                }
            }
        }
        match (containers.is_empty(), left_out.is_empty()) {
            (false, _) => Ok((containers, left_out)),
            (true, false) => {
                let none = Refusal::unavailable(left_out.join("; "));
                Err(NotPlanned::Unseen(none))
            }
            (true, true) => {
                let text = "no container is open: open one first";
                Err(Refusal::new(Status::Conflict, text).into())
            }
        }
    }

    /// Gives the pictures of containers, or why there are none. One is waited for until the
    /// deadline, several for a while.
    fn see(&mut self, open: &[String], deadline: Instant) -> Result<Vec<Sight>, Refusal> {
        let now = Instant::now();
        let left = deadline.saturating_duration_since(now);
        let (until, slices) = match u32::try_from(open.len()).unwrap_or(u32::MAX) {
            1 => (deadline, [left; 2]),
            count => (
                now + ALL_PATIENCE.min(left / 2),
                [SLICE, ALL_PATIENCE / count.max(1)],
            ),
        };
        let mut seen: Vec<Sight> = Vec::new();
        for name in open {
            let first = self.seen_within(name, slices, deadline, deadline)?;
            seen.push((name.clone(), first));
        }
        while Instant::now() + PAUSE < until
            && self.containers.iter().all(|own| own.behind.is_none())
        {
            let mut unseen = seen.iter_mut().filter(|(_, seen)| seen.is_err()).peekable();
            if unseen.peek().is_none() {
                break;
            }
            std::thread::sleep(PAUSE);
            for (name, seen) in unseen {
                *seen = self.seen_within(name, slices, until, deadline)?;
            }
        }
        for name in open {
            self.container(name)?.scenes.reconsider();
        }
        Ok(seen)
    }

    /// Gives the picture of a container; `slices` are the waits for a heightmap and for the bridge.
    fn seen_within(
        &mut self,
        name: &str,
        slices: [Duration; 2],
        until: Instant,
        deadline: Instant,
    ) -> Result<Result<Seen, Refusal>, SessionError> {
        let now = Instant::now();
        let untils = slices.map(|slice| until.min(now + slice));
        self.believed(name, untils, deadline)
    }

    fn prepare_container(
        &mut self,
        name: String,
        mut seen: Seen,
    ) -> Result<(ContainerStep, Seen), Refusal> {
        seen.scene = self.container(&name)?.complete(seen.scene);
        if let Some(leaving) = self.leaving(&name)? {
            seen.scene = seen.scene.with_leaving(leaving);
        }
        let container = ContainerStep {
            scene: self.blocked(&name, &seen.scene)?,
            grid: self.container(&name)?.planning.grid().clone(),
            name,
        };
        Ok((container, seen))
    }

    /// Blocks everything in the scene of a container that must stay free.
    fn blocked(&mut self, name: &str, scene: &Scene) -> Result<Scene, Refusal> {
        let grid = self.container(name)?.planning.grid().clone();
        let mut regions = message::read_regions(&self.session.container(name)?.keep_out);
        let packed = self.session.packed_in(name);
        let fragile = packed.filter(|item| item.rules.is_some_and(|rules| rules.is_fragile));
        for item in fragile {
            let Some(packed) = Packed::read(item)? else {
                continue;
            };
            let shape = self.shapes.heightmaps(item, packed.pose)?;
            let moved = packed.container_from_item.isometry() * packed.planned.inverse();
            if let Some(view) = shape.views().get(packed.placement.placement.yaw) {
                regions.push(footprint(&packed.placement, view, &grid, &moved));
            }
        }
        if regions.is_empty() {
            return Ok(scene.clone());
        }
        Ok(block(scene, &grid, &regions))
    }
}
