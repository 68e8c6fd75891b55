//! Grids.

use ppnpack_packing::kernel::grid::{ContainerSize, Grid, GridError, Resolution, Yaws};

use crate::error::{WireError, needed};
use crate::limits::length_m;
use crate::v1;

/// Reads a grid.
///
/// # Errors
/// [`WireError`] where a length is missing or impossible, or there are too many cells, units or
/// yaws.
pub fn read(message: &v1::Grid) -> Result<Grid, WireError> {
    let container = needed("grid.container", message.container.as_ref())?;
    let container = ContainerSize {
        x_m: length_m("grid.container.x_m", container.x_m)?,
        y_m: length_m("grid.container.y_m", container.y_m)?,
        z_m: length_m("grid.container.z_m", container.z_m)?,
        draft_rad: message.draft_rad,
        corner_radius_m: message.corner_radius_m,
    };
    let cell_m = length_m("grid.cell_m", message.cell_m)?;
    let height_unit_m = length_m("grid.height_unit_m", message.height_unit_m)?;
    Yaws::from_radians(message.yaws_rad.clone())
        .and_then(|yaws| Resolution::new(cell_m, height_unit_m, yaws))
        .and_then(|resolution| Grid::new(container, resolution))
        .map_err(|error| WireError::invalid(field_of(&error), error))
}

fn field_of(error: &GridError) -> &'static str {
    match error {
        GridError::Cells { .. } => "grid.cell_m",
        GridError::HeightUnits { .. } => "grid.height_unit_m",
        GridError::Yaws => "grid.yaws_rad",
        _ => "grid",
    }
}

/// Writes a grid.
pub fn write(grid: &Grid) -> v1::Grid {
    let ContainerSize {
        x_m,
        y_m,
        z_m,
        draft_rad,
        corner_radius_m,
    } = grid.container();
    let resolution = grid.resolution();
    v1::Grid {
        container: Some(v1::BoxSize { x_m, y_m, z_m }),
        cell_m: resolution.cell_m(),
        height_unit_m: resolution.height_unit_m(),
        yaws_rad: resolution.yaws().radians().to_vec(),
        draft_rad,
        corner_radius_m,
    }
}
