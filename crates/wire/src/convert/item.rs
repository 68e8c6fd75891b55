//! Items.

use nalgebra::Point2;
use ppnpack_packing::kernel::grid::{MAX_CELLS, MAX_YAWS};
use ppnpack_packing::kernel::item::{Item, ItemView, Underside, ViewSurfaces};

use super::{numbers, pose};
use crate::error::{WireError, needed};
use crate::limits::{at_least_zero, count, name, to_index};
use crate::v1;

/// Reads an item.
///
/// # Errors
/// [`WireError`] where a map has the wrong size, a surface or a length is impossible, or there is
/// no material.
pub fn read(message: &v1::Item) -> Result<Item, WireError> {
    let name = name("item.name", &message.name)?;
    count("item.views", message.views.len(), 1..=MAX_YAWS)?;
    let views = message.views.iter().map(read_view);
    let views = views.collect::<Result<_, _>>()?;
    let volume_m3 = at_least_zero("item.mesh_volume_m3", message.mesh_volume_m3)?;
    Item::new(name, views, volume_m3).map_err(|error| WireError::invalid("item.views", error))
}

fn read_view(view: &v1::ItemView) -> Result<ViewSurfaces, WireError> {
    let side = |field: &'static str, cells: u32| {
        let cells = usize::try_from(cells).unwrap_or(usize::MAX);
        count(field, cells, 1..=MAX_CELLS).map(|()| cells)
    };
    let nx = side("item.views.nx", view.nx)?;
    let ny = side("item.views.ny", view.ny)?;
    let underside = view.underside.as_ref();
    let underside = underside.map(|underside| read_underside(underside, (nx, ny)));
    let field = "item.views.origin_from_corner";
    let origin = needed(field, view.origin_from_corner.as_ref())?;
    let origin_from_corner_m = pose::read_vector(field, origin)?;
    let field = "item.views.centre_of_mass";
    let centre = view.centre_of_mass.as_ref();
    let centre = centre.map(|centre| pose::read_vector(field, centre));
    Ok(ViewSurfaces {
        nx,
        ny,
        top: numbers::read_units("item.views.top", &view.top, (nx, ny))?,
        bottom: numbers::read_units("item.views.bottom", &view.bottom, (nx, ny))?,
        underside: underside.transpose()?,
        origin_from_corner_m,
        centre_of_mass_m: centre.transpose()?.map(|centre| Point2::from(centre.xy())),
    })
}

fn read_underside(
    underside: &v1::Underside,
    (nx, ny): (usize, usize),
) -> Result<Underside, WireError> {
    let field = "item.views.underside.heights_m";
    // Too many samples saturate to a size that no message has.
    let samples_per_cell = usize::try_from(underside.samples_per_cell).unwrap_or(usize::MAX);
    let [nx, ny] = [nx, ny].map(|cells| cells.saturating_mul(samples_per_cell));
    let heights_m = numbers::read_floats(field, &underside.heights_m, (nx, ny))?;
    let is_possible = |height_m: f32| height_m.is_finite() || height_m == f32::INFINITY;
    if nx == 0 || !heights_m.iter().copied().all(is_possible) {
        let reason = "finite heights are needed, or infinity where there is no material";
        return Err(WireError::invalid(field, reason));
    }
    Ok(Underside {
        nx,
        ny,
        samples_per_cell,
        heights_m,
    })
}

/// Writes an item.
pub fn write(item: &Item) -> v1::Item {
    v1::Item {
        name: item.name().to_string(),
        views: item.views().iter().map(write_view).collect(),
        mesh_volume_m3: item.mesh_volume_m3(),
    }
}

fn write_view(view: &ItemView) -> v1::ItemView {
    let surfaces = view.surfaces();
    let underside = surfaces.underside.as_ref();
    let centre = surfaces.centre_of_mass_m;
    v1::ItemView {
        nx: to_index(surfaces.nx),
        ny: to_index(surfaces.ny),
        top: numbers::write_units(&surfaces.top),
        bottom: numbers::write_units(&surfaces.bottom),
        underside: underside.map(|underside| v1::Underside {
            samples_per_cell: to_index(underside.samples_per_cell),
            heights_m: numbers::write_floats(&underside.heights_m),
        }),
        origin_from_corner: Some(pose::write_vector(&surfaces.origin_from_corner_m)),
        centre_of_mass: centre.map(|centre| v1::Vector3 {
            x_m: centre.x,
            y_m: centre.y,
            z_m: 0.0,
        }),
    }
}
