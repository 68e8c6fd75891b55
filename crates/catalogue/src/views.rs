//! Models to items: heightmap pairs per yaw.

use nalgebra::{Point2, Rotation3, Vector3};
use ppnpack_packing::kernel::grid::{ABSENT, MAX_CELLS, MAX_UNITS, Resolution, Units};
use ppnpack_packing::kernel::item::{Item, Underside, ViewSurfaces};

use crate::error::ObjectError;
use crate::mesh::{Bounds, Mesh};
use crate::object::Model;
use crate::raster::{Raster, SLACK_M, rasterise};

/// The item that a model is at a resolution: a heightmap pair and a fine lower surface per yaw.
///
/// A cell counts as occupied from the lowest to the highest point of the model above it, rounded
/// outwards to units.
///
/// # Errors
/// [`ObjectError`] where the model has more cells or units than the engine represents, or no surface.
pub fn item(model: &Model, resolution: &Resolution) -> Result<Item, ObjectError> {
    let yaws = resolution.yaws().radians().iter();
    let views = yaws.map(|yaw_rad| view(model, *yaw_rad, resolution));
    let views = views.collect::<Result<Vec<_>, _>>()?;
    let item = Item::new(&model.name, views, model.volume_m3);
    item.map_err(|error| ObjectError(error.to_string()))
}

/// The surfaces of a model turned by `yaw_rad`, whose bounding box starts at the footprint's
/// corner.
fn view(model: &Model, yaw_rad: f64, resolution: &Resolution) -> Result<ViewSurfaces, ObjectError> {
    let rotation = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw_rad);
    let vertices = model.mesh.vertices.iter().map(|vertex| rotation * vertex);
    let turned = Mesh {
        vertices: vertices.collect(),
        triangles: model.mesh.triangles.clone(),
    };
    let bounds = turned
        .bounds()
        .ok_or_else(|| ObjectError("its mesh is empty".to_owned()))?;
    let (nx, ny) = footprint(&bounds, resolution)?;
    let fine = FineSurfaces::of(&turned, &bounds, (nx, ny), resolution);
    let (top, bottom) = fine.pooled(resolution);
    let origin_from_corner_m = -bounds.lowest.coords;
    let centre = rotation * model.mass.centre_of_mass_m + origin_from_corner_m;
    Ok(ViewSurfaces {
        nx,
        ny,
        top,
        bottom,
        underside: Some(Underside {
            nx: fine.nx,
            ny: fine.ny,
            samples_per_cell: resolution.samples_per_cell(),
            heights_m: fine.spans.iter().map(|span| span.low_m as f32).collect(),
        }),
        origin_from_corner_m,
        centre_of_mass_m: Some(Point2::new(centre.x, centre.y)),
    })
}

/// The cells that a box covers along x and y.
fn footprint(bounds: &Bounds, resolution: &Resolution) -> Result<(usize, usize), ObjectError> {
    let extents_m = bounds.extents_m();
    let (cell_m, unit_m) = (resolution.cell_m(), resolution.height_unit_m());
    if extents_m.z > f64::from(MAX_UNITS) * unit_m {
        return Err(ObjectError(format!(
            "its height of {:.3} m is more than {MAX_UNITS} units of {unit_m} m: choose a larger height unit, or check the \
             file's unit of length",
            extents_m.z
        )));
    }
    let cells = |width_m: f64| {
        let cells = ((width_m - SLACK_M) / cell_m).ceil().max(1.0);
        if cells <= MAX_CELLS as f64 {
            Ok(cells as usize)
        } else {
            Err(ObjectError(format!(
                "its width of {width_m:.3} m is more than {MAX_CELLS} cells of {cell_m} m: choose larger cells, or check the \
                 file's unit of length"
            )))
        }
    };
    Ok((cells(extents_m.x)?, cells(extents_m.y)?))
}

/// Between the lowest and the highest material, in metres; infinite where there is none.
#[derive(Clone, Copy)]
struct Span {
    low_m: f64,
    high_m: f64,
}

impl Span {
    const NONE: Self = Self {
        low_m: f64::INFINITY,
        high_m: f64::NEG_INFINITY,
    };

    fn with(self, other: &Self) -> Self {
        Self {
            low_m: self.low_m.min(other.low_m),
            high_m: self.high_m.max(other.high_m),
        }
    }
}

/// The lower and upper surface of a mesh, from its lowest point.
struct FineSurfaces {
    nx: usize,
    ny: usize,
    spans: Vec<Span>,
}

impl FineSurfaces {
    fn of(mesh: &Mesh, bounds: &Bounds, cells: (usize, usize), resolution: &Resolution) -> Self {
        let samples = resolution.samples_per_cell();
        let (nx, ny) = (cells.0 * samples, cells.1 * samples);
        let raster = Raster {
            origin: bounds.lowest.xy(),
            pitch_m: resolution.surface_pitch_m(),
            nx,
            ny,
        };
        let mut spans = vec![Span::NONE; nx * ny];
        for triangle in mesh.corners() {
            rasterise(&triangle, &raster, |x, y, lowest, highest| {
                if let Some(span) = spans.get_mut(x * ny + y) {
                    *span = span.with(&Span {
                        low_m: lowest - bounds.lowest.z,
                        high_m: highest - bounds.lowest.z,
                    });
                }
            });
        }
        Self { nx, ny, spans }
    }

    /// The upper and lower surface per cell, in units, rounded outwards and at least one unit
    /// apart.
    fn pooled(&self, resolution: &Resolution) -> (Vec<Units>, Vec<Units>) {
        let samples = resolution.samples_per_cell();
        let (nx, ny) = (self.nx / samples, self.ny / samples);
        let mut cells = vec![Span::NONE; nx * ny];
        let columns = self.spans.chunks_exact(samples * self.ny);
        for (cells, columns) in cells.chunks_exact_mut(ny).zip(columns) {
            for column in columns.chunks_exact(self.ny) {
                for (cell, squares) in cells.iter_mut().zip(column.chunks_exact(samples)) {
                    *cell = squares.iter().fold(*cell, Span::with);
                }
            }
        }
        // A tip within the raster's slack of a border is in no square. The item stands on its
        // lowest cell all the same.
        let lowest_m = cells.iter().fold(Span::NONE, Span::with).low_m;
        let units = cells.iter().map(|cell| {
            if !cell.low_m.is_finite() {
                return (0, ABSENT);
            }
            let bottom = resolution.units_below(cell.low_m - lowest_m);
            let bottom = bottom.min(MAX_UNITS - 1);
            (resolution.units_above(cell.high_m).max(bottom + 1), bottom)
        });
        units.unzip()
    }
}

#[cfg(test)]
mod tests;
