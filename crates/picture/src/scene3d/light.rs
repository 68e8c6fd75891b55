//! The light of a scene: a soft key light, an overcast sky, a weak fill light and what the ground returns.

use nalgebra::{Point3, Vector3};

use super::geometry::{Geometry, Material};
use super::raster::ShadowMap;

/// How many times a scene is drawn. Fewer show in the shadows, more hardly help.
pub(super) const PASSES: usize = 6;

/// How many directions of the sky each pass looks at.
const SKY_PER_PASS: usize = 3;

/// The sine of the lowest height of the sky that gives light: from further down it would throw very long shadows.
const LOWEST_SKY: f32 = 0.12;

/// Towards the middle of the key light.
const KEY: Vector3<f32> = Vector3::new(-0.62, -0.22, 1.0);

/// How far the key light's edge is from its middle, as a slope: the softness of its shadows.
const KEY_RADIUS: f32 = 0.075;

/// Towards the fill light, which casts no shadows: on the right of the usual view.
const FILL: Vector3<f32> = Vector3::new(0.75, -0.60, 0.25);

/// Irradiances, in units of what makes a white surface white.
const KEY_STRENGTH: f32 = 0.66;
const SKY_STRENGTH: f32 = 0.56;
const FILL_STRENGTH: f32 = 0.10;
const BOUNCE_STRENGTH: f32 = 0.20;

/// The turn between neighbours that spreads points evenly over a disc or a sphere, in radians.
const GOLDEN_ANGLE_RAD: f32 = 2.399_963_2;

/// A point of a surface as light finds it.
pub(super) struct Surface {
    pub(super) point: Point3<f32>,
    /// Of unit length, on the viewer's side.
    pub(super) normal: Vector3<f32>,
    /// Of unit length.
    pub(super) towards_eye: Vector3<f32>,
    pub(super) material: Material,
}

/// The lights of one pass, with their shadows. Every pass samples one point of the key light and a few directions of
/// the sky; together the passes cover both.
pub(super) struct Lights {
    key: Lamp,
    sky: [Lamp; SKY_PER_PASS],
    fill: Vector3<f32>,
    /// How far apart a shadow is looked up around a point, in metres.
    spread_m: f32,
}

struct Lamp {
    towards: Vector3<f32>,
    shadow: ShadowMap,
}

impl Lights {
    /// Lights whose shadows are worked out on maps of `side` x `side` texels for the key light; the sky's shadows are
    /// soft and need a third as many.
    pub(super) fn new(side: usize) -> Self {
        let lamp = |side| Lamp {
            towards: Vector3::z(),
            shadow: ShadowMap::new(side),
        };
        Self {
            key: lamp(side),
            sky: std::array::from_fn(|_| lamp(side.div_ceil(3))),
            fill: FILL.normalize(),
            spread_m: 0.0,
        }
    }

    /// Moves the lights to their places of a pass and works out their shadows.
    pub(super) fn aim(&mut self, geometry: &Geometry, pass: usize) {
        self.spread_m = 0.012 * geometry.focus.1;

        let across = KEY.cross(&Vector3::z()).normalize();
        let along = across.cross(&KEY.normalize());
        let distance = ((pass as f32 + 0.5) / PASSES as f32).sqrt() * KEY_RADIUS;
        let (sine, cosine) = (pass as f32 * GOLDEN_ANGLE_RAD).sin_cos();
        self.key.aim(
            geometry,
            KEY.normalize() + (across * cosine + along * sine) * distance,
        );

        for (number, lamp) in self.sky.iter_mut().enumerate() {
            // A spiral from the horizon to the zenith; each pass takes directions from all heights.
            let index = (number * PASSES + pass) as f32;
            let height =
                LOWEST_SKY + (1.0 - LOWEST_SKY) * (index + 0.5) / (SKY_PER_PASS * PASSES) as f32;
            let (sine, cosine) = (index * GOLDEN_ANGLE_RAD).sin_cos();
            let reach = (1.0 - height * height).sqrt();
            lamp.aim(geometry, Vector3::new(reach * cosine, reach * sine, height));
        }
    }

    /// The light that a surface sends to the eye, per channel; `spin` (cosine and sine) varies where shadows are looked
    /// up between neighbouring pixels.
    #[inline]
    pub(super) fn shade(&self, surface: &Surface, spin: [f32; 2]) -> Vector3<f32> {
        let Surface {
            point,
            normal,
            towards_eye,
            material,
        } = surface;
        let key_slant = normal.dot(&self.key.towards);
        let key = if key_slant > 0.0 {
            self.key
                .shadow
                .visibility(point, normal, spin, 0.3 * self.spread_m)
        } else {
            0.0
        };
        let sky = self.sky_irradiance(point, normal, spin, self.spread_m);
        let bounce = BOUNCE_STRENGTH * (0.5 - 0.5 * normal.z);
        // Where little of the sky is seen, little of the other large lights is.
        let openness = (0.35 + 1.3 * sky.sum()).min(1.0);
        let fill = FILL_STRENGTH * normal.dot(&self.fill).max(0.0) * openness;

        let white = Vector3::repeat(1.0);
        let irradiance = Vector3::new(1.0, 0.97, 0.92) * (KEY_STRENGTH * key * key_slant.max(0.0))
            + sky
            + white * fill
            + Vector3::new(1.0, 0.98, 0.95) * (bounce * openness);

        let halfway = (self.key.towards + towards_eye)
            .try_normalize(0.0)
            .unwrap_or(*normal);
        let highlight = 0.10 * key * normal.dot(&halfway).max(0.0).powi(36);
        let grazing = (1.0 - normal.dot(towards_eye).clamp(0.0, 1.0)).powi(4);
        let sheen = 0.16 * grazing * openness * sky.y;
        material.albedo.component_mul(&irradiance) + white * (material.gloss * (highlight + sheen))
    }

    /// The share of light that the ground still gets at a point, 1 where nothing shades it. Shadows there are softer than
    /// on items: nothing else hides where they end.
    #[inline]
    pub(super) fn on_ground(&self, point: &Point3<f32>, spin: [f32; 2]) -> f32 {
        let up = Vector3::z();
        let key = KEY_STRENGTH * self.key.towards.z;
        let open: Vector3<f32> = self.sky.iter().map(|lamp| sky_light(lamp, &up)).sum();
        let lit = key
            * self
                .key
                .shadow
                .visibility(point, &up, spin, 1.2 * self.spread_m)
            + self.sky_irradiance(point, &up, spin, 6.0 * self.spread_m).y;
        lit / (key + open.y)
    }

    #[inline]
    fn sky_irradiance(
        &self,
        point: &Point3<f32>,
        normal: &Vector3<f32>,
        spin: [f32; 2],
        spread_m: f32,
    ) -> Vector3<f32> {
        let mut irradiance = Vector3::zeros();
        for lamp in &self.sky {
            let light = sky_light(lamp, normal);
            if light.y > 0.0 {
                irradiance += light * lamp.shadow.visibility(point, normal, spin, spread_m);
            }
        }
        irradiance
    }
}

impl Lamp {
    fn aim(&mut self, geometry: &Geometry, towards: Vector3<f32>) {
        self.towards = towards.normalize();
        self.shadow.draw(geometry, &self.towards);
    }
}

/// The light of one direction of the sky on a surface that sees it: brighter and cooler towards the zenith.
#[inline]
fn sky_light(lamp: &Lamp, normal: &Vector3<f32>) -> Vector3<f32> {
    let slant = normal.dot(&lamp.towards).max(0.0) * 2.0 / SKY_PER_PASS as f32;
    let horizon = Vector3::new(0.88, 0.87, 0.86);
    let zenith = Vector3::new(1.03, 1.06, 1.10);
    (horizon + (zenith - horizon) * lamp.towards.z) * (slant * SKY_STRENGTH)
}
