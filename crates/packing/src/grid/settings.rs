//! A grid as it stands in a configuration.

use serde::{Deserialize, Serialize};

use super::{ContainerSize, Grid, GridError, Resolution, Yaws};

/// A container and how finely it is planned. The default is the paper's container
/// ([`Grid::reference`]), planned more finely.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GridSettings {
    /// The container's inner size.
    pub container: ContainerSize,
    /// The edge of a grid cell, in metres.
    pub cell_m: f64,
    /// One unit of height, in metres.
    pub height_unit_m: f64,
    /// How many yaws, evenly over half a turn.
    pub yaws: usize,
}

impl Default for GridSettings {
    fn default() -> Self {
        Self {
            cell_m: 0.0025,
            yaws: 16,
            ..Self::from(&Grid::reference())
        }
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
    ///
    /// # Errors
    /// As [`GridSettings::build`].
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
