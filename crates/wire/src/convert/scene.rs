//! Scenes: the container's content on a grid.

use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::heightmap::{Heightmap, Surface};
use ppnpack_packing::scene::Scene;

use super::{grid, numbers};
use crate::error::{WireError, needed};
use crate::limits::{checked, to_index};
use crate::v1;

/// Reads a scene and its grid.
///
/// # Errors
/// [`WireError`] where the grid or a height is impossible, or there are not as many heights as the
/// grid needs.
pub fn read(message: &v1::Scene) -> Result<(Grid, Scene), WireError> {
    let grid = grid::read(needed("scene.grid", message.grid.as_ref())?)?;
    let size = (grid.nx(), grid.ny());
    let heights = numbers::read_units("scene.heights", &message.heights, size)?;
    let heightmap = Heightmap::from_units(grid.nx(), grid.ny(), heights)
        .map_err(|error| WireError::invalid("scene.heights", error))?;
    let surface = message.surface.as_ref();
    let surface = surface.map(|surface| read_surface(surface, &grid));
    let scene = Scene::new(&grid, heightmap, surface.transpose()?)
        .map_err(|error| WireError::invalid("scene", error))?;
    Ok((grid, scene))
}

/// Reads the scene that a field holds.
///
/// # Errors
/// [`WireError`] as [`read`], and where there is none.
pub fn read_required(
    field: &'static str,
    message: Option<&v1::Scene>,
) -> Result<(Grid, Scene), WireError> {
    read(needed(field, message)?)
}

fn read_surface(message: &v1::Surface, grid: &Grid) -> Result<Surface, WireError> {
    let samples = grid.resolution().samples_per_cell();
    let found = message.samples_per_cell;
    let needed = format_args!("cells of {} m need {samples}", grid.resolution().cell_m());
    let field = "scene.surface.samples_per_cell";
    checked(field, found, found == to_index(samples), needed)?;
    // At most 2,048 cells of 400,000 samples: the grid's limits keep these products small.
    let (nx, ny) = (grid.nx() * samples, grid.ny() * samples);
    let field = "scene.surface.heights_m";
    let heights_m = numbers::read_floats(field, &message.heights_m, (nx, ny))?;
    let surface = Surface::from_metres(nx, ny, grid.resolution().surface_pitch_m(), heights_m)
        .map_err(|error| WireError::invalid(field, error))?;
    if message.support_m.is_empty() {
        return Ok(surface);
    }
    let field = "scene.surface.support_m";
    let support_m = numbers::read_floats(field, &message.support_m, (nx, ny))?;
    surface
        .with_support(support_m)
        .map_err(|error| WireError::invalid(field, error))
}

/// Writes a scene of a grid.
pub fn write(grid: &Grid, scene: &Scene) -> v1::Scene {
    v1::Scene {
        grid: Some(grid::write(grid)),
        heights: numbers::write_units(scene.heightmap().heights()),
        surface: scene.surface().map(|surface| v1::Surface {
            samples_per_cell: to_index(grid.resolution().samples_per_cell()),
            heights_m: numbers::write_floats(surface.heights_m()),
            support_m: match surface.has_bounds() {
                true => numbers::write_floats(surface.support_m()),
                false => Vec::new(),
            },
        }),
    }
}
