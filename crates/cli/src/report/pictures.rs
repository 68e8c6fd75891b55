//! The pictures of a report.

use anyhow::Context;
use ppnpack_chart::{Curve, Lines};
use ppnpack_picture::Size;

use super::Packing;
use crate::drawing;

/// Pictures as the files hold them.
pub(super) struct Pictures {
    pub(super) packed_png: Vec<u8>,
    pub(super) heightmap_png: Vec<u8>,
    pub(super) utilisation_svg: String,
    pub(super) decisions_svg: String,
}

pub(super) fn draw(packing: &Packing) -> anyhow::Result<Pictures> {
    let grid = &packing.settings.grid;
    let packed = drawing::packed(grid, packing.contents.iter(), Size::new(1600, 1200)?);
    let title = "Heightmap of the packed container";
    let heights = drawing::heights(title, grid, packing.scene.heightmap(), None);
    Ok(Pictures {
        packed_png: packed
            .and_then(|image| image.to_png())
            .context("packed.png cannot be drawn")?,
        heightmap_png: heights.context("heightmap.png cannot be drawn")?,
        utilisation_svg: utilisation(packing)?,
        decisions_svg: decisions(packing)?,
    })
}

/// How the container fills: the share of its volume by the items' meshes after each step.
fn utilisation(packing: &Packing) -> anyhow::Result<String> {
    let container = packing.settings.grid.container();
    let whole_m3 = container.x_m * container.y_m * container.z_m;
    let mut filled_m3 = 0.0;
    let mut points = vec![[0.0, 0.0]];
    for (step, settled) in packing.steps.iter().zip(&packing.settled) {
        if settled.inside {
            filled_m3 += step.candidate.item.mesh_volume_m3();
        }
        points.push([(step.step + 1) as f64, 100.0 * filled_m3 / whole_m3]);
    }
    chart(
        "Container filled",
        ["Items placed", "Filled by meshes (%)"],
        points,
    )
}

fn decisions(packing: &Packing) -> anyhow::Result<String> {
    let steps = packing.steps.iter();
    let points = steps.map(|step| {
        let total_ms = step.timings.total().as_secs_f64() * 1e3;
        [(step.step + 1) as f64, total_ms]
    });
    chart("Decision time", ["Item", "Time (ms)"], points.collect())
}

/// One line over the items.
fn chart(
    title: &str,
    [x_label, y_label]: [&str; 2],
    points: Vec<[f64; 2]>,
) -> anyhow::Result<String> {
    let chart = Lines {
        title: title.to_owned(),
        x_label: x_label.to_owned(),
        y_label: y_label.to_owned(),
        curves: vec![Curve {
            name: String::new(),
            points,
        }],
    };
    Ok(chart.to_svg([720, 380])?)
}
