//! What the bodies of a twin carry once an item was placed among them.

use nalgebra::Isometry3;
use rapier3d::dynamics::RigidBodyHandle;

use super::{Solid, Twin};
use crate::body::BodyTemplate;
use crate::cell::checked_pose;
use crate::error::PhysicsError;
use crate::settings::CellSettings;
use crate::world::World;

/// What presses with less than this counts as resting on nothing, in newtons.
const LEAST_N: f64 = 0.005;

impl Twin {
    /// What rests on each of the bodies that lie there where an item of this mass has come to rest at a place, in kilograms: the most of
    /// what does when the item is let go as planned, and under the disturbance on each of four sides of its place.
    ///
    /// How a pile shares a weight among those that bear it depends on fractions of a millimetre. So loads count `margin` times, but
    /// never more than the mass of all that presses on the body, directly or through others.
    ///
    /// All bodies take part and move, other than in [`try_placement`](Self::try_placement): a load is passed down through the whole pile.
    ///
    /// # Errors
    /// [`PhysicsError::Pose`] where the pose is not finite, not rigid or far away.
    pub fn try_loads_kg(
        &self,
        Solid(template): &Solid,
        mass_kg: f64,
        container_from_item: &Isometry3<f64>,
        margin: f64,
    ) -> Result<Vec<f64>, PhysicsError> {
        let cell = &self.fine;
        let planned = checked_pose(cell.container, &template.model, container_from_item)?;
        let around = self.settings.disturbance.around(&planned);
        let around = around.map(|held| (&self.fine_disturbed, held));
        let tries = std::iter::once((cell, planned)).chain(around);
        let mut most_kg = vec![0.0_f64; self.laid.bodies.len()];
        for (cell, held) in tries {
            let loads_kg = self.loads_kg(template, mass_kg, &held, cell, margin);
            for (most_kg, load_kg) in most_kg.iter_mut().zip(loads_kg) {
                *most_kg = most_kg.max(load_kg);
            }
        }
        Ok(most_kg)
    }

    /// What rests on each body where the item is let go above where it is held.
    fn loads_kg(
        &self,
        template: &BodyTemplate,
        mass_kg: f64,
        held: &Isometry3<f64>,
        cell: &CellSettings,
        margin: f64,
    ) -> Vec<f64> {
        let mut world = World::new(cell);
        for bounds in &self.laid.terrain {
            world.insert_terrain(bounds);
        }
        let mut insert = |template: &BodyTemplate, pose: &Isometry3<f64>, mass_kg: f64| {
            let handle = world.insert(template, pose);
            world.weigh(handle, template, mass_kg);
            handle
        };
        let lying = self.laid.bodies.iter();
        let lying = lying.map(|lying| {
            insert(
                &lying.template,
                &lying.container_from_item,
                lying.burden.mass_kg,
            )
        });
        let mut handles: Vec<RigidBodyHandle> = lying.collect();
        let mut released = *held;
        released.translation.z += cell.release.height_m;
        handles.push(insert(template, &released, mass_kg));
        for _ in 0..cell.settle_steps() {
            if world.is_asleep() {
                break;
            }
            world.step();
        }
        let forces = world.vertical_forces(&handles);
        let lying = self.laid.bodies.iter().map(|lying| lying.burden.mass_kg);
        let masses_kg: Vec<f64> = lying.chain([mass_kg]).collect();
        let load_kg = |body| {
            let carried_kg = forces.pressing_n(body) / cell.solver.gravity_m_s2;
            let above = forces.above(body, LEAST_N).into_iter();
            let above_kg: f64 = above.filter_map(|by| masses_kg.get(by)).sum();
            // What is wedged in may press with more than it weighs.
            carried_kg.max((margin * carried_kg).min(above_kg))
        };
        (0..self.laid.bodies.len()).map(load_kg).collect()
    }
}
