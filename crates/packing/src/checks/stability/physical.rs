//! The physical stability test.

use ppnpack_numbers::settings;
use pulp::{Arch, Simd, WithSimd};

use crate::checks::check::{Condition, Cost, Question};
use crate::kernel::grid::{ABSENT, Grid, Units};
use crate::kernel::item::ItemView;
use crate::kernel::placement::RestingPlacement;
use crate::kernel::polygon::SupportPolygon;
use crate::ranking::refusal::Cause;
use crate::ranking::step::StepInput;
use crate::scene::Scene;

/// Samples compared at once along y.
const LANES: usize = 8;

settings! {
    /// Settings of the physical stability test.
    #[derive(Copy)]
    pub struct PhysicalStabilitySettings {
        /// Surfaces closer than this when the item has come to rest are in contact, in metres.
        pub contact_tolerance_m: f64 = 0.002,
        /// The centre of mass must lie at least this far inside the support polygon, in metres.
        pub margin_m: f64 = 0.002,
    }
}

/// A stability test on the real surfaces: in metres, with margins that do not depend on the cell.
///
/// The item is lowered onto what was seen of the content until it touches; contact is where its
/// underside is then within the tolerance, and its true centre of mass must lie inside the
/// contacts' hull. Where no fine surface or underside is known, cells' heights take their place.
#[derive(Debug, Clone)]
pub struct PhysicalStability {
    settings: PhysicalStabilitySettings,
    arch: Arch,
    /// Per row of samples: reach of the content above the underside as it is let down, in metres.
    overlaps_m: Vec<f32>,
    polygon: SupportPolygon,
}

impl PhysicalStability {
    /// The test with these settings.
    pub fn new(settings: PhysicalStabilitySettings) -> Self {
        Self {
            settings,
            arch: Arch::new(),
            overlaps_m: Vec::new(),
            polygon: SupportPolygon::default(),
        }
    }

    /// Whether a view at a placement is stable.
    pub fn is_stable(
        &mut self,
        grid: &Grid,
        scene: &Scene,
        view: &ItemView,
        resting: &RestingPlacement,
    ) -> bool {
        self.depth_m(grid, scene, view, resting) >= self.settings.margin_m
    }

    /// How far the centre of mass lies inside the support polygon, in metres; negative outside.
    pub fn depth_m(
        &mut self,
        grid: &Grid,
        scene: &Scene,
        view: &ItemView,
        resting: &RestingPlacement,
    ) -> f64 {
        let (x, y) = (resting.placement.x, resting.placement.y);
        let resolution = grid.resolution();
        let samples = resolution.samples_per_cell();
        let underside = view
            .underside()
            .filter(|known| known.samples_per_cell == samples);
        if let (Some(surface), Some(underside)) = (scene.surface(), underside) {
            let (nx, ny) = (underside.nx, underside.ny);
            let lowering = Lowering {
                content: Rows::of(
                    surface.support_m(),
                    surface.ny(),
                    (x * samples, y * samples),
                    ny,
                ),
                underside: Rows::of(&underside.heights_m, ny, (0, 0), ny),
                overlap_m: |below: f32, lower: f32| below - lower,
            };
            self.find_contacts(nx, resolution.surface_pitch_m(), lowering);
        } else {
            let (heightmap, ny) = (scene.heightmap(), view.ny());
            let unit_m = resolution.height_unit_m() as f32;
            let lowering = Lowering {
                content: Rows::of(heightmap.heights(), heightmap.ny(), (x, y), ny),
                underside: Rows::of(view.bottom(), ny, (0, 0), ny),
                overlap_m: |below: Units, bottom: Units| match bottom {
                    ABSENT => f32::NEG_INFINITY,
                    bottom => f32::from(below) * unit_m - f32::from(bottom) * unit_m,
                },
            };
            self.find_contacts(view.nx(), resolution.cell_m(), lowering);
        }
        self.polygon
            .depth(view.centre_of_mass_m(resolution.cell_m()))
    }

    /// Lowers the underside, of `nx` rows, onto the content; collects contacts `pitch_m` apart.
    fn find_contacts<B, L, F>(&mut self, nx: usize, pitch_m: f64, lowering: Lowering<'_, B, L, F>)
    where
        B: Copy,
        L: Copy,
        F: Fn(B, L) -> f32 + Copy,
    {
        self.overlaps_m.clear();
        // The floor is content too, at height 0, which the surface never lies below.
        self.overlaps_m.resize(nx, 0.0);
        let overlaps_m = self.overlaps_m.as_mut_slice();
        self.arch.dispatch(LowerRows {
            lowering,
            overlaps_m,
        });
        let resting_m = self.overlaps_m.iter().copied().fold(0.0, f32::max);
        let touching = resting_m - self.settings.contact_tolerance_m as f32;
        self.polygon.clear();
        for (x, highest) in self.overlaps_m.iter().enumerate() {
            if *highest >= touching {
                let are_contacts = lowering.row(x).map(|overlap| overlap >= touching);
                self.polygon.add_row(x, are_contacts, pitch_m);
            }
        }
    }
}

/// An underside over the content below it, as deep as the floor.
#[derive(Clone, Copy)]
struct Lowering<'a, B, L, F> {
    content: Rows<'a, B>,
    underside: Rows<'a, L>,
    /// Reach of content above the underside, in metres; minus infinity without material.
    overlap_m: F,
}

#[derive(Clone, Copy)]
struct Rows<'a, T> {
    heights: &'a [T],
    stride: usize,
    ny: usize,
}

impl<'a, T> Rows<'a, T> {
    /// Rows of `ny` samples from a corner of a map whose rows have `stride`.
    fn of(heights: &'a [T], stride: usize, (x, y): (usize, usize), ny: usize) -> Self {
        Self {
            heights: heights.get(x * stride + y..).unwrap_or(&[]),
            stride,
            ny,
        }
    }

    #[inline(always)]
    fn row(&self, x: usize) -> &'a [T] {
        let start = x * self.stride;
        self.heights.get(start..start + self.ny).unwrap_or(&[])
    }
}

impl<B: Copy, L: Copy, F: Fn(B, L) -> f32> Lowering<'_, B, L, F> {
    fn row(&self, x: usize) -> impl DoubleEndedIterator<Item = f32> + ExactSizeIterator {
        let pairs = self.content.row(x).iter().zip(self.underside.row(x));
        pairs.map(|(below, lower)| (self.overlap_m)(*below, *lower))
    }

    /// The greatest overlap of a row, 0 at least.
    #[inline(always)]
    fn highest(&self, x: usize) -> f32 {
        let (blocks, rest) = self.content.row(x).as_chunks::<LANES>();
        let (lower_blocks, lower_rest) = self.underside.row(x).as_chunks::<LANES>();
        let mut highest = [0.0_f32; LANES];
        for (below, lower) in blocks.iter().zip(lower_blocks) {
            for (highest, (below, lower)) in highest.iter_mut().zip(below.iter().zip(lower)) {
                *highest = greater(*highest, (self.overlap_m)(*below, *lower));
            }
        }
        for (highest, (below, lower)) in highest.iter_mut().zip(rest.iter().zip(lower_rest)) {
            *highest = greater(*highest, (self.overlap_m)(*below, *lower));
        }
        highest.into_iter().fold(0.0, greater)
    }
}

/// The greater of two numbers, in one instruction, which [`f32::max`] is not.
#[inline(always)]
fn greater(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

struct LowerRows<'a, B, L, F> {
    lowering: Lowering<'a, B, L, F>,
    overlaps_m: &'a mut [f32],
}

impl<B: Copy, L: Copy, F: Fn(B, L) -> f32> WithSimd for LowerRows<'_, B, L, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for (x, overlap_m) in self.overlaps_m.iter_mut().enumerate() {
            *overlap_m = self.lowering.highest(x);
        }
    }
}

impl Condition for PhysicalStability {
    const COST: Cost = Cost::Footprint;
    const CAUSE: Cause = Cause::Unstable;

    fn is_met(&mut self, asked: &Question<'_>) -> bool {
        let StepInput { grid, scene, .. } = *asked.input;
        self.is_stable(grid, scene, asked.view, asked.at)
    }
}
