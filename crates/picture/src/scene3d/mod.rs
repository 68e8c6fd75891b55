//! Pictures of a container and its items.
//!
//! Surfaces are shaded by where they face, and a line parts what borders on something else. A scene
//! is drawn a few times, each time through a slightly moved camera; the mean has smooth edges.

mod camera;
mod geometry;
mod raster;
mod scene;

use nalgebra::{Point3, Vector3};

pub use camera::Camera;
use geometry::Geometry;
use raster::{Lens, View};
pub use scene::{Item, Scene3d, TriangleMesh};

use crate::colour::Colour;
use crate::error::PictureError;
use crate::image::{Image, Size};

/// How many times a scene is drawn.
const PASSES: usize = 6;

/// Towards the light.
const LIGHT: Vector3<f32> = Vector3::new(-0.62, -0.22, 1.0);

/// The light of what faces away from it and towards it, and the share of it on a line.
const LEAST_LIGHT: f32 = 0.35;
const MOST_LIGHT: f32 = 1.05;
const LINE_LIGHT: f32 = 0.55;

const BACKGROUND: Colour = Colour::hex(0xf1f3f5);

/// Draws a scene. Equal input gives equal pixels.
///
/// # Errors
/// [`PictureError`] where the scene has more than four million triangles or
/// vertices.
pub fn render(scene: &Scene3d<'_>, camera: &Camera, size: Size) -> Result<Image, PictureError> {
    let geometry = Geometry::of(scene)?;
    let shades = shades(&geometry, &camera.eye.map(|value| value as f32));
    let width = size.width() as usize;
    let mut view = View::new(size);
    let mut sums = vec![Vector3::zeros(); size.pixels()];
    for pass in 0..PASSES {
        view.draw(&geometry, &Lens::new(camera, size, pixel_offset(pass)));
        let part = |pixel: usize| {
            let triangle = view.at(pixel);
            triangle.and_then(|triangle| geometry.parts.get(triangle))
        };
        for (pixel, sum) in sums.iter_mut().enumerate() {
            let shade = view.at(pixel).and_then(|triangle| shades.get(triangle));
            let own = part(pixel);
            let after = [pixel + 1, pixel + width];
            let is_line = after.into_iter().any(|next| part(next) != own);
            let light = if is_line { LINE_LIGHT } else { 1.0 };
            *sum += shade.copied().unwrap_or_else(|| channels(BACKGROUND)) * light;
        }
    }
    let pixels = sums.iter().map(|sum| {
        let mean = sum / PASSES as f32;
        Colour::from_channels(mean.map(|channel: f32| channel.round() as u8))
    });
    Ok(Image::from_pixels(size, pixels))
}

fn channels(colour: Colour) -> Vector3<f32> {
    Vector3::new(colour.red, colour.green, colour.blue).map(f32::from)
}

/// Gives the colour of each triangle. The side that is seen has the light, whichever way it winds.
fn shades(geometry: &Geometry, eye: &Point3<f32>) -> Vec<Vector3<f32>> {
    let towards_light = LIGHT.normalize();
    let triangles = geometry.triangles.iter().zip(&geometry.parts);
    let shade = |(corners, part): (&[u32; 3], &u32)| {
        let corner = |index: u32| geometry.vertices.get(index as usize).copied();
        let [a, b, c] = corners.map(|index| corner(index).unwrap_or_default());
        let area = (b - a).cross(&(c - a));
        let seen = if area.dot(&(a - eye)) > 0.0 {
            -area
        } else {
            area
        };
        let normal = seen.try_normalize(0.0).unwrap_or_else(Vector3::z);
        // Sides that are turned away differ, too.
        let slant = 0.5 + 0.5 * normal.dot(&towards_light);
        let colour = geometry.colours.get(*part as usize).copied();
        channels(colour.unwrap_or(BACKGROUND)) * (LEAST_LIGHT + (MOST_LIGHT - LEAST_LIGHT) * slant)
    };
    triangles.map(shade).collect()
}

/// Gives the offset from a pixel's centre in a pass: an even spread in both directions (the R2
/// sequence).
fn pixel_offset(pass: usize) -> [f32; 2] {
    [0.754_877_7, 0.569_840_3].map(|step: f32| (0.5 + pass as f32 * step).fract() - 0.5)
}
