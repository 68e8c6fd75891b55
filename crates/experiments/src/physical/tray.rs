//! The simulated tray: objects as they come to lie there, and a depth camera above.

use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::{Isometry3, Point2, Point3, Translation3, UnitQuaternion, Vector3};
use ppnpack_camera::{Body, DepthCamera, Intrinsics, NoiseModel};
use ppnpack_catalogue::mesh::{Bounds, Mesh};
use ppnpack_catalogue::object::Model;
use ppnpack_perception_service::TraySettings;
use ppnpack_recognition::recognise::RecognitionSettings;
use ppnpack_recognition::segmentation::{Region, SegmentationSettings};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use ppnpack_cli::failure::{OrRun, Outcome};

/// Region of the tray that the camera sees, in the container frame, within the arm's reach.
pub(super) const REGION: Region = Region {
    lowest_m: Point3::new(-0.36, -0.70, -0.04),
    highest_m: Point3::new(0.40, -0.06, 0.35),
};

/// The height of the tray in the container frame, in metres.
pub(super) const HEIGHT_M: f64 = -0.01;

/// Middles of objects lie within this, in metres.
const PLACES_M: [[f64; 2]; 2] = [[-0.18, -0.46], [0.20, -0.24]];

/// The least gap between the circles around two objects, in metres.
const GAP_M: f64 = 0.02;

/// Position of the camera, in metres.
const EYE_M: Point3<f64> = Point3::new(0.02, -0.38, 0.95);

/// Places that are tried for an object.
const TRIALS: usize = 400;

pub(super) fn settings() -> TraySettings {
    TraySettings {
        segmentation: SegmentationSettings::of(REGION),
        recognition: RecognitionSettings::default(),
    }
}

#[derive(Debug, Clone)]
pub(super) struct Lying {
    pub(super) arrival: usize,
    pub(super) model: Arc<Model>,
    pub(super) container_from_object: Isometry3<f64>,
    /// The circle around it, seen from above.
    middle_m: Point2<f64>,
    radius_m: f64,
}

impl Lying {
    /// Gives its centre of mass seen from above, in metres.
    pub(super) fn centre_m(&self) -> Point2<f64> {
        (self.container_from_object * self.model.mass.centre_of_mass_m).xy()
    }
}

pub(super) struct Tray {
    pub(super) lying: Vec<Lying>,
    random: ChaCha8Rng,
    plate: Mesh,
    camera: DepthCamera,
}

impl Tray {
    pub(super) fn new(seed: u64) -> Outcome<Self> {
        let intrinsics = Intrinsics::centred(640, 480, 600.0).or_run()?;
        Ok(Self {
            lying: Vec::new(),
            random: ChaCha8Rng::seed_from_u64(seed),
            plate: Mesh::cuboid([-0.7, -1.0, HEIGHT_M - 0.02], [0.7, -0.025, HEIGHT_M]),
            camera: DepthCamera::looking_down(intrinsics, EYE_M),
        })
    }

    /// Lays an object down in a resting pose, where there is room; says whether there was.
    pub(super) fn lay(&mut self, arrival: usize, model: &Arc<Model>) -> bool {
        for _ in 0..TRIALS {
            let object = self.tossed(arrival, model);
            let is_apart = |other: &Lying| {
                let distance_m = (other.middle_m - object.middle_m).norm();
                distance_m >= other.radius_m + object.radius_m + GAP_M
            };
            if self.lying.iter().all(is_apart) {
                self.lying.push(object);
                return true;
            }
        }
        false
    }

    pub(super) fn take(&mut self, arrival: usize) {
        self.lying.retain(|object| object.arrival != arrival);
    }

    /// An object at a random place, in a resting pose drawn by its probability, at a random yaw.
    fn tossed(&mut self, arrival: usize, model: &Arc<Model>) -> Lying {
        let mut draw: f64 = self.random.random();
        let resting = model.resting_poses.iter().find(|pose| {
            draw -= pose.probability;
            draw <= 0.0
        });
        let resting = resting.or(model.resting_poses.first());
        let resting = resting.map_or_else(UnitQuaternion::identity, |pose| pose.rotation);
        let turn = between(&mut self.random, 0.0, TAU);
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn);
        let rotation = turn * resting;
        let turned = model.mesh.transformed(&nalgebra::convert(rotation));
        let bounds = turned.bounds().unwrap_or(Bounds {
            lowest: Point3::origin(),
            highest: Point3::origin(),
        });
        let [[x_low, y_low], [x_high, y_high]] = PLACES_M;
        let middle_m = Point2::new(
            between(&mut self.random, x_low, x_high),
            between(&mut self.random, y_low, y_high),
        );
        let middle = nalgebra::center(&bounds.lowest, &bounds.highest).xy();
        let shift = Translation3::new(
            middle_m.x - middle.x,
            middle_m.y - middle.y,
            HEIGHT_M - bounds.lowest.z,
        );
        let from_middle = |vertex: &Point3<f64>| (vertex.xy() - middle).norm();
        Lying {
            arrival,
            model: Arc::clone(model),
            container_from_object: shift * rotation,
            middle_m,
            radius_m: turned.vertices.iter().map(from_middle).fold(0.0, f64::max),
        }
    }

    pub(super) fn container_from_camera(&self) -> Isometry3<f64> {
        self.camera.world_from_camera
    }

    /// Sees the tray: points in the camera's frame, in metres.
    pub(super) fn view(&mut self) -> Outcome<Vec<Point3<f32>>> {
        let mut bodies = vec![body(&self.plate, Isometry3::identity())];
        let lying = self.lying.iter();
        bodies.extend(lying.map(|it| body(&it.model.mesh, it.container_from_object)));
        let seed = self.random.random();
        let points = self.camera.see(&bodies, &NoiseModel::default(), seed);
        points.or_run()
    }
}

fn body(mesh: &Mesh, world_from_body: Isometry3<f64>) -> Body<'_> {
    Body {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
        world_from_body,
    }
}

fn between(random: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * random.random::<f64>()
}

#[cfg(test)]
mod tests {
    use ppnpack_catalogue::build::{ModelSettings, model};

    use super::*;

    fn brick() -> Arc<Model> {
        let mesh = Mesh::cuboid([-0.05, -0.03, -0.02], [0.05, 0.03, 0.02]);
        let (model, _) = model("brick", mesh, &ModelSettings::default()).unwrap();
        Arc::new(model)
    }

    #[test]
    fn objects_lie_apart_on_the_tray_and_are_seen() {
        let mut tray = Tray::new(3).unwrap();
        assert!(tray.lay(0, &brick()) && tray.lay(1, &brick()));
        for object in &tray.lying {
            let mesh = &object.model.mesh;
            let standing = mesh.transformed(&object.container_from_object);
            let standing = standing.bounds().unwrap();
            assert!((standing.lowest.z - HEIGHT_M).abs() < 1e-9);
            assert!(REGION.contains(&standing.lowest) && REGION.contains(&standing.highest));
        }
        let points = tray.view().unwrap();
        let above = |point: &&Point3<f32>| {
            (tray.container_from_camera() * point.cast::<f64>()).z > HEIGHT_M + 0.02
        };
        assert!(points.iter().filter(above).count() > 1000);
        tray.take(0);
        assert_eq!(tray.lying.len(), 1);
    }
}
