//! The camera and the bodies before it.

use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use ppnpack_numbers::require;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::buffer::DepthBuffer;
use crate::error::CameraError;
use crate::intrinsics::Intrinsics;
use crate::noise::NoiseModel;

/// Maximum of triangles of a scene.
const MAX_TRIANGLES: usize = 1 << 26;

/// A triangle mesh and its pose. Both sides of its triangles are seen.
#[derive(Debug, Clone, Copy)]
pub struct Body<'mesh> {
    /// Vertex positions in the body's own frame, in metres.
    pub vertices: &'mesh [Point3<f64>],
    /// Vertex indices per triangle.
    pub triangles: &'mesh [[u32; 3]],
    /// The body's frame in the world.
    pub world_from_body: Isometry3<f64>,
}

/// A pinhole depth camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DepthCamera {
    /// The projection of points to pixels.
    pub intrinsics: Intrinsics,
    /// The camera's optical frame (x right, y down, z forward) in the world.
    pub world_from_camera: Isometry3<f64>,
    /// The least distance along z that is seen, in metres.
    pub near_m: f64,
    /// The greatest distance along z that is seen, in metres.
    pub far_m: f64,
}

impl DepthCamera {
    /// Makes a camera with the usual range of such sensors, 0.1 to 10 m.
    pub fn new(intrinsics: Intrinsics, world_from_camera: Isometry3<f64>) -> Self {
        Self {
            intrinsics,
            world_from_camera,
            near_m: 0.1,
            far_m: 10.0,
        }
    }

    /// Makes a camera at a point that looks straight down. Columns run along the world's x, rows
    /// against its y.
    pub fn looking_down(intrinsics: Intrinsics, at: Point3<f64>) -> Self {
        let half_turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        let pose = Isometry3::from_parts(Translation3::from(at), half_turn);
        Self::new(intrinsics, pose)
    }

    /// Makes a camera at a point that looks at another, upright: the world's z points up in the
    /// image. Straight down, it is [`looking_down`](Self::looking_down).
    pub fn looking_at(intrinsics: Intrinsics, at: Point3<f64>, target: &Point3<f64>) -> Self {
        let forward = (target - at).try_normalize(1e-12);
        let axes = forward.and_then(|forward| {
            let right = forward.cross(&Vector3::z()).try_normalize(1e-6)?;
            let down = forward.cross(&right);
            Some(Rotation3::from_basis_unchecked(&[right, down, forward]))
        });
        let Some(axes) = axes else {
            return Self::looking_down(intrinsics, at);
        };
        let rotation = UnitQuaternion::from_rotation_matrix(&axes);
        Self::new(
            intrinsics,
            Isometry3::from_parts(Translation3::from(at), rotation),
        )
    }

    /// Checks that every number is possible.
    ///
    /// # Errors
    /// [`CameraError`] for the first that is not.
    pub fn validate(&self) -> Result<(), CameraError> {
        self.intrinsics.validate()?;
        require("near_m", self.near_m, "more than 0 m", |near| near > 0.0)?;
        let is_beyond = |far| far > self.near_m;
        require("far_m", self.far_m, "more than near_m", is_beyond)?;
        let rotation = self.world_from_camera.rotation.into_inner();
        let translation = self.world_from_camera.translation.vector;
        let is_rigid = (rotation.norm() - 1.0).abs() <= 1e-3;
        let is_finite = translation.iter().all(|value| value.is_finite());
        (is_rigid && is_finite)
            .then_some(())
            .ok_or(CameraError::Pose)
    }

    /// Measures the points of bodies with this noise, in the camera frame in metres, row by row;
    /// NaN in all three coordinates where nothing is measured. Equal seeds give equal noise.
    ///
    /// # Errors
    /// As [`validate`](Self::validate), [`CameraError::Setting`] where the noise is impossible, and
    /// [`CameraError::SceneTooLarge`].
    pub fn see(
        &self,
        bodies: &[Body<'_>],
        noise: &NoiseModel,
        seed: u64,
    ) -> Result<Vec<Point3<f32>>, CameraError> {
        noise.validate()?;
        self.validate()?;
        let triangles: usize = bodies.iter().map(|body| body.triangles.len()).sum();
        let limit = MAX_TRIANGLES;
        if triangles > limit {
            return Err(CameraError::SceneTooLarge { limit });
        }
        let camera_from_world = self.world_from_camera.inverse();
        let mut buffer = DepthBuffer::default();
        buffer.clear(&self.intrinsics);
        for body in bodies {
            let pose = camera_from_world * body.world_from_body;
            let (vertices, triangles) = (body.vertices, body.triangles);
            buffer.draw(&self.intrinsics, self.near_m, &pose, vertices, triangles);
        }
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let points = (0..self.intrinsics.pixels()).map(|pixel| {
            let (width, depth_m) = (self.intrinsics.width, buffer.depth_m(pixel));
            let depth_m = depth_m.filter(|depth_m| *depth_m <= self.far_m as f32);
            let (u, v) = ((pixel % width) as f64, (pixel / width) as f64);
            let ray = self.intrinsics.ray(u, v);
            let depth_m = f64::from(depth_m.unwrap_or(f32::NAN));
            let measured_m = noise.measure(depth_m, ray.norm(), &mut random);
            match measured_m.is_nan() {
                true => Point3::new(f32::NAN, f32::NAN, f32::NAN),
                false => Point3::from(ray * measured_m).cast(),
            }
        });
        Ok(points.collect())
    }

    /// Gives the points that were measured, in the world, in metres.
    pub fn in_world_m(&self, points_m: &[Point3<f32>]) -> impl Iterator<Item = Point3<f64>> {
        let rotation = self.world_from_camera.rotation.to_rotation_matrix();
        let translation = self.world_from_camera.translation.vector;
        let measured = points_m.iter().filter(|point| !point.z.is_nan());
        measured.map(move |point| rotation * point.cast::<f64>() + translation)
    }
}
