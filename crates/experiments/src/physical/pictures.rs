//! Pictures of a run: the tray as the camera saw it, the last heightmap, and the packed container.

use std::path::Path;

use anyhow::Context;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_picture::{HeightField, Size, heightmap};
use ppnpack_wire::convert::{cloud, scene};
use ppnpack_wire::v1;

use super::run::Done;
use super::tray::{HEIGHT_M, REGION};
use ppnpack_cli::drawing;
use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_cli::stack::report::contents;
use ppnpack_files::write_whole;

/// The edge of a cell of the tray's picture, in metres.
const TRAY_CELL_M: f64 = 0.004;

/// Writes `tray.png`, `heightmap.png` and `packed.png` into a folder.
pub(super) fn draw(done: &Done, catalogue: &Catalogue, grid: &Grid, folder: &Path) -> Outcome {
    let tray = tray(&done.tray_cloud).or_run()?;
    write_whole(&folder.join("tray.png"), &tray)?;
    let heights = heights(&done.heightmap, grid).or_run()?;
    write_whole(&folder.join("heightmap.png"), &heights)?;
    let packed = packed(done, catalogue, grid).or_run()?;
    Ok(write_whole(&folder.join("packed.png"), &packed)?)
}

/// The highest point of the cloud in each cell, over the tray.
fn tray(message: &v1::PointCloud) -> anyhow::Result<Vec<u8>> {
    let read = cloud::read(message)?;
    let cells = (REGION.highest_m - REGION.lowest_m) / TRAY_CELL_M;
    let (nx, ny) = (cells.x.ceil() as usize, cells.y.ceil() as usize);
    let mut heights_m = vec![f64::NAN; nx * ny];
    let container_from_sensor = read.container_from_sensor();
    for point in read.points() {
        let at = container_from_sensor * point.cast::<f64>();
        let offset = (at - REGION.lowest_m) / TRAY_CELL_M;
        let (x, y) = (offset.x, offset.y);
        let is_within = (0.0..nx as f64).contains(&x) && (0.0..ny as f64).contains(&y);
        if is_within && let Some(height_m) = heights_m.get_mut(x as usize * ny + y as usize) {
            *height_m = height_m.max(at.z - HEIGHT_M);
        }
    }
    let field = HeightField {
        nx,
        ny,
        cell_m: TRAY_CELL_M,
        heights_m: &heights_m,
        scale_top_m: None,
    };
    let title = "The tray as the camera sees it (grey: nothing seen)";
    Ok(heightmap(title, &field)?.to_png()?)
}

fn heights(message: &v1::Heightmap, grid: &Grid) -> anyhow::Result<Vec<u8>> {
    let (_, scene) = scene::read(message.scene.as_ref().context("no scene")?)?;
    let title = "Heightmap at the end (grey: unknown)";
    drawing::perceived(title, grid, scene.heightmap())
}

fn packed(done: &Done, catalogue: &Catalogue, grid: &Grid) -> anyhow::Result<Vec<u8>> {
    let contents = contents(&done.state, catalogue)?;
    let image = drawing::packed(grid, &[], &[], contents.iter(), Size::new(1200, 900)?)?;
    Ok(image.to_png()?)
}
