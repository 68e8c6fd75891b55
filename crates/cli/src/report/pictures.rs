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
    Ok(Pictures {
        packed_png: packed(packing).context("packed.png cannot be drawn")?,
        heightmap_png: heights(packing).context("heightmap.png cannot be drawn")?,
        utilisation_svg: utilisation(packing)?,
        decisions_svg: decisions(packing)?,
    })
}

fn heights(packing: &Packing) -> anyhow::Result<Vec<u8>> {
    let title = "Heightmap of the packed container";
    drawing::heights(
        title,
        &packing.settings.grid,
        packing.scene.heightmap(),
        None,
    )
}

fn packed(packing: &Packing) -> anyhow::Result<Vec<u8>> {
    let contents = packing.contents.iter();
    drawing::packed(&packing.settings.grid, contents, Size::new(1600, 1200)?)
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
    let chart = Lines {
        title: "Container filled".to_owned(),
        x_label: "Items placed".to_owned(),
        y_label: "Filled by meshes (%)".to_owned(),
        curves: vec![Curve {
            name: String::new(),
            points,
        }],
    };
    Ok(chart.to_svg([720, 380])?)
}

fn decisions(packing: &Packing) -> anyhow::Result<String> {
    let steps = packing.steps.iter();
    let points = steps
        .map(|step| {
            [
                (step.step + 1) as f64,
                step.timings.total().as_secs_f64() * 1e3,
            ]
        })
        .collect();
    let chart = Lines {
        title: "Decision time".to_owned(),
        x_label: "Item".to_owned(),
        y_label: "Time (ms)".to_owned(),
        curves: vec![Curve {
            name: String::new(),
            points,
        }],
    };
    Ok(chart.to_svg([720, 380])?)
}
