//! Pictures of what was seen. What is hidden is grey.

use anyhow::Context;
use ppnpack_packing::grid::Grid;
use ppnpack_perception::mapper::Mapped;
use ppnpack_picture::HeightField;

use crate::drawing;

/// The heightmap that placements are planned on, as a PNG.
pub(super) fn heightmap(grid: &Grid, mapped: &Mapped) -> anyhow::Result<Vec<u8>> {
    drawing::perceived("Heightmap (grey: unknown)", grid, mapped.scene.heightmap())
}

/// The surface that it was made of, as a PNG.
pub(super) fn surface(grid: &Grid, mapped: &Mapped) -> anyhow::Result<Vec<u8>> {
    let surface = mapped.scene.surface().context("the scene has no surface")?;
    // What is unknown without any line of sight is above the rim by less than a unit.
    let rim_m = grid.container().z_m;
    let unit_m = grid.resolution().height_unit_m();
    let samples = surface.heights_m().iter().zip(surface.support_m());
    let heights_m = samples.map(|(height_m, held_m)| {
        let is_bound = held_m < height_m;
        let height_m = f64::from(*height_m);
        let is_unknown = height_m > rim_m && height_m < rim_m + unit_m;
        if is_bound || is_unknown {
            f64::NAN
        } else {
            height_m
        }
    });
    let heights_m: Vec<f64> = heights_m.collect();
    let field = HeightField {
        nx: surface.nx(),
        ny: surface.ny(),
        cell_m: surface.pitch_m(),
        heights_m: &heights_m,
        scale_top_m: Some(rim_m),
    };
    let image = ppnpack_picture::heightmap("Surface (grey: hidden)", &field);
    Ok(image.context("the heightmap cannot be drawn")?.to_png()?)
}
