//! The grid that a container is planned on: its size, cells, height units and yaws.

use std::f64::consts::{FRAC_PI_4, PI};

use ppnpack_numbers::{SettingError, settings};
use serde::{Deserialize, Serialize};

use crate::kernel::heightmap::Heightmap;

/// A height in units of the grid ([`Resolution::height_unit_m`]).
pub type Units = i16;

/// The greatest height the engine represents, in units.
///
/// Sums of two such heights stay inside `i16`, which the kernels rely on.
pub const MAX_UNITS: Units = 8191;

/// The lower surface of a cell with no material.
pub const ABSENT: Units = -1;

/// The most cells along one side of a grid.
pub const MAX_CELLS: usize = 2048;

/// The most yaws that an item may be placed at.
pub const MAX_YAWS: usize = 360;

/// Samples of the fine surfaces lie at most this far apart, in metres, whatever the cell.
const SURFACE_PITCH_M: f64 = 0.0025;

/// Rounding slack when a length is divided by a cell or a unit.
const DIVISION_SLACK: f64 = 1e-6;

/// Why a grid could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// A length is zero, negative or not finite.
    #[error("{what} must be a positive number of metres, but is {value}")]
    NotPositive {
        /// Name of the length.
        what: &'static str,
        /// Its value, in metres.
        value: f64,
    },
    /// A side has no cell or too many of them.
    #[error(
        "the container's {side} side has {cells} cells of {cell_m} m; between 1 and {MAX_CELLS} are possible: \
         choose another cell size"
    )]
    Cells {
        /// `x` or `y`.
        side: &'static str,
        /// How many cells it would have.
        cells: f64,
        /// The cell's edge, in metres.
        cell_m: f64,
    },
    /// The container's height has no unit or too many of them.
    #[error(
        "the container's height has {units} units of {unit_m} m; between 1 and {MAX_UNITS} are possible: \
         choose another height unit"
    )]
    HeightUnits {
        /// How many units it would have.
        units: f64,
        /// The height unit, in metres.
        unit_m: f64,
    },
    /// The walls cannot lean so far, or the corners not be so round.
    #[error(transparent)]
    Shape(#[from] SettingError),
    /// There is no yaw, or one is not finite.
    #[error("yaws must be between 1 and {MAX_YAWS} finite angles")]
    Yaws,
}

/// The yaws in which an item may be placed, in radians, counter-clockwise seen from above.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Yaws(Vec<f64>);

impl Yaws {
    /// `count` yaws evenly over half a turn; four are the paper's 0, 45, 90 and 135 degrees.
    ///
    /// # Errors
    /// [`GridError::Yaws`] where `count` is 0 or over 360.
    pub fn half_turn(count: usize) -> Result<Self, GridError> {
        if count > MAX_YAWS {
            return Err(GridError::Yaws);
        }
        let angle = |yaw: usize| PI * yaw as f64 / count as f64;
        Self::from_radians((0..count).map(angle).collect())
    }

    /// Yaws at any angles, in radians.
    ///
    /// # Errors
    /// [`GridError::Yaws`] where there are none or over 360, or one is not finite.
    pub fn from_radians(radians: Vec<f64>) -> Result<Self, GridError> {
        let are_finite = radians.iter().all(|radian| radian.is_finite());
        if are_finite && (1..=MAX_YAWS).contains(&radians.len()) {
            Ok(Self(radians))
        } else {
            Err(GridError::Yaws)
        }
    }

    /// Every `step`-th of these yaws, from the first; all of them for a step of 0.
    #[must_use]
    pub fn every(&self, step: usize) -> Self {
        Self(self.0.iter().copied().step_by(step.max(1)).collect())
    }

    /// The angles, in radians.
    pub fn radians(&self) -> &[f64] {
        &self.0
    }

    /// How many yaws there are.
    pub fn count(&self) -> usize {
        self.0.len()
    }
}

/// Cell, height unit and yaws, on which an item's heightmaps depend.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Resolution {
    cell_m: f64,
    height_unit_m: f64,
    yaws: Yaws,
}

impl Resolution {
    /// A resolution of square cells of `cell_m` and height units of `height_unit_m`, in metres.
    ///
    /// # Errors
    /// [`GridError::NotPositive`] where a length is not a positive number.
    pub fn new(cell_m: f64, height_unit_m: f64, yaws: Yaws) -> Result<Self, GridError> {
        positive("the cell", cell_m)?;
        positive("the height unit", height_unit_m)?;
        Ok(Self {
            cell_m,
            height_unit_m,
            yaws,
        })
    }

    /// The paper's: cells of 1 cm, heights in units of 0.2 cm, 4 yaws over half a turn.
    pub fn reference() -> Self {
        let yaws = (0..4).map(|yaw| f64::from(yaw) * FRAC_PI_4).collect();
        Self {
            cell_m: 0.01,
            height_unit_m: 0.002,
            yaws: Yaws(yaws),
        }
    }

    /// The edge of a cell, in metres.
    pub fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// One unit of height, in metres.
    pub fn height_unit_m(&self) -> f64 {
        self.height_unit_m
    }

    /// The yaws of a placement.
    pub fn yaws(&self) -> &Yaws {
        &self.yaws
    }

    /// How many samples of a fine surface lie along a cell's edge; their pitch is at most 2.5 mm.
    pub fn samples_per_cell(&self) -> usize {
        let samples = (self.cell_m / SURFACE_PITCH_M - DIVISION_SLACK).ceil();
        samples.max(1.0) as usize
    }

    /// The distance between two samples of a fine surface, in metres.
    pub fn surface_pitch_m(&self) -> f64 {
        self.cell_m / self.samples_per_cell() as f64
    }

    /// The smallest number of units that reaches `height_m`.
    pub fn units_above(&self, height_m: f64) -> Units {
        whole_units((height_m / self.height_unit_m - DIVISION_SLACK).ceil())
    }

    /// The greatest number of units that does not exceed `height_m`.
    pub fn units_below(&self, height_m: f64) -> Units {
        whole_units((height_m / self.height_unit_m + DIVISION_SLACK).floor())
    }

    /// The number of units nearest to `height_m`.
    pub fn units_nearest(&self, height_m: f64) -> Units {
        whole_units((height_m / self.height_unit_m).round())
    }

    /// `length_m` in whole cells, rounded down.
    pub(crate) fn cells_within(&self, length_m: f64) -> usize {
        (length_m / self.cell_m + DIVISION_SLACK).floor().max(0.0) as usize
    }
}

/// The inner size of a container: the box around its opening, from the floor to the rim, and how its
/// walls stand in it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContainerSize {
    /// Inner length along x at the rim, in metres.
    pub x_m: f64,
    /// Inner length along y at the rim, in metres.
    pub y_m: f64,
    /// Inner height from the floor to the rim, in metres.
    pub z_m: f64,
    /// Angle by which each wall leans outwards from the vertical, in radians.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub draft_rad: f64,
    /// Radius of the vertical edges between the walls, at every height, in metres.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub corner_radius_m: f64,
}

impl ContainerSize {
    /// The paper's container: 32 x 32 x 30 cm.
    pub const REFERENCE: Self = Self::cuboid(0.32, 0.32, 0.30);
}

/// A container seen as a grid of cells with heights in units.
///
/// Cell `(x, y)` covers `[x, x + 1) x [y, y + 1)` cells of the container frame, from an inner
/// bottom corner. A container that is no multiple of the cell leaves a strip at its far sides.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    container: ContainerSize,
    resolution: Resolution,
    nx: usize,
    ny: usize,
    rim: Units,
}

impl Grid {
    /// The grid of a container at a resolution.
    ///
    /// # Errors
    /// [`GridError`] where a length is not positive, a shape is impossible, or a side has no cell or
    /// more than the engine represents.
    pub fn new(container: ContainerSize, resolution: Resolution) -> Result<Self, GridError> {
        positive("the container's x side", container.x_m)?;
        positive("the container's y side", container.y_m)?;
        positive("the container's height", container.z_m)?;
        container.validate_shape()?;
        let cell_m = resolution.cell_m;
        let cells = |side: &'static str, length_m: f64| {
            let cells = (length_m / cell_m + DIVISION_SLACK).floor();
            if cells < 1.0 || cells > MAX_CELLS as f64 {
                return Err(GridError::Cells {
                    side,
                    cells,
                    cell_m,
                });
            }
            Ok(cells as usize)
        };
        let nx = cells("x", container.x_m)?;
        let ny = cells("y", container.y_m)?;
        let unit_m = resolution.height_unit_m;
        let units = (container.z_m / unit_m + DIVISION_SLACK).floor();
        if units < 1.0 || units > f64::from(MAX_UNITS) {
            return Err(GridError::HeightUnits { units, unit_m });
        }
        Ok(Self {
            container,
            resolution,
            nx,
            ny,
            rim: units as Units,
        })
    }

    /// The paper's: 32 x 32 cells of 1 cm, 150 units of 0.2 cm, 4 yaws.
    pub fn reference() -> Self {
        Self {
            container: ContainerSize::REFERENCE,
            resolution: Resolution::reference(),
            nx: 32,
            ny: 32,
            rim: 150,
        }
    }

    /// The container's inner size.
    pub fn container(&self) -> ContainerSize {
        self.container
    }

    /// The cell, height unit and yaws.
    pub fn resolution(&self) -> &Resolution {
        &self.resolution
    }

    /// Cells along x.
    pub fn nx(&self) -> usize {
        self.nx
    }

    /// Cells along y.
    pub fn ny(&self) -> usize {
        self.ny
    }

    /// The container's height in units.
    pub fn rim(&self) -> Units {
        self.rim
    }

    /// How many voxels (cell times unit) are inside the container; at least one.
    pub fn voxel_count(&self) -> f64 {
        if self.container.is_box() {
            return self.nx as f64 * self.ny as f64 * f64::from(self.rim);
        }
        let empty = Heightmap::empty(self);
        let columns = empty.heights().iter();
        let inside: f64 = columns.map(|lowest| f64::from(self.rim - lowest)).sum();
        inside.max(1.0)
    }
}

settings! {
    /// A container and how finely it is planned. The default is the paper's container
    /// ([`Grid::reference`]), planned more finely.
    #[derive(Copy)]
    pub struct GridSettings {
        /// The container's inner size.
        pub container: ContainerSize = ContainerSize::REFERENCE,
        /// The edge of a grid cell, in metres.
        pub cell_m: f64 = 0.0025,
        /// One unit of height, in metres.
        pub height_unit_m: f64 = 0.002,
        /// How many yaws, evenly over half a turn.
        pub yaws: usize = 16,
    }
}

impl GridSettings {
    /// The grid of the container.
    ///
    /// # Errors
    /// [`GridError`] where a length or a count is not possible.
    pub fn build(&self) -> Result<Grid, GridError> {
        Grid::new(self.container, self.resolution()?)
    }

    /// Gives the resolution.
    pub fn resolution(&self) -> Result<Resolution, GridError> {
        let yaws = Yaws::half_turn(self.yaws)?;
        Resolution::new(self.cell_m, self.height_unit_m, yaws)
    }
}

impl From<&Grid> for GridSettings {
    fn from(grid: &Grid) -> Self {
        let resolution = grid.resolution();
        Self {
            container: grid.container(),
            cell_m: resolution.cell_m(),
            height_unit_m: resolution.height_unit_m(),
            yaws: resolution.yaws().count(),
        }
    }
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

fn whole_units(units: f64) -> Units {
    units.clamp(0.0, f64::from(MAX_UNITS)) as Units
}

fn positive(what: &'static str, value: f64) -> Result<(), GridError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(GridError::NotPositive { what, value })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_grid_is_what_its_numbers_say() {
        let made = Grid::new(ContainerSize::REFERENCE, Resolution::reference()).unwrap();
        assert_eq!(made, Grid::reference());
        assert_eq!(Yaws::half_turn(4).unwrap(), *made.resolution().yaws());
    }

    #[test]
    fn lengths_round_outwards_to_units() {
        let resolution = Resolution::reference();
        assert_eq!(resolution.units_above(0.0041), 3);
        assert_eq!(resolution.units_above(0.004), 2);
        assert_eq!(resolution.units_below(0.0041), 2);
        assert_eq!(resolution.units_below(0.006), 3);
    }

    #[test]
    fn surface_samples_are_at_most_2_5_mm_apart() {
        for (cell_m, samples) in [(0.01, 4), (0.005, 2), (0.0025, 1), (0.003, 2), (0.001, 1)] {
            let resolution = Resolution::new(cell_m, 0.002, Yaws::half_turn(4).unwrap()).unwrap();
            assert_eq!(resolution.samples_per_cell(), samples, "cell {cell_m}");
        }
    }

    #[test]
    fn impossible_grids_are_refused() {
        let refusal = |x_m, z_m| {
            let size = ContainerSize::cuboid(x_m, 0.3, z_m);
            Grid::new(size, Resolution::reference()).unwrap_err()
        };
        for x_m in [-0.3, f64::NAN] {
            assert!(matches!(refusal(x_m, 0.3), GridError::NotPositive { .. }));
        }
        for x_m in [0.001, 100.0] {
            assert!(matches!(
                refusal(x_m, 0.3),
                GridError::Cells { side: "x", .. }
            ));
        }
        assert!(matches!(refusal(0.3, 100.0), GridError::HeightUnits { .. }));
        let leaning = ContainerSize {
            draft_rad: f64::NAN,
            ..ContainerSize::REFERENCE
        };
        let refused = Grid::new(leaning, Resolution::reference()).unwrap_err();
        assert!(refused.to_string().contains("container.draft_rad"));
        assert!(Yaws::half_turn(0).is_err());
        assert!(Yaws::half_turn(usize::MAX).is_err());
        for radians in [vec![], vec![0.0, f64::NAN], vec![0.0; MAX_YAWS + 1]] {
            assert_eq!(Yaws::from_radians(radians), Err(GridError::Yaws));
        }
    }
}
