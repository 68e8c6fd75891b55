//! The pictures of a report.

use anyhow::Context;
use ppnpack_picture::{
    Camera, Colour, Curve, HeightField, Item, Lines, Scene3d, Size, TriangleMesh, heightmap, render,
};

use super::Packing;

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

fn packed(packing: &Packing) -> anyhow::Result<Vec<u8>> {
    let container = packing.settings.grid.container();
    let bodies = packing.contents.iter();
    let items = bodies.map(|(arrival, body)| Item {
        mesh: TriangleMesh {
            vertices: &body.model.mesh.vertices,
            triangles: &body.model.mesh.triangles,
        },
        world_from_item: body.container_from_item,
        colour: Colour::of_item(*arrival),
    });
    let scene = Scene3d {
        items: items.collect(),
        container_m: Some([container.x_m, container.y_m, container.z_m]),
    };
    let image = render(&scene, &Camera::overlooking(&scene), Size::new(1600, 1200)?)?;
    Ok(image.to_png()?)
}

fn heights(packing: &Packing) -> anyhow::Result<Vec<u8>> {
    let (grid, map) = (&packing.settings.grid, packing.scene.heightmap());
    let unit_m = grid.resolution().height_unit_m();
    let heights_m: Vec<f64> = map
        .heights()
        .iter()
        .map(|height| f64::from(*height) * unit_m)
        .collect();
    let field = HeightField {
        nx: map.nx(),
        ny: map.ny(),
        cell_m: grid.resolution().cell_m(),
        heights_m: &heights_m,
        scale_top_m: Some(grid.container().z_m),
    };
    Ok(heightmap("Heightmap of the packed container", &field)?.to_png()?)
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
    Ok(chart.to_svg(Size::new(720, 380)?))
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
    Ok(chart.to_svg(Size::new(720, 380)?))
}
