//! Loads on the bodies of a twin once an item was placed among them.

use nalgebra::Isometry3;
use rapier3d::dynamics::{RigidBodyHandle, RigidBodyType};
use rayon::prelude::*;

use super::{Solid, Twin};
use crate::body::BodyTemplate;
use crate::error::PhysicsError;
use crate::settings::CellSettings;
use crate::world::World;

/// Minimum force that counts as resting on something, in newtons.
const LEAST_N: f64 = 0.005;

/// Time after which all bodies count as at rest once they are, in seconds.
const AT_REST_S: f64 = 0.1;

/// Goes on until all bodies, each within a radius in metres of its centre of mass, are at rest, or
/// the time is over.
///
/// # Errors
/// What `in_time` says before each step.
fn settle(
    world: &mut World,
    bodies: &[(RigidBodyHandle, f64)],
    cell: &CellSettings,
    in_time: impl Fn() -> Result<(), PhysicsError>,
) -> Result<(), PhysicsError> {
    let still_m_s = cell.solver.sleep_speed_m_s;
    let wanted = (AT_REST_S / cell.solver.timestep_s).ceil() as usize;
    let mut still = 0;
    for _ in 0..cell.settle_steps() {
        in_time()?;
        world.step();
        let is_still = |(handle, radius_m): &(RigidBodyHandle, f64)| {
            world.surface_speed_m_s(*handle, *radius_m) <= still_m_s
        };
        still = if bodies.iter().all(is_still) {
            still + 1
        } else {
            0
        };
        if still >= wanted {
            break;
        }
    }
    Ok(())
}

impl Twin {
    /// Measures the load on each body, in kilograms, once an item of this mass has come to rest at
    /// a place.
    ///
    /// How a pile shares a weight among those that bear it depends on fractions of a millimetre. So
    /// loads count `margin` times, but never more than the mass of all that presses on the body,
    /// directly or through others.
    ///
    /// All bodies take part and move, other than in [`try_placement`](Self::try_placement): a load
    /// is passed down through the whole pile.
    ///
    /// # Errors
    /// [`PhysicsError::Pose`] where the pose is not finite, not rigid or far away;
    /// [`PhysicsError::Late`].
    pub fn try_loads_kg(
        &self,
        Solid(template): &Solid,
        mass_kg: f64,
        container_from_item: &Isometry3<f64>,
        margin: f64,
    ) -> Result<Vec<f64>, PhysicsError> {
        let planned = self.checked(&template.model, container_from_item)?;
        self.loads_kg(template, mass_kg, &planned, &self.fine, margin)
    }

    /// Measures the same under the disturbance: the greatest load on each body where the item is
    /// let go on each of four sides of its place, on the threads of a pool.
    ///
    /// # Errors
    /// As [`try_loads_kg`](Self::try_loads_kg).
    pub fn try_disturbed_loads_kg(
        &self,
        Solid(template): &Solid,
        mass_kg: f64,
        container_from_item: &Isometry3<f64>,
        margin: f64,
        pool: Option<&rayon::ThreadPool>,
    ) -> Result<Vec<f64>, PhysicsError> {
        let planned = self.checked(&template.model, container_from_item)?;
        let around = self.settings.disturbance.around(&planned);
        let tried =
            |held: &Isometry3<f64>| self.loads_kg(template, mass_kg, held, &self.patient, margin);
        let loads_kg: Result<Vec<Vec<f64>>, PhysicsError> = match pool {
            Some(pool) => pool.install(|| around.par_iter().map(tried).collect()),
            None => around.iter().map(tried).collect(),
        };
        let loads_kg = loads_kg?;
        let most_kg = |body: usize| {
            let of_body = loads_kg.iter().filter_map(|loads_kg| loads_kg.get(body));
            of_body.copied().fold(0.0, f64::max)
        };
        Ok((0..self.laid.bodies.len()).map(most_kg).collect())
    }

    /// Measures the load on each body where the item is let go above where it is held.
    fn loads_kg(
        &self,
        template: &BodyTemplate,
        mass_kg: f64,
        held: &Isometry3<f64>,
        cell: &CellSettings,
        margin: f64,
    ) -> Result<Vec<f64>, PhysicsError> {
        let mut world = World::new(cell);
        for bounds in &self.laid.terrain {
            world.insert_terrain(bounds);
        }
        let mut released = *held;
        released.translation.z += cell.release.height_m;
        let mut insert = |template: &BodyTemplate, pose: &Isometry3<f64>, mass_kg: f64| {
            let handle = world.insert(RigidBodyType::Dynamic, template, pose);
            world.weigh(handle, template, mass_kg);
            ((handle, template.radius_m), mass_kg)
        };
        let lying = self.laid.bodies.iter().map(|lying| {
            let (pose, mass_kg) = (&lying.container_from_item, lying.burden.mass_kg);
            insert(&lying.template, pose, mass_kg)
        });
        let (mut bodies, mut masses_kg): (Vec<_>, Vec<f64>) = lying.unzip();
        let (body, mass_kg) = insert(template, &released, mass_kg);
        bodies.push(body);
        masses_kg.push(mass_kg);
        settle(&mut world, &bodies, cell, || self.in_time())?;
        let handles: Vec<RigidBodyHandle> = bodies.iter().map(|(handle, _)| *handle).collect();
        let forces = world.vertical_forces(&handles);
        let load_kg = |body| {
            let carried_kg = forces.pressing_n(body) / cell.solver.gravity_m_s2;
            let above = forces.above(body, LEAST_N).into_iter();
            let above_kg: f64 = above.filter_map(|by| masses_kg.get(by)).sum();
            // What is wedged in may press with more than it weighs.
            carried_kg.max((margin * carried_kg).min(above_kg))
        };
        Ok((0..self.laid.bodies.len()).map(load_kg).collect())
    }
}
