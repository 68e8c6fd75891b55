//! The simulated cell: items are released into a container, settle, and are scanned.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_catalogue::object::Model;
use ppnpack_numbers::gaussian;
use ppnpack_packing::kernel::grid::{ContainerSize, Grid};
use ppnpack_packing::kernel::heightmap::Surface;
use ppnpack_packing::scene::Scene;
use ppnpack_packing::scene::model::raster::raise_surface;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rapier3d::dynamics::{RigidBodyHandle, RigidBodyType};

use crate::body::{BodyTemplate, Templates};
use crate::container;
use crate::error::PhysicsError;
use crate::outcome::{BodyId, BodyLoad, BodyState, PlacedReport, is_inside, tilt_rad};
use crate::settings::CellSettings;
use crate::surface::SurfaceCache;
use crate::world::World;

/// A planned pose further than this from the container is a mistake, in metres.
const MAX_DISTANCE_M: f64 = 10.0;

/// A simulated container with what was released into it.
///
/// Each cell is independent of every other and uses the calling thread only: for many cells at
/// once, use many threads. A clone continues exactly like its original: it is a state to go back
/// to.
#[derive(Clone)]
pub struct SimulatedCell {
    settings: CellSettings,
    world: World,
    bodies: Vec<Body>,
    next_id: u32,
    templates: Templates,
    surfaces: SurfaceCache,
}

#[derive(Clone)]
struct Body {
    id: BodyId,
    template: Arc<BodyTemplate>,
    handle: RigidBodyHandle,
    /// The pose in which it was laid down, and the same as the engine rounds it: until the body
    /// moves, it is where it was said to be.
    laid: Option<[Isometry3<f64>; 2]>,
}

/// The pose of a body, and its centre of mass.
#[derive(Clone, Copy)]
struct Whereabouts {
    container_from_item: Isometry3<f64>,
    centre_of_mass_m: Point3<f64>,
}

/// A settling phase: its steps, and the bodies that it lost.
#[derive(Default)]
struct Phase {
    steps: usize,
    lost: Vec<(BodyId, Whereabouts)>,
}

impl SimulatedCell {
    /// An empty cell.
    ///
    /// # Errors
    /// [`PhysicsError::Setting`] where a setting is impossible.
    pub fn new(settings: CellSettings) -> Result<Self, PhysicsError> {
        settings.validate()?;
        Ok(Self {
            world: World::new(&settings),
            settings,
            bodies: Vec::new(),
            next_id: 0,
            templates: Templates::default(),
            surfaces: SurfaceCache::default(),
        })
    }

    /// Empties the container, as if the cell were new, but keeps the hulls of the models seen so
    /// far.
    pub fn reset(&mut self) {
        self.world = World::new(&self.settings);
        self.bodies.clear();
        self.next_id = 0;
    }

    /// The container's floor and walls as a mesh in the container frame.
    pub fn container_mesh(&self) -> Mesh {
        container::mesh(&self.settings)
    }

    /// Releases an item above its planned pose, from rest, and lets everything settle.
    ///
    /// An item should be planned where the way down is free: one that is released inside another is
    /// pushed out slowly. On an error nothing has changed.
    ///
    /// # Errors
    /// [`PhysicsError::Model`] where the model has no usable hulls or mass, [`PhysicsError::Pose`]
    /// where the pose is not finite, not rigid or far away.
    pub fn place(
        &mut self,
        model: &Arc<Model>,
        container_from_item: &Isometry3<f64>,
    ) -> Result<PlacedReport, PhysicsError> {
        let planned = checked_pose(self.settings.container, model, container_from_item)?;
        let template = self.templates.of(model)?;
        let before: Vec<(BodyId, Whereabouts)> = self.whereabouts().collect();
        let id = BodyId(self.next_id);
        let released = self.release_pose(id, &planned);
        self.insert(template, &released);
        let phase = self.settle_phase();
        let planned = Whereabouts {
            container_from_item: planned,
            centre_of_mass_m: planned * model.mass.centre_of_mass_m,
        };
        Ok(self.report(id, planned, &before, &phase))
    }

    /// Reports what [`place`](Self::place) would; the cell stays as it is.
    ///
    /// # Errors
    /// As [`place`](Self::place).
    pub fn try_place(
        &mut self,
        model: &Arc<Model>,
        container_from_item: &Isometry3<f64>,
    ) -> Result<PlacedReport, PhysicsError> {
        let mut trial = self.clone();
        let report = trial.place(model, container_from_item);
        // The hulls of a new model were built there.
        self.templates = trial.templates;
        report
    }

    /// Lets everything settle for one more phase; says how long that took, in seconds of simulated
    /// time.
    pub fn settle(&mut self) -> f64 {
        self.settle_phase().steps as f64 * self.settings.solver.timestep_s
    }

    /// Lays bodies down where they are said to be, at rest, in place of all that is there: a cell
    /// goes on where another one ended.
    ///
    /// They are numbered in the order given. Scans and contents are those of the cell that the
    /// poses come from, bit for bit, until the next placement: that wakes them all, as the engine
    /// finds their contacts anew, and they may shift by some hundredths of a millimetre. On an
    /// error nothing has changed.
    ///
    /// # Errors
    /// As [`place`](Self::place).
    pub fn lay_down(
        &mut self,
        bodies: &[(Arc<Model>, Isometry3<f64>)],
    ) -> Result<(), PhysicsError> {
        let container = self.settings.container;
        let checked = bodies.iter().map(|(model, pose)| {
            let engine_pose = checked_pose(container, model, pose)?;
            Ok((self.templates.of(model)?, engine_pose, *pose))
        });
        let checked: Vec<_> = checked.collect::<Result<_, PhysicsError>>()?;
        self.reset();
        for (template, engine_pose, pose) in checked {
            let handle = self.insert(template, &engine_pose);
            self.world.put_to_sleep(handle);
            if let Some((body, rounded)) = self.bodies.last_mut().zip(self.world.pose(handle)) {
                body.laid = Some([pose, rounded]);
            }
        }
        Ok(())
    }

    /// The bodies in the simulation, in the order in which they were placed.
    ///
    /// Bodies that left the container are no longer among them; one that lies on the rim is, and is
    /// not inside.
    pub fn contents(&self) -> Vec<BodyState> {
        let container = self.settings.container;
        let state = |body: &Body| {
            let whereabouts = body.whereabouts(&self.world)?;
            Some(BodyState {
                id: body.id,
                model: Arc::clone(&body.template.model),
                container_from_item: whereabouts.container_from_item,
                inside: is_inside(container, &whereabouts.centre_of_mass_m),
            })
        };
        self.bodies.iter().filter_map(state).collect()
    }

    /// Measures what rests on each body, in the order of [`contents`](Self::contents), as the mean
    /// over a tenth of a second: of what is at rest. The cell stays as it is.
    pub fn loads(&self) -> Vec<BodyLoad> {
        let handles: Vec<_> = self.bodies.iter().map(|body| body.handle).collect();
        let forces = self.world.clone().vertical_forces(&handles);
        let gravity_m_s2 = self.settings.solver.gravity_m_s2;
        let load = |(number, body): (usize, &Body)| BodyLoad {
            id: body.id,
            carried_kg: forces.pressing_n(number) / gravity_m_s2,
            unbalanced_kg: forces.total_n(number) / gravity_m_s2 - body.template.model.mass.mass_kg,
        };
        self.bodies.iter().enumerate().map(load).collect()
    }

    /// Whether every body is at rest: asleep, or slower than the speed at which bodies fall asleep.
    pub fn is_still(&self) -> bool {
        let limit_m_s = self.settings.solver.sleep_speed_m_s;
        let speed_m_s = |body: &Body| {
            self.world
                .surface_speed_m_s(body.handle, body.template.radius_m)
        };
        self.bodies.iter().all(|body| speed_m_s(body) <= limit_m_s)
    }

    /// Measures the deepest that two touching bodies, or a body and the container, reach into each
    /// other, in metres: how far the simulation is from rigid contact. Slow and exact, from the
    /// hulls: a check, not for every step.
    pub fn deepest_overlap_m(&self) -> f64 {
        self.world.deepest_overlap_m()
    }

    /// Scans the surface of the content from above: each sample is the greatest height of the posed
    /// meshes, and of what is taken, within its square; what is outside the grid is left out, and
    /// the floor is at 0.
    ///
    /// Only bodies whose pose changed since the last scan on an equal grid are computed anew.
    ///
    /// # Errors
    /// [`PhysicsError::Grid`] where the grid is of a container of another size.
    pub fn scan_surface(&mut self, grid: &Grid) -> Result<Surface, PhysicsError> {
        let (of_grid, cell) = (grid.container(), self.settings.container);
        if of_grid != cell {
            let grid = of_grid;
            return Err(PhysicsError::Grid { grid, cell });
        }
        let contents = self.contents();
        let mut surface = self.surfaces.scan(grid, &contents);
        for taken in &self.settings.taken {
            raise_surface(&taken.bounds().mesh(), &Isometry3::identity(), &mut surface);
        }
        Ok(surface)
    }

    /// The scene that the next placement is planned on: the surface, and the heightmap from it.
    ///
    /// # Errors
    /// As [`scan_surface`](Self::scan_surface).
    pub fn scan(&mut self, grid: &Grid) -> Result<Scene, PhysicsError> {
        Ok(Scene::from_surface(grid, self.scan_surface(grid)?)?)
    }

    /// Adds a body under the next number.
    fn insert(&mut self, template: Arc<BodyTemplate>, pose: &Isometry3<f64>) -> RigidBodyHandle {
        let handle = self.world.insert(RigidBodyType::Dynamic, &template, pose);
        self.bodies.push(Body {
            id: BodyId(self.next_id),
            handle,
            template,
            laid: None,
        });
        self.next_id += 1;
        handle
    }

    /// Gives the planned pose, raised by the release height and displaced by the jitter.
    ///
    /// The jitter depends on the seed and the body's number alone, so that a placement tried and
    /// rolled back has the same jitter when it is made.
    fn release_pose(&self, id: BodyId, planned: &Isometry3<f64>) -> Isometry3<f64> {
        let release = &self.settings.release;
        let mut released = *planned;
        released.translation.z += release.height_m;
        if release.jitter_m > 0.0 || release.jitter_yaw_rad > 0.0 {
            let mut random = ChaCha8Rng::seed_from_u64(self.settings.seed);
            random.set_stream(u64::from(id.0));
            let mut normal = || gaussian(random.random(), random.random());
            released.translation.x += release.jitter_m * normal();
            released.translation.y += release.jitter_m * normal();
            let yaw_rad = release.jitter_yaw_rad * normal();
            released.rotation =
                UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad) * released.rotation;
        }
        released
    }

    fn settle_phase(&mut self) -> Phase {
        let mut phase = Phase::default();
        for _ in 0..self.settings.settle_steps() {
            if self.world.is_asleep() {
                break;
            }
            self.world.step();
            phase.steps += 1;
            self.remove_lost(&mut phase.lost);
        }
        phase
    }

    /// Takes out the bodies that left the container, and those that the engine gave up on.
    fn remove_lost(&mut self, lost: &mut Vec<(BodyId, Whereabouts)>) {
        let container = self.settings.container;
        let below_m = -self.settings.outcome.lost_margin_m;
        let beyond_m = self.settings.walls.thickness_m + self.settings.outcome.lost_margin_m;
        let left = |point: &Point3<f64>| {
            let is_beyond =
                |value: f64, side_m: f64| !(-beyond_m..=side_m + beyond_m).contains(&value);
            point.z < below_m
                || is_beyond(point.x, container.x_m)
                || is_beyond(point.y, container.y_m)
        };
        let world = &mut self.world;
        self.bodies.retain(|body| match body.whereabouts(world) {
            Some(at) if left(&at.centre_of_mass_m) || world.gave_up(body.handle) => {
                world.remove(body.handle);
                lost.push((body.id, at));
                false
            }
            _ => true,
        });
    }

    fn whereabouts(&self) -> impl Iterator<Item = (BodyId, Whereabouts)> + '_ {
        let bodies = self.bodies.iter();
        bodies.filter_map(|body| Some((body.id, body.whereabouts(&self.world)?)))
    }

    fn report(
        &self,
        id: BodyId,
        planned: Whereabouts,
        before: &[(BodyId, Whereabouts)],
        phase: &Phase,
    ) -> PlacedReport {
        let lost = phase.lost.iter().copied();
        let after: BTreeMap<BodyId, Whereabouts> = self.whereabouts().chain(lost).collect();
        let moved_m = before.iter().filter_map(|(other, before)| {
            let after = after.get(other)?;
            let moved = after.centre_of_mass_m - before.centre_of_mass_m;
            (after.container_from_item != before.container_from_item).then(|| moved.norm())
        });
        let lost = phase.lost.iter().map(|(lost, _)| *lost);
        let (own, others_lost): (Vec<_>, Vec<_>) = lost.partition(|lost| *lost == id);
        let lost = !own.is_empty();

        let end = after.get(&id).copied().unwrap_or(planned);
        let moved = end.centre_of_mass_m - planned.centre_of_mass_m;
        let tilt_rad = tilt_rad(&planned.container_from_item, &end.container_from_item);
        PlacedReport {
            id,
            container_from_item: end.container_from_item,
            slide_m: moved.xy().norm(),
            height_change_m: moved.z,
            tilt_rad,
            toppled: tilt_rad > self.settings.outcome.topple_rad,
            inside: !lost && is_inside(self.settings.container, &end.centre_of_mass_m),
            lost,
            disturbance_m: moved_m.fold(0.0, f64::max),
            others_lost,
            still: self.is_still(),
            simulated_s: phase.steps as f64 * self.settings.solver.timestep_s,
        }
    }
}

impl Body {
    fn whereabouts(&self, world: &World) -> Option<Whereabouts> {
        let pose = world.pose(self.handle)?;
        let container_from_item = match self.laid {
            Some([said, rounded]) if rounded == pose => said,
            _ => pose,
        };
        Some(Whereabouts {
            container_from_item,
            centre_of_mass_m: container_from_item * self.template.model.mass.centre_of_mass_m,
        })
    }
}

/// Makes a pose of a model in a container exactly rigid; refuses one that is not finite, not rigid
/// or far away.
pub(crate) fn checked_pose(
    container: ContainerSize,
    model: &Model,
    container_from_item: &Isometry3<f64>,
) -> Result<Isometry3<f64>, PhysicsError> {
    let refused = |reason| PhysicsError::Pose {
        model: model.name.clone(),
        reason,
    };
    let rotation = container_from_item.rotation.into_inner();
    let translation = container_from_item.translation.vector;
    let mut values = rotation.coords.iter().chain(translation.iter());
    if !values.all(|value| value.is_finite()) {
        return Err(refused("not finite"));
    }
    if (rotation.norm() - 1.0).abs() > 1e-3 {
        return Err(refused("not rigid: its rotation is no unit quaternion"));
    }
    let farthest =
        Vector3::new(container.x_m, container.y_m, container.z_m).add_scalar(MAX_DISTANCE_M);
    let mut limits = translation.iter().zip(farthest.iter());
    if !limits.all(|(value, limit)| (-MAX_DISTANCE_M..=*limit).contains(value)) {
        return Err(refused("more than 10 m away from the container"));
    }
    let rotation = UnitQuaternion::new_normalize(rotation);
    Ok(Isometry3::from_parts(translation.into(), rotation))
}
