//! Vertical forces with which bodies hold and load each other, from the impulses that the engine
//! keeps of its contacts.

use std::collections::{BTreeMap, BTreeSet};

use rapier3d::dynamics::RigidBodyHandle;
use rapier3d::geometry::ContactManifold;

use super::World;
use crate::convert::metres;

/// Time for bodies that were asleep, or just laid down, to press as they do at rest, in seconds.
const SETTLING_S: f64 = 0.05;

/// Time over which forces are averaged, in seconds: those of a single step tremble.
const AVERAGED_S: f64 = 0.1;

/// Mean vertical forces between what touches.
#[derive(Debug, Default)]
pub(crate) struct VerticalForces {
    /// Newtons, upwards, on a body by another one, or by what is no body: floor, walls and terrain.
    /// Bodies are numbered in the order in which they were asked for.
    on_by_n: BTreeMap<(usize, Option<usize>), f64>,
}

impl VerticalForces {
    /// Gives the bodies that press on this one, directly or through others, by more than `least_n`.
    pub(crate) fn above(&self, body: usize, least_n: f64) -> BTreeSet<usize> {
        let mut above = BTreeSet::new();
        let mut open = vec![body];
        while let Some(below) = open.pop() {
            let pressing = self.on(below).filter(|(_, up_n)| -up_n > least_n);
            for by in pressing.filter_map(|(by, _)| by) {
                if above.insert(by) {
                    open.push(by);
                }
            }
        }
        above.remove(&body);
        above
    }

    /// Sums the forces with which others press a body downwards, in newtons; those of one other
    /// body are netted first.
    pub(crate) fn pressing_n(&self, body: usize) -> f64 {
        let by_bodies = self.on(body).filter(|(by, _)| by.is_some());
        by_bodies.map(|(_, up_n)| (-up_n).max(0.0)).sum()
    }

    /// Sums all forces on a body but gravity, upwards, in newtons: its weight where it is at rest.
    pub(crate) fn total_n(&self, body: usize) -> f64 {
        self.on(body).map(|(_, up_n)| up_n).sum()
    }

    fn on(&self, body: usize) -> impl Iterator<Item = (Option<usize>, f64)> + '_ {
        let all = self.on_by_n.range((body, None)..(body + 1, None));
        all.map(|((_, by), up_n)| (*by, *up_n))
    }

    fn add(&mut self, on: Option<usize>, by: Option<usize>, up_n: f64) {
        if let Some(on) = on {
            *self.on_by_n.entry((on, by)).or_default() += up_n;
        }
    }
}

impl World {
    /// Goes on for a moment with all bodies awake, and measures the forces between them, and by
    /// what is no body.
    ///
    /// The engine keeps the impulses of sleeping bodies, and of contacts that are no more, from
    /// when they were last solved: so what sleeps is woken.
    pub(crate) fn vertical_forces(mut self, bodies: &[RigidBodyHandle]) -> VerticalForces {
        for handle in bodies {
            if let Some(body) = self.bodies.get_mut(*handle) {
                body.activation_mut().time_until_sleep = f32::MAX;
                body.wake_up(true);
            }
        }
        let timestep_s = f64::from(self.parameters.dt);
        let steps = |time_s: f64| (time_s / timestep_s).round().max(1.0) as usize;
        for _ in 0..steps(SETTLING_S) {
            self.step();
        }
        let numbers = bodies.iter().enumerate();
        let numbers = numbers.map(|(number, handle)| (handle.into_raw_parts(), number));
        let numbers: BTreeMap<(u32, u32), usize> = numbers.collect();
        let mut forces = VerticalForces::default();
        let averaged = steps(AVERAGED_S);
        for _ in 0..averaged {
            self.step();
            self.add_forces(&numbers, averaged as f64, &mut forces);
        }
        forces
    }

    fn add_forces(
        &self,
        numbers: &BTreeMap<(u32, u32), usize>,
        steps: f64,
        forces: &mut VerticalForces,
    ) {
        let number = |body: Option<RigidBodyHandle>| {
            body.and_then(|handle| numbers.get(&handle.into_raw_parts()).copied())
        };
        for pair in self.narrow_phase.contact_pairs() {
            for manifold in pair.solver_manifolds() {
                let impulse = self.upward_impulse(manifold);
                let up_n = metres(impulse) / f64::from(self.parameters.dt) / steps;
                let data = &manifold.data;
                let (one, other) = (number(data.rigid_body1), number(data.rigid_body2));
                forces.add(one, other, up_n);
                forces.add(other, one, -up_n);
            }
        }
    }

    /// Gives a step's impulse on the first body, upwards: along the normal, which points to the
    /// second, and of friction.
    ///
    /// Contacts that were not solved keep the impulse of the step in which they last were, and are
    /// left out. One impulse of friction is solved for all points of a manifold, and kept with each
    /// of them, in the world's frame: other than that along the normal, of the last substep alone.
    fn upward_impulse(&self, manifold: &ContactManifold) -> f32 {
        let solved = manifold.data.solver_contacts.iter();
        let solved = solved.flat_map(|contact| contact.contact_indices());
        let mut points = solved
            .filter_map(|index| manifold.points.get(index as usize))
            .peekable();
        let friction = points
            .peek()
            .map_or(0.0, |point| point.data.warmstart_tangent_world.z);
        let normal: f32 = points.map(|point| point.data.impulse).sum();
        let substeps = self.parameters.num_solver_iterations as f32;
        friction * substeps - manifold.data.normal.z * normal
    }
}
