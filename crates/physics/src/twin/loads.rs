//! What the bodies of a twin carry once an item was placed among them.

use nalgebra::Isometry3;
use rapier3d::dynamics::RigidBodyHandle;
use rayon::prelude::*;

use super::{Solid, Twin};
use crate::body::BodyTemplate;
use crate::cell::checked_pose;
use crate::error::PhysicsError;
use crate::settings::CellSettings;
use crate::world::World;

/// What presses with less than this counts as resting on nothing, in newtons.
const LEAST_N: f64 = 0.005;

/// All bodies count as at rest once they were for so long, in seconds.
const AT_REST_S: f64 = 0.1;

/// Goes on until all bodies, each within a radius in metres of its centre of mass, are at rest, or the time is over.
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
        let mut speeds_m_s = bodies
            .iter()
            .map(|(handle, radius_m)| world.surface_speed_m_s(*handle, *radius_m));
        still = match speeds_m_s.all(|speed_m_s| speed_m_s <= still_m_s) {
            true => still + 1,
            false => 0,
        };
        if still >= wanted {
            break;
        }
    }
    Ok(())
}

impl Twin {
    /// What rests on each of the bodies that lie there where an item of this mass has come to rest at a place, in kilograms.
    ///
    /// How a pile shares a weight among those that bear it depends on fractions of a millimetre. So loads count `margin` times, but
    /// never more than the mass of all that presses on the body, directly or through others.
    ///
    /// All bodies take part and move, other than in [`try_placement`](Self::try_placement): a load is passed down through the whole pile.
    ///
    /// # Errors
    /// [`PhysicsError::Pose`] where the pose is not finite, not rigid or far away; [`PhysicsError::Late`].
    pub fn try_loads_kg(
        &self,
        Solid(template): &Solid,
        mass_kg: f64,
        container_from_item: &Isometry3<f64>,
        margin: f64,
    ) -> Result<Vec<f64>, PhysicsError> {
        let container = self.settings.cell.container;
        let planned = checked_pose(container, &template.model, container_from_item)?;
        self.loads_kg(template, mass_kg, &planned, &self.fine, margin)
    }

    /// The same under the disturbance: the most of what rests on each where the item is let go on each of four sides of its place, on the
    /// threads of a pool.
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
        let container = self.settings.cell.container;
        let planned = checked_pose(container, &template.model, container_from_item)?;
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

    /// What rests on each body where the item is let go above where it is held.
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
        let radii_m = self.laid.bodies.iter().map(|lying| lying.template.radius_m);
        let radii_m: Vec<f64> = radii_m.chain([template.radius_m]).collect();
        let mut released = *held;
        released.translation.z += cell.release.height_m;
        handles.push(insert(template, &released, mass_kg));
        let bodies: Vec<(RigidBodyHandle, f64)> = handles.iter().copied().zip(radii_m).collect();
        settle(&mut world, &bodies, cell, || self.in_time())?;
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
        Ok((0..self.laid.bodies.len()).map(load_kg).collect())
    }
}
