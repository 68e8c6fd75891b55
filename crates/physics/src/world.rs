//! The rigid-body engine behind the cell: container, bodies, steps.

mod forces;

use nalgebra::Isometry3;
use ppnpack_catalogue::mesh::Bounds;
use ppnpack_catalogue::object::ConvexPiece;
use rapier3d::dynamics::{
    CCDSolver, CoefficientCombineRule, ImpulseJointSet, IntegrationParameters, IslandManager,
    MultibodyJointSet, RigidBody, RigidBodyBuilder, RigidBodyHandle, RigidBodySet, RigidBodyType,
    SoftBodySet, SpringCoefficients,
};
use rapier3d::geometry::{BroadPhaseBvh, ColliderBuilder, ColliderSet, ContactPair, NarrowPhase};
use rapier3d::math::Vector;
use rapier3d::pipeline::PhysicsPipeline;

use crate::body::{BodyTemplate, hull};
use crate::container::{boxes, leaning_walls};
use crate::convert::{engine_length, engine_pose, engine_vector, isometry, metres};
use crate::overlap::{Solid, deepest_m};
use crate::settings::{CellSettings, Combine, ContactSettings, SolverSettings};

/// Frequency of the springs that push out what overlaps, per substep rate.
///
/// The engine's default of 30 Hz is made for 60 steps a second; at 480 it lets a stack sink by
/// millimetres. The stiffest spring that a substep can resolve is at a fourth of its rate, but
/// there light items rattle between others for ever.
const STIFFNESS: f64 = 1.0 / 8.0;

/// Contacts are not computed anew while two bodies move against each other by less than this, in
/// length scales.
///
/// The engine's default is five times as much, half a centimetre for items of a decimetre, as large
/// as the items' own edges and features.
const RECYCLING: f32 = 0.01;

/// The state of the simulation, and what steps it. A clone continues with the same bits.
#[derive(Clone)]
pub(crate) struct World {
    gravity: Vector,
    parameters: IntegrationParameters,
    contact: ContactSettings,
    /// In the engine's unit of length a second.
    sleep_speed: f32,
    sleep_time_s: f32,
    islands: IslandManager,
    broad_phase: BroadPhaseBvh,
    narrow_phase: NarrowPhase,
    bodies: RigidBodySet,
    colliders: ColliderSet,
    impulse_joints: ImpulseJointSet,
    multibody_joints: MultibodyJointSet,
    soft_bodies: SoftBodySet,
    ccd_solver: CCDSolver,
    pipeline: Pipeline,
}

/// The engine's working memory. A clone has its own, made anew: it holds tables of the state that
/// it last stepped, which it would take for current.
struct Pipeline(PhysicsPipeline);

impl Clone for Pipeline {
    fn clone(&self) -> Self {
        Self(PhysicsPipeline::new())
    }
}

impl World {
    /// An empty container.
    pub(crate) fn new(settings: &CellSettings) -> Self {
        let mut world = Self {
            gravity: Vector::new(0.0, 0.0, -engine_length(settings.solver.gravity_m_s2)),
            parameters: parameters(&settings.solver),
            contact: settings.contact.clone(),
            sleep_speed: engine_length(settings.solver.sleep_speed_m_s),
            sleep_time_s: settings.solver.sleep_time_s as f32,
            islands: IslandManager::new(),
            broad_phase: BroadPhaseBvh::default(),
            narrow_phase: NarrowPhase::new(),
            bodies: RigidBodySet::new(),
            colliders: ColliderSet::new(),
            impulse_joints: ImpulseJointSet::new(),
            multibody_joints: MultibodyJointSet::new(),
            soft_bodies: SoftBodySet::new(),
            ccd_solver: CCDSolver::new(),
            pipeline: Pipeline(PhysicsPipeline::new()),
        };
        for bounds in boxes(settings) {
            world.insert_box(&bounds, settings.contact.wall_friction);
        }
        for wall in leaning_walls(settings) {
            let vertices = wall.vertices;
            // A piece without a hull is a part of an edge whose radius is nearly nothing.
            if let Ok(hull) = hull(&ConvexPiece { vertices }) {
                let collider = ColliderBuilder::new(hull);
                world.insert_still(collider, settings.contact.wall_friction);
            }
        }
        world
    }

    /// Adds a box that nothing moves, with the friction of items.
    pub(crate) fn insert_terrain(&mut self, bounds: &Bounds) {
        self.insert_box(bounds, self.contact.item_friction);
    }

    fn insert_box(&mut self, Bounds { lowest, highest }: &Bounds, friction: f64) {
        let half = (highest - lowest) * 0.5;
        let [x, y, z] = [half.x, half.y, half.z].map(engine_length);
        let collider = ColliderBuilder::cuboid(x, y, z)
            .translation(engine_vector(&nalgebra::center(lowest, highest).coords));
        self.insert_still(collider, friction);
    }

    fn insert_still(&mut self, collider: ColliderBuilder, friction: f64) {
        let collider = collider
            .friction(friction as f32)
            .friction_combine_rule(combine(self.contact.friction_combine))
            .restitution(self.contact.restitution as f32);
        self.colliders.insert(collider);
    }

    /// Adds a body at rest: a dynamic one, or a fixed one that nothing moves.
    pub(crate) fn insert(
        &mut self,
        kind: RigidBodyType,
        template: &BodyTemplate,
        container_from_item: &Isometry3<f64>,
    ) -> RigidBodyHandle {
        let mut body: RigidBody = RigidBodyBuilder::new(kind)
            .pose(engine_pose(container_from_item))
            .additional_mass_properties(template.mass)
            .build();
        let activation = body.activation_mut();
        // The engine compares half the speed of the farthest point with the threshold.
        activation.normalized_linear_threshold =
            0.5 * self.sleep_speed / self.parameters.length_unit;
        activation.time_until_sleep = self.sleep_time_s;
        let handle = self.bodies.insert(body);
        let collider = ColliderBuilder::new(template.shape.clone())
            // The body has the model's mass properties; its shape adds nothing to them.
            .density(0.0)
            .friction(self.contact.item_friction as f32)
            .friction_combine_rule(combine(self.contact.friction_combine))
            .restitution(self.contact.restitution as f32);
        self.colliders
            .insert_with_parent(collider, handle, &mut self.bodies);
        handle
    }

    /// Makes a body weigh so much, in kilograms, spread as it was.
    pub(crate) fn weigh(&mut self, handle: RigidBodyHandle, template: &BodyTemplate, mass_kg: f64) {
        if let Some(body) = self.bodies.get_mut(handle) {
            let mut mass = template.mass;
            mass.set_mass(mass_kg as f32, true);
            body.set_additional_mass_properties(mass, false);
        }
    }

    /// Lets a body sleep until the next contact that begins, be it with what it lies on.
    pub(crate) fn put_to_sleep(&mut self, handle: RigidBodyHandle) {
        if let Some(body) = self.bodies.get_mut(handle) {
            body.sleep();
        }
    }

    /// Takes a body out.
    pub(crate) fn remove(&mut self, handle: RigidBodyHandle) {
        self.bodies.remove(
            handle,
            &mut self.islands,
            &mut self.colliders,
            &mut self.impulse_joints,
            &mut self.multibody_joints,
            &mut self.soft_bodies,
            true,
        );
    }

    /// Advances by one time step.
    pub(crate) fn step(&mut self) {
        self.pipeline.0.step(
            self.gravity,
            &self.parameters,
            &mut self.islands,
            &mut self.broad_phase,
            &mut self.narrow_phase,
            &mut self.bodies,
            &mut self.colliders,
            &mut self.impulse_joints,
            &mut self.multibody_joints,
            &mut self.soft_bodies,
            &mut self.ccd_solver,
            &(),
            &(),
        );
    }

    /// Says whether no body is awake, so that further steps change nothing. Fixed ones neither
    /// sleep nor wake.
    pub(crate) fn is_asleep(&self) -> bool {
        let mut bodies = self.bodies.iter();
        bodies.all(|(_, body)| body.is_sleeping() || body.is_fixed())
    }

    /// Gives the pose of a body.
    pub(crate) fn pose(&self, handle: RigidBodyHandle) -> Option<Isometry3<f64>> {
        let body = self.bodies.get(handle);
        body.map(|body| isometry(body.position()))
    }

    /// Gives an upper bound of the speed of a body's points, in m/s, where all are within
    /// `radius_m` of its centre of mass; 0 when it sleeps.
    pub(crate) fn surface_speed_m_s(&self, handle: RigidBodyHandle, radius_m: f64) -> f64 {
        match self.bodies.get(handle) {
            Some(body) if !body.is_sleeping() => {
                let angular_rad_s = f64::from(body.angvel().length());
                metres(body.linvel().length()) + angular_rad_s * radius_m
            }
            _ => 0.0,
        }
    }

    /// The deepest that two touching bodies, or a body and the container, reach into each other, in
    /// metres.
    pub(crate) fn deepest_overlap_m(&self) -> f64 {
        let solids = |handle| {
            self.colliders
                .get(handle)
                .map(Solid::all_of)
                .unwrap_or_default()
        };
        let overlap_m =
            |pair: &ContactPair| deepest_m(&solids(pair.collider1), &solids(pair.collider2));
        let pairs = self.narrow_phase.contact_pairs();
        pairs.map(overlap_m).fold(0.0, f64::max)
    }

    /// Whether the engine disabled a body because its state was no longer finite.
    pub(crate) fn gave_up(&self, handle: RigidBodyHandle) -> bool {
        let body = self.bodies.get(handle);
        body.is_some_and(|body| !body.is_enabled())
    }
}

fn combine(rule: Combine) -> CoefficientCombineRule {
    match rule {
        Combine::Average => CoefficientCombineRule::Average,
        Combine::Multiply => CoefficientCombineRule::Multiply,
        Combine::Min => CoefficientCombineRule::Min,
        Combine::Max => CoefficientCombineRule::Max,
    }
}

fn parameters(solver: &SolverSettings) -> IntegrationParameters {
    let substep_hz = solver.substeps as f64 / solver.timestep_s;
    let softness = SpringCoefficients {
        natural_frequency: (substep_hz * STIFFNESS) as f32,
        ..SpringCoefficients::contact_defaults()
    };
    IntegrationParameters {
        dt: solver.timestep_s as f32,
        num_solver_iterations: solver.substeps,
        num_internal_pgs_iterations: solver.sweeps,
        num_internal_stabilization_iterations: solver.sweeps,
        contact_softness: softness,
        static_contact_softness: softness,
        length_unit: engine_length(solver.length_scale_m),
        normalized_contact_recycle_distance: RECYCLING,
        // Nothing passes the walls' middle within a step.
        max_ccd_substeps: 0,
        ..IntegrationParameters::default()
    }
}
