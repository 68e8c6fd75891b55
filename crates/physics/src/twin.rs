//! The twin of a cell: what is known to lie there, in which placements are tried.
//!
//! A try simulates only what it can touch. The item is let go as a robot would let it go, among the
//! bodies near its place: those that it may touch move with it, those around them are fixed, and
//! the rest of the content is left out. So a try costs the same in a full container as in a
//! half-empty one.
//!
//! Where not all that lies there is known, the rest is as the heightmap shows it, and nothing moves
//! it.

mod loads;
mod together;

use std::f64::consts::PI;
use std::sync::Arc;
use std::time::Instant;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use ppnpack_catalogue::mesh::Bounds;
use ppnpack_catalogue::object::Model;
use ppnpack_numbers::{SettingError, settings, within};
use ppnpack_packing::checks::trial::{RIM_TOLERANCE_M, Settling, TrialLimits};
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::scene::Scene;
use ppnpack_packing::scene::content::Burden;
use ppnpack_packing::scene::content::LyingSolid;
use rapier3d::dynamics::{RigidBodyHandle, RigidBodyType};

use crate::body::{BodyTemplate, Templates};
use crate::cell::checked_pose;
use crate::error::PhysicsError;
use crate::laid::{Laid, Lying, are_near};
use crate::outcome::tilt_rad;
use crate::settings::CellSettings;
use crate::terrain;
use crate::world::World;
pub(crate) use together::Placed;

/// Minimum time step of a try, in seconds. Half of that changed neither how full containers get nor
/// what stays in them.
const TIMESTEP_S: f64 = 1.0 / 240.0;

/// Bodies that a try lifts by no more than this count as lying where they lay, in metres.
const LIFTED_M: f64 = 0.0003;

/// Times that its lift in a try is added to that of another body: tries of one placement differ by
/// as much (`docs/results/filling.md`).
const LIFT_DOUBT: f64 = 3.0;

/// Minimum distance below the rim, in metres, at which an item ends in a try that is planned above
/// it.
const SINKING_DOUBT_M: f64 = 0.001;

/// Number of attempts that a try consists of: the rough one, and the disturbed ones.
const ATTEMPTS: usize = 3;

/// The outcome for an item that the engine gave up on.
const GIVEN_UP: Settling = Settling {
    tilt_rad: PI,
    slide_m: 0.0,
    disturbance_m: 0.0,
    above_rim_m: 0.0,
    is_still: false,
};

settings! {
    /// Settings of tries. A rough try, in coarse steps of time, refuses most of what would not
    /// stay; what passes it is tried twice more, for longer and under a disturbance: one way, and
    /// the other.
    pub struct TwinSettings {
        /// The cell that is copied; its settling time is the longest that a try lasts.
        pub cell: CellSettings = TwinSettings::copy_of(CellSettings::robot()),
        /// The rough try.
        pub rough: RoughSettings = RoughSettings::default(),
        /// Differences of the tries after the rough one from the plan: the real cell is not quite
        /// the twin.
        pub disturbance: Disturbance = Disturbance::default(),
        /// Bodies this close to the item's place move in a try, in metres.
        pub reach_m: f64 = 0.01,
        /// An item that is slower than this counts as at rest when the time is over, in m/s.
        pub still_speed_m_s: f64 = 0.05,
    }
}

settings! {
    /// Settings of the rough try.
    #[derive(Copy)]
    pub struct RoughSettings {
        /// Time per step, in seconds.
        pub timestep_s: f64 = TIMESTEP_S,
        /// Substeps per step.
        pub substeps: usize = 2,
        /// The longest that it lasts, in seconds of simulated time.
        pub settle_time_s: f64 = 0.5,
    }
}

settings! {
    /// Differences of two tries of a placement from the plan: in one the item is let go beside its
    /// place, ahead along x and y, and is turned to the left; in the other behind and turned to the
    /// right. Both have the same friction.
    #[derive(Copy)]
    pub struct Disturbance with validate as "disturbance." {
        /// Factor of all friction coefficients.
        pub friction: f64 = 0.75 => within("between 0.1 and 10", 0.1..=10.0),
        /// Distance from its place at which the item is let go, along x and along y, in metres.
        pub shift_m: f64 = 0.003 => within("between 0 and 0.1 m", 0.0..=0.1),
        /// Angle by which it is turned about the vertical, in radians.
        pub yaw_rad: f64 = 1.0_f64.to_radians() => within("between 0 and 1 rad", 0.0..=1.0),
    }
}

impl Disturbance {
    /// Gives the poses in which the item is held instead of the planned one, in either try.
    fn held(&self, planned: &Isometry3<f64>) -> [Isometry3<f64>; 2] {
        [1.0, -1.0].map(|way| self.beside(planned, [way, way], way))
    }

    /// Gives the poses beside the planned one on each of the four sides between x and y.
    fn around(&self, planned: &Isometry3<f64>) -> [Isometry3<f64>; 4] {
        let ways = [[1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]];
        ways.map(|ways| self.beside(planned, ways, ways[0]))
    }

    fn beside(&self, planned: &Isometry3<f64>, [x, y]: [f64; 2], turn: f64) -> Isometry3<f64> {
        let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn * self.yaw_rad);
        let shift_m = Vector3::new(x, y, 0.0) * self.shift_m;
        let shifted = planned.translation.vector + shift_m;
        Isometry3::from_parts(shifted.into(), turned * planned.rotation)
    }
}

impl TwinSettings {
    /// Makes the twin of a cell. A try lasts a second at most, in steps of 1/240 s or longer, and
    /// the robot makes no errors in it but the disturbance.
    pub fn of(cell: &CellSettings) -> Self {
        Self {
            cell: Self::copy_of(cell.clone()),
            ..Self::default()
        }
    }

    fn copy_of(mut cell: CellSettings) -> CellSettings {
        cell.solver.timestep_s = cell.solver.timestep_s.max(TIMESTEP_S);
        cell.settle_time_s = cell.settle_time_s.min(1.0);
        cell.release.jitter_m = 0.0;
        cell.release.jitter_yaw_rad = 0.0;
        cell
    }

    /// The cell of rough tries.
    fn rough_cell(&self) -> CellSettings {
        let mut cell = self.cell.clone();
        cell.solver.timestep_s = self.rough.timestep_s;
        cell.solver.substeps = self.rough.substeps;
        cell.settle_time_s = self.rough.settle_time_s;
        cell
    }

    /// The cell of disturbed tries.
    fn disturbed_cell(&self) -> CellSettings {
        let mut cell = self.cell.clone();
        cell.contact.item_friction *= self.disturbance.friction;
        cell.contact.wall_friction *= self.disturbance.friction;
        cell
    }

    /// A cell in which loads are tried: for twice as long, as what slides or rolls slowly comes to
    /// rest late.
    fn patient(mut cell: CellSettings) -> CellSettings {
        cell.settle_time_s *= 2.0;
        cell
    }

    /// The cell in which loads are tried as planned: in steps as short as those of the cell that is
    /// copied.
    fn fine_cell(&self) -> CellSettings {
        let mut cell = Self::patient(self.cell.clone());
        cell.solver.timestep_s /= 2.0;
        cell
    }

    /// Checks that every number is possible.
    ///
    /// # Errors
    /// [`SettingError`] names the first that is not.
    pub fn validate(&self) -> Result<(), SettingError> {
        self.cell.validate()?;
        self.rough_cell().validate()?;
        self.disturbance.validate()?;
        let reach = within("between 0 and 1 m", 0.0..=1.0);
        reach("reach_m", self.reach_m)?;
        let speed = within("between 0 and 1 m/s", 0.0..=1.0);
        speed("still_speed_m_s", self.still_speed_m_s)
    }
}

/// The known content of a container, as bodies.
pub struct Twin {
    settings: TwinSettings,
    /// The cells of rough and of disturbed tries.
    rough: CellSettings,
    disturbed: CellSettings,
    /// The cells of tries of loads, as planned and disturbed.
    fine: CellSettings,
    patient: CellSettings,
    templates: Templates,
    laid: Laid,
    /// The end of tries that have not come to an end before.
    deadline: Option<Instant>,
}

/// A model that can be simulated.
#[derive(Clone)]
pub struct Solid(Arc<BodyTemplate>);

impl Solid {
    /// Gives the limits that it has to keep: tighter ones where it rolls on a floor from the pose
    /// in which it stands.
    pub(crate) fn limits(&self, limits: &TrialLimits) -> TrialLimits {
        match self.0.can_roll {
            true => limits.of_rolling(),
            false => *limits,
        }
    }
}

impl Twin {
    /// The twin of an empty cell.
    ///
    /// # Errors
    /// [`PhysicsError::Setting`] where a setting is impossible.
    pub fn new(settings: TwinSettings) -> Result<Self, PhysicsError> {
        settings.validate()?;
        Ok(Self {
            rough: settings.rough_cell(),
            disturbed: settings.disturbed_cell(),
            fine: settings.fine_cell(),
            patient: TwinSettings::patient(settings.disturbed_cell()),
            settings,
            templates: Templates::default(),
            laid: Laid::default(),
            deadline: None,
        })
    }

    /// Ends tries from now on that take longer than until then: they fail as
    /// [`PhysicsError::Late`].
    pub fn end_by(&mut self, deadline: Option<Instant>) {
        self.deadline = deadline;
    }

    /// Fails where the time of tries is over.
    fn in_time(&self) -> Result<(), PhysicsError> {
        match self.deadline {
            Some(deadline) if Instant::now() >= deadline => Err(PhysicsError::Late),
            _ => Ok(()),
        }
    }

    /// Lays down what of some content can be simulated, in place of what lay there; says whether
    /// that is all of it.
    pub fn lay_down(&mut self, content: &[LyingSolid]) -> bool {
        let laid = content.iter().filter_map(|solid| self.lying(solid).ok());
        let bodies = laid.collect();
        let terrain = Vec::new();
        self.laid = Laid { bodies, terrain };
        self.templates.tidy();
        self.laid.bodies.len() == content.len()
    }

    /// Fills the container up to where a scene shows more than what was laid down, with what
    /// nothing moves.
    ///
    /// # Errors
    /// [`PhysicsError::Heightmap`] where the scene is not of the grid; then nothing has changed.
    pub fn fill_up(&mut self, grid: &Grid, scene: &Scene) -> Result<(), PhysicsError> {
        let known = self.laid.bodies.iter().map(|lying| {
            let mesh = &lying.template.model.mesh;
            (mesh, &lying.container_from_item)
        });
        self.laid.terrain = terrain::unexplained(grid, scene, known)?;
        Ok(())
    }

    fn lying(&mut self, solid: &LyingSolid) -> Result<Lying, PhysicsError> {
        let pose = self.checked(&solid.model, &solid.container_from_item)?;
        let template = self.templates.of(&solid.model)?;
        Ok(Lying {
            bounds: template.bounds(&pose),
            container_from_item: pose,
            template,
            burden: solid.burden.clone(),
        })
    }

    fn checked(
        &self,
        model: &Model,
        pose: &Isometry3<f64>,
    ) -> Result<Isometry3<f64>, PhysicsError> {
        checked_pose(self.settings.cell.container, model, pose)
    }

    /// Gives what each of the bodies that lie there weighs, and may carry.
    pub(crate) fn burdens(&self) -> impl Iterator<Item = &Burden> {
        self.laid.bodies.iter().map(|lying| &lying.burden)
    }

    /// Gives the content.
    pub(crate) fn laid(&self) -> &Laid {
        &self.laid
    }

    /// Says whether what is in some boxes cannot matter to an item at a place.
    pub(crate) fn is_beyond_reach(
        &self,
        Solid(template): &Solid,
        container_from_item: &Isometry3<f64>,
        boxes: &[Bounds],
    ) -> bool {
        let place = template.bounds(container_from_item);
        self.laid
            .is_beyond_reach(&place, boxes, self.settings.reach_m)
    }

    /// Prepares a model to be tried; its hulls are built the first time.
    ///
    /// # Errors
    /// [`PhysicsError::Model`] where it has no usable hulls or mass.
    pub fn solid(&mut self, model: &Arc<Model>) -> Result<Solid, PhysicsError> {
        Ok(Solid(self.templates.of(model)?))
    }

    /// Says whether a solid can be tried there: the pose is finite, rigid and not far away.
    pub fn can_try(&self, Solid(template): &Solid, container_from_item: &Isometry3<f64>) -> bool {
        self.checked(&template.model, container_from_item).is_ok()
    }

    /// Measures how far below a place an item touches what lies there, in metres. At most it is the
    /// height from which items are let go: let go above where it touches by that, an item is
    /// nowhere lower than at its place.
    pub fn clearance_m(&self, Solid(template): &Solid, pose: &Isometry3<f64>) -> f64 {
        let most_m = self.settings.cell.release.height_m;
        self.laid.clearance_m(template, pose, most_m)
    }

    /// Tries to place an item. A try that goes beyond the limits ends then and there.
    ///
    /// # Errors
    /// [`PhysicsError::Pose`] where the pose is not finite, not rigid or far away;
    /// [`PhysicsError::Late`].
    pub fn try_placement(
        &self,
        solid: &Solid,
        container_from_item: &Isometry3<f64>,
        limits: &TrialLimits,
    ) -> Result<Settling, PhysicsError> {
        let attempt = |number: usize| {
            let pose = container_from_item;
            self.attempt(solid, pose, number, limits, || self.in_time())
        };
        let mut settling = attempt(0)?;
        for number in 1..ATTEMPTS {
            if settling.beyond(limits).is_some() {
                break;
            }
            settling = settling.worse(&attempt(number)?);
        }
        Ok(settling)
    }

    /// Lets an item go above its place in the first attempt, the rough one, and beside it in the
    /// others. `goes_on` says before each step why the attempt has to end.
    fn attempt(
        &self,
        Solid(template): &Solid,
        container_from_item: &Isometry3<f64>,
        number: usize,
        limits: &TrialLimits,
        goes_on: impl Fn() -> Result<(), PhysicsError>,
    ) -> Result<Settling, PhysicsError> {
        let planned = &self.checked(&template.model, container_from_item)?;
        let disturbed = self.settings.disturbance.held(planned);
        let (held, cell) = match number.checked_sub(1).and_then(|way| disturbed.get(way)) {
            Some(held) => (held, &self.disturbed),
            None => (planned, &self.rough),
        };
        let mut released = *held;
        released.translation.z += cell.release.height_m;
        let mut world = World::new(cell);
        let movable = self.lay_near(&mut world, &template.bounds(planned));
        let handle = world.insert(RigidBodyType::Dynamic, template, &released);
        let mut attempt = Attempt {
            world,
            handle,
            template,
            planned: *planned,
            movable,
        };
        let mut settling = GIVEN_UP;
        for _ in 0..cell.settle_steps() {
            goes_on()?;
            attempt.world.step();
            settling = attempt.settling(self.settings.still_speed_m_s);
            if settling.severity(limits) > 1.0 || attempt.world.is_asleep() {
                break;
            }
        }
        Ok(Settling {
            above_rim_m: attempt.above_rim_m(cell.container.z_m),
            ..settling
        })
    }

    /// Lays down the bodies and the terrain near a place; gives the bodies that can move.
    fn lay_near(&self, world: &mut World, place: &Bounds) -> Vec<Movable<'_>> {
        let reach_m = self.settings.reach_m;
        let is_movable = |lying: &Lying| are_near(&lying.bounds, place, reach_m);
        let is_near_movable = |other: &Bounds| {
            let mut movable = self.laid.bodies.iter().filter(|lying| is_movable(lying));
            movable.any(|lying| are_near(other, &lying.bounds, reach_m))
        };
        let mut movable = Vec::new();
        for lying in &self.laid.bodies {
            let (template, pose) = (&lying.template, &lying.container_from_item);
            if is_movable(lying) {
                let handle = world.insert(RigidBodyType::Dynamic, template, pose);
                movable.push(Movable { handle, lying });
            } else if is_near_movable(&lying.bounds) {
                world.insert(RigidBodyType::Fixed, template, pose);
            }
        }
        for bounds in &self.laid.terrain {
            if are_near(bounds, place, reach_m) || is_near_movable(bounds) {
                world.insert_terrain(bounds);
            }
        }
        movable
    }
}

struct Movable<'a> {
    handle: RigidBodyHandle,
    lying: &'a Lying,
}

/// A try under way.
struct Attempt<'a> {
    world: World,
    handle: RigidBodyHandle,
    template: &'a BodyTemplate,
    planned: Isometry3<f64>,
    movable: Vec<Movable<'a>>,
}

impl Attempt<'_> {
    /// Measures how far the item, or one that it has lifted, may stick out above the rim in the
    /// cell, by how they lie now.
    fn above_rim_m(&self, rim_m: f64) -> f64 {
        let pose = self.world.pose(self.handle).unwrap_or(self.planned);
        let top_m = |pose| self.template.bounds(pose).highest.z;
        let own_doubt_m = match top_m(&self.planned) > rim_m + RIM_TOLERANCE_M {
            true => RIM_TOLERANCE_M + SINKING_DOUBT_M,
            false => 0.0,
        };
        let lifted_tops = self.movable.iter().filter_map(|Movable { handle, lying }| {
            let top_m = lying.template.bounds(&self.world.pose(*handle)?).highest.z;
            let lift_m = top_m - lying.bounds.highest.z;
            (lift_m > LIFTED_M).then_some(top_m + LIFT_DOUBT * lift_m)
        });
        let top_m = lifted_tops.fold(top_m(&pose) + own_doubt_m, f64::max);
        (top_m - rim_m).max(0.0)
    }

    fn settling(&self, still_speed_m_s: f64) -> Settling {
        if self.world.gave_up(self.handle) {
            return GIVEN_UP;
        }
        let pose = self.world.pose(self.handle).unwrap_or(self.planned);
        let centre = self.template.model.mass.centre_of_mass_m;
        let radius_m = self.template.radius_m;
        let speed_m_s = self.world.surface_speed_m_s(self.handle, radius_m);
        let moved_m = |movable: &Movable<'_>| {
            let Movable { handle, lying } = movable;
            if self.world.gave_up(*handle) {
                return Some(f64::INFINITY);
            }
            let pose = self.world.pose(*handle)?;
            let centre = lying.template.model.mass.centre_of_mass_m;
            Some((pose * centre - lying.container_from_item * centre).norm())
        };
        Settling {
            tilt_rad: tilt_rad(&self.planned, &pose),
            slide_m: (pose * centre - self.planned * centre).xy().norm(),
            disturbance_m: self.movable.iter().filter_map(moved_m).fold(0.0, f64::max),
            above_rim_m: 0.0,
            is_still: speed_m_s <= still_speed_m_s,
        }
    }
}
