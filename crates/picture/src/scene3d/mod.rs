//! Pictures of a container and its items.
//!
//! A software renderer in the manner of an accumulation buffer (Haeberli and Akeley 1990): it draws the scene a few
//! times, plainly, each time through a slightly moved camera and under another sample of the light, and averages. Smooth
//! edges, soft shadows and the darkening of crevices all come from that average.

mod camera;
mod geometry;
mod glass;
mod light;
mod normals;
mod raster;
mod scene;

use nalgebra::Vector3;

pub use camera::Camera;
use geometry::Geometry;
use glass::Glass;
use light::{Lights, PASSES, Surface};
use raster::{Lens, View};
pub use scene::{Item, Scene3d, TriangleMesh};

use crate::colour::SrgbTable;
use crate::error::PictureError;
use crate::image::{Image, Size};

/// Draws a scene. Equal input gives equal pixels.
///
/// # Errors
/// [`PictureError::SceneTooLarge`] where the scene has more than four million triangles or vertices.
pub fn render(scene: &Scene3d<'_>, camera: &Camera, size: Size) -> Result<Image, PictureError> {
    let geometry = Geometry::of(scene)?;
    let glass = geometry.container_m.map(Glass::new);
    // Small pictures need less sharp shadows.
    let shadow_side = size.width().max(size.height()).clamp(256, 1_024) as usize;
    let mut lights = Lights::new(shadow_side);
    let mut view = View::new(size);
    let spins = Spins::new();
    let mut sums = vec![Vector3::zeros(); size.pixels()];

    for pass in 0..PASSES {
        let lens = Lens::new(camera, size, pixel_offset(pass));
        view.draw(&geometry, &lens);
        lights.aim(&geometry, pass);
        let shader = Shader {
            geometry: &geometry,
            lights: &lights,
            lens: &lens,
            size,
        };
        for (row, line) in sums.chunks_exact_mut(size.width() as usize).enumerate() {
            let first = row * size.width() as usize;
            for (column, sum) in line.iter_mut().enumerate() {
                let spin = spins.at(column, row, pass);
                let seen = view.at(first + column);
                let ray = lens.ray(column, row);
                let (light, depth) = match seen {
                    Some((triangle, depth)) => (shader.surface(triangle, &ray, depth, spin), depth),
                    None => (shader.background(column, row, &ray, spin), f32::INFINITY),
                };
                *sum += match &glass {
                    Some(glass) => glass.over(light, &lens.eye, &ray, depth),
                    None => light,
                };
            }
        }
    }

    let table = SrgbTable::new();
    let pixels = sums
        .iter()
        .map(|sum| table.colour((sum / PASSES as f32).map(softened)));
    Ok(Image::from_pixels(size, pixels))
}

/// What one pass needs to tell the light of a pixel.
struct Shader<'a> {
    geometry: &'a Geometry,
    lights: &'a Lights,
    lens: &'a Lens,
    size: Size,
}

impl Shader<'_> {
    /// The light from a triangle, hit at a depth in metres.
    #[inline]
    fn surface(
        &self,
        triangle: usize,
        ray: &Vector3<f32>,
        depth: f32,
        spin: [f32; 2],
    ) -> Vector3<f32> {
        let Geometry {
            vertices,
            triangles,
            finishes,
            materials,
            ..
        } = self.geometry;
        let (Some(corners), Some(finish)) = (triangles.get(triangle), finishes.get(triangle))
        else {
            return Vector3::zeros();
        };
        let Some(material) = materials.get(finish.material as usize) else {
            return Vector3::zeros();
        };
        let [a, b, c] =
            corners.map(|corner| vertices.get(corner as usize).copied().unwrap_or_default());
        let point = self.lens.eye + ray * depth;
        let area = (b - a).cross(&(c - a));
        let scale = 1.0 / area.norm_squared().max(f32::MIN_POSITIVE);
        // A pixel's centre is within the triangle but for rounding.
        let b_share = ((point - a).cross(&(c - a)).dot(&area) * scale).clamp(0.0, 1.0);
        let c_share = ((b - a).cross(&(point - a)).dot(&area) * scale).clamp(0.0, 1.0);
        let [at_a, at_b, at_c] = finish.normals;
        let normal = at_a * (1.0 - b_share - c_share) + at_b * b_share + at_c * c_share;
        let normal = normal.try_normalize(0.0).unwrap_or(at_a);
        // Light the side that is seen, whichever way the triangle winds.
        let faces_away = area.dot(ray) > 0.0;
        let surface = Surface {
            point,
            normal: if faces_away { -normal } else { normal },
            towards_eye: -ray.normalize(),
            material: *material,
        };
        self.lights.shade(&surface, spin)
    }

    /// The light backdrop, with the shadows on the ground.
    #[inline]
    fn background(
        &self,
        column: usize,
        row: usize,
        ray: &Vector3<f32>,
        spin: [f32; 2],
    ) -> Vector3<f32> {
        let (width, height) = (self.size.width() as f32, self.size.height() as f32);
        let (x, y) = (column as f32 / width - 0.5, row as f32 / height - 0.45);
        let share = ((x * x + y * y) * 1.7).min(1.0);
        let (middle, edge) = (
            Vector3::new(0.95, 0.955, 0.96),
            Vector3::new(0.66, 0.69, 0.73),
        );
        let backdrop = middle + (edge - middle) * share;

        let depth = (self.geometry.ground_m - self.lens.eye.z) / ray.z;
        let point = self.lens.eye + ray * depth;
        let (focus, radius) = self.geometry.focus;
        // Further away than this nothing throws a shadow; the comparisons also fail above the horizon.
        if depth > 0.0 && (point - focus).norm_squared() < 9.0 * radius * radius {
            backdrop * self.lights.on_ground(&point, spin)
        } else {
            backdrop
        }
    }
}

/// Where in the pixel a pass looks, as an offset from its centre: an even spread in both directions (the R2 sequence).
fn pixel_offset(pass: usize) -> [f32; 2] {
    [0.754_877_7, 0.569_840_3].map(|step: f32| (0.5 + pass as f32 * step).fract() - 0.5)
}

/// Directions (cosine and sine) that differ between neighbouring pixels and between passes: they turn the steps of
/// sampled shadows into fine grain, which the average over the passes removes.
struct Spins([[f32; 2]; Spins::COUNT]);

impl Spins {
    const COUNT: usize = 128;

    fn new() -> Self {
        Self(std::array::from_fn(|index| {
            let turn = index as f32 / Self::COUNT as f32;
            let (sine, cosine) = (turn * std::f32::consts::TAU).sin_cos();
            [cosine, sine]
        }))
    }

    /// By interleaved gradient noise (Jimenez 2014) and, over the passes, the golden ratio.
    #[inline]
    fn at(&self, column: usize, row: usize, pass: usize) -> [f32; 2] {
        // All terms are positive, so that the cast cuts off the fraction.
        let fraction = |value: f32| value - value as i32 as f32;
        let slant = fraction(0.067_110_56 * column as f32 + 0.005_837_15 * row as f32);
        let turn = fraction(52.982_918 * slant) + pass as f32 * 0.618_034;
        let index = (turn * Self::COUNT as f32) as usize % Self::COUNT;
        self.0.get(index).copied().unwrap_or([1.0, 0.0])
    }
}

/// Bends the brightest light into the displayable range instead of cutting it off.
fn softened(light: f32) -> f32 {
    const KNEE: f32 = 0.75;
    if light <= KNEE {
        light
    } else {
        let room = 1.0 - KNEE;
        KNEE + room * (1.0 - (-(light - KNEE) / room).exp())
    }
}
