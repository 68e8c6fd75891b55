//! The physical stability test.

use serde::{Deserialize, Serialize};

use super::polygon::SupportPolygon;
use crate::check::{Condition, Cost};
use crate::grid::Grid;
use crate::heightmap::Scene;
use crate::item::{ABSENT, ItemView};
use crate::placement::RestingPlacement;
use crate::refusal::Cause;
use crate::step::{Candidate, StepInput};

/// What the physical stability test asks for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PhysicalStabilitySettings {
    /// Surfaces closer than this when the item has come to rest are in contact, in metres.
    pub contact_tolerance_m: f64,
    /// The centre of mass must lie at least this far inside the support polygon, in metres.
    pub margin_m: f64,
}

impl Default for PhysicalStabilitySettings {
    fn default() -> Self {
        Self {
            contact_tolerance_m: 0.002,
            margin_m: 0.002,
        }
    }
}

/// A stability test on the real surfaces: in metres, with margins that do not depend on the cell.
///
/// The item is lowered onto the finely sampled surface of the content until it touches; where its underside is then
/// within the contact tolerance of the content is contact, and its true centre of mass must lie inside the convex
/// hull of the contacts. Where no fine surface or underside is known, the cells' heights take their place.
#[derive(Debug, Clone)]
pub struct PhysicalStability {
    settings: PhysicalStabilitySettings,
    polygon: SupportPolygon,
}

impl PhysicalStability {
    /// The test with these settings.
    pub fn new(settings: PhysicalStabilitySettings) -> Self {
        Self {
            settings,
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
        let (corner_x, corner_y) = (resting.placement.x, resting.placement.y);
        let resolution = grid.resolution();
        let samples = resolution.samples_per_cell();
        let underside = view
            .underside()
            .filter(|known| known.samples_per_cell == samples);
        if let (Some(surface), Some(underside)) = (scene.surface(), underside) {
            let ny = underside.ny;
            self.find_contacts(underside.nx, resolution.surface_pitch_m(), |x| {
                let start = (corner_x * samples + x) * surface.ny() + corner_y * samples;
                let below = surface.heights_m().get(start..start + ny).unwrap_or(&[]);
                let lower = underside.heights_m.get(x * ny..(x + 1) * ny).unwrap_or(&[]);
                below.iter().copied().zip(lower.iter().copied())
            });
        } else {
            let unit_m = resolution.height_unit_m() as f32;
            let ny = view.ny();
            self.find_contacts(view.nx(), resolution.cell_m(), |x| {
                let below = scene.heightmap().row(corner_x + x);
                let below = below.get(corner_y..).unwrap_or(&[]);
                let lower = view.bottom().get(x * ny..(x + 1) * ny).unwrap_or(&[]);
                below.iter().zip(lower).map(move |(below, bottom)| {
                    let lower_m = if *bottom == ABSENT {
                        f32::INFINITY
                    } else {
                        f32::from(*bottom) * unit_m
                    };
                    (f32::from(*below) * unit_m, lower_m)
                })
            });
        }
        self.polygon
            .depth(view.centre_of_mass_m(resolution.cell_m()))
    }

    /// Lowers the underside onto the content and collects the contacts.
    ///
    /// `row(x)` gives the heights of content and underside, in metres, of the samples with index `x` along x; they
    /// lie `pitch_m` apart. The underside is infinite where there is no material.
    fn find_contacts<Row>(&mut self, nx: usize, pitch_m: f64, row: impl Fn(usize) -> Row)
    where
        Row: DoubleEndedIterator<Item = (f32, f32)> + ExactSizeIterator,
    {
        let resting_m = (0..nx)
            .map(|x| row(x).fold(0.0_f32, |rest, (below, lower)| rest.max(below - lower)))
            .fold(0.0_f32, f32::max);
        let touching = resting_m - self.settings.contact_tolerance_m as f32;
        self.polygon.clear();
        for x in 0..nx {
            // The floor is content too, at height 0, which the surface never lies below.
            let is_contact = |(below, lower): (f32, f32)| below - lower >= touching;
            let contacts = row(x).enumerate().filter(|(_, pair)| is_contact(*pair));
            self.polygon.add_row(x, contacts.map(|(y, _)| y), pitch_m);
        }
    }
}

impl Condition for PhysicalStability {
    const COST: Cost = Cost::Footprint;
    const CAUSE: Cause = Cause::Unstable;

    fn is_met(&mut self, input: &StepInput<'_>, held: &Candidate, at: &RestingPlacement) -> bool {
        let view = held.item.views().get(at.placement.yaw);
        view.is_some_and(|view| self.is_stable(input.grid, input.scene, view, at))
    }
}
