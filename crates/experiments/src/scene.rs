//! What simulated scenes are made of: objects, how they lie, what a camera sees of them.

use std::f64::consts::TAU;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use ppnpack_camera::{Body, DepthCamera, NoiseModel, PointImage};
use ppnpack_catalogue::catalogue::{Catalogue, Settings, Source};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_cli::failure::{OrInput, OrRun, Outcome};
use ppnpack_cli::options::load;
use ppnpack_packing::grid::{ContainerSize, Grid, GridSettings, Resolution};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// The objects of a source, at the reference's resolution.
pub(crate) fn objects(source: &Source) -> Outcome<Catalogue> {
    load(source, &Settings::default(), &Resolution::reference())
}

pub(crate) fn grid(container: ContainerSize, cell_m: f64, yaws: usize) -> Outcome<Grid> {
    let settings = GridSettings {
        container,
        cell_m,
        yaws,
        ..GridSettings::default()
    };
    settings.build().or_input()
}

/// A mesh that lies in the world.
pub(crate) fn body(mesh: &Mesh, world_from_body: Isometry3<f64>) -> Body<'_> {
    Body {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
        world_from_body,
    }
}

/// What a depth camera sees of some bodies, with noise.
pub(crate) fn seen(
    camera: &DepthCamera,
    bodies: &[Body<'_>],
    noise: &NoiseModel,
    seed: u64,
) -> Outcome<PointImage> {
    let view = camera.see(bodies).or_run()?;
    view.noisy_points(noise, seed).or_run()
}

/// A turn about the vertical by any angle.
pub(crate) fn any_turn(random: &mut ChaCha8Rng) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::z_axis(), between(random, 0.0, TAU))
}

/// A random number of an interval.
pub(crate) fn between(random: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * random.random::<f64>()
}
