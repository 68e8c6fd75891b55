//! The packing step by step, for the viewer in the page.

use std::sync::Arc;

use ppnpack_catalogue::object::Model;
use ppnpack_picture::Colour;
use serde::Serialize;

use super::Packing;
use super::motion::{QuantisedPose, Shape, Shapes, Shift, shifts};
use super::simplified::QuantisedMesh;

/// Scripts that draw a [`Playback`] in a page's `#playback`: the modules of the operator's page
/// that draw a container, and this page's own.
const MODULES: [&str; 5] = [
    include_str!("../../../services/console/page/vectors.js"),
    include_str!("../../../services/console/page/gl.js"),
    include_str!("../../../services/console/page/orbit.js"),
    include_str!("../../../services/console/page/scene.js"),
    include_str!("playback.js"),
];

/// Maximum of steps that are played: with more, the page would be too large.
const MOST_STEPS: usize = 1_000;

/// Maximum size of all meshes together, before base64, in bytes.
const MESH_BYTES: usize = 900_000;

/// Size of a vertex with the two triangles that a closed surface has for each, in bytes.
const BYTES_PER_VERTEX: usize = 6 + 2 * 6;

/// Maximum of vertices of a mesh even if there is room: enough to recognise it by.
const MOST_VERTICES: usize = 1_200;

/// A packing as the viewer needs it.
#[derive(Debug, Serialize)]
pub(super) struct Playback {
    /// The container's inner size.
    container_m: [f64; 3],
    /// Each shape once.
    models: Vec<QuantisedMesh>,
    /// The content from before the first step, as it lies at the end.
    lying: Vec<LyingItem>,
    steps: Vec<PlayedStep>,
}

/// An item that lay there before the first step.
#[derive(Debug, Serialize)]
struct LyingItem {
    model: usize,
    pose: QuantisedPose,
}

/// A step: the item that it placed, and the items that it moved.
#[derive(Debug, Serialize)]
struct PlayedStep {
    item: String,
    /// The decision: the place of the lower corner of its box, its turn, the value of that, and the
    /// time that it took.
    planned_cm: [f64; 3],
    yaw_rad: Option<f64>,
    value: f64,
    decision_s: f64,
    /// Words for how it did not stay, where it did not.
    unsteadiness: Option<String>,
    /// `#rrggbb`, as in the picture.
    colour: String,
    /// Index of its shape; absent where that is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    model: Option<usize>,
    /// The pose that was planned for its shape.
    #[serde(skip_serializing_if = "Option::is_none")]
    planned: Option<QuantisedPose>,
    /// The items that lie elsewhere after it.
    shifts: Vec<Shift>,
    /// The items that are in the container no longer after it, by the steps that placed them.
    gone: Vec<usize>,
}

impl Playback {
    /// Makes that of a packing; none where nothing was placed or too much to be played.
    pub(super) fn of(packing: &Packing) -> Option<Self> {
        if packing.steps.is_empty() || packing.steps.len() > MOST_STEPS {
            return None;
        }
        let shapes = shapes(packing);
        let mut models: Vec<&Arc<Model>> = Vec::new();
        let lying = packing.preloaded.iter().map(|body| LyingItem {
            model: index_of(&mut models, &body.model),
            pose: QuantisedPose::of(&body.container_from_item),
        });
        let lying = lying.collect();
        let steps = packing.steps.iter().zip(&packing.settled);
        let further = shifts(&packing.moves, &shapes).into_iter();
        let steps = steps.zip(further.zip(&packing.moves));
        let steps = steps.map(|((step, settled), (shifts, moves))| {
            let shape = shapes.get(&step.candidate.arrival);
            let shape = shape.map(|(_, shape)| shape);
            let number = |arrival: &usize| shapes.get(arrival).map(|(number, _)| *number);
            PlayedStep {
                item: step.candidate.item.name().to_string(),
                planned_cm: packing.planned_cm(step),
                yaw_rad: packing.yaw_rad(step),
                value: step.choice.value,
                decision_s: step.timings.total().as_secs_f64(),
                unsteadiness: settled.unsteadiness(),
                colour: hex(Colour::of_item(step.candidate.arrival)),
                model: shape.map(|shape| index_of(&mut models, shape.model)),
                planned: shape.and_then(|shape| shape.planned(step, &packing.settings.grid)),
                shifts,
                gone: moves.gone.iter().filter_map(number).collect(),
            }
        });
        let steps = steps.collect();
        let most = most_vertices(models.len());
        let meshes = models.iter();
        let meshes = meshes.map(|model| QuantisedMesh::of(&model.mesh, most));
        let size = packing.settings.grid.container();
        Some(Self {
            container_m: [size.x_m, size.y_m, size.z_m],
            models: meshes.collect::<Option<_>>()?,
            lying,
            steps,
        })
    }

    /// Gives JSON that cannot end the script element that holds it.
    pub(super) fn to_json(&self) -> serde_json::Result<String> {
        Ok(serde_json::to_string(self)?.replace('<', "\\u003c"))
    }
}

/// Joins the modules to one script, which imports nothing.
pub(super) fn viewer() -> String {
    let lines = MODULES.iter().flat_map(|module| module.lines());
    let own = lines.filter(|line| !line.starts_with("import "));
    let own = own.map(|line| line.strip_prefix("export ").unwrap_or(line));
    let own: Vec<&str> = own.collect();
    format!("'use strict';\n(() => {{\n{}\n}})();", own.join("\n"))
}

/// Gives the shapes of what was placed, where they are known.
fn shapes(packing: &Packing) -> Shapes<'_> {
    let steps = packing.steps.iter().enumerate();
    let shapes = steps.filter_map(|(number, step)| {
        let arrival = step.candidate.arrival;
        let shape = Shape::of(step, packing.lies(arrival))?;
        Some((arrival, (number, shape)))
    });
    shapes.collect()
}

/// Gives the place of a model among those, which it joins if it is new.
fn index_of<'a>(models: &mut Vec<&'a Arc<Model>>, model: &'a Arc<Model>) -> usize {
    let known = models.iter().position(|other| Arc::ptr_eq(other, model));
    known.unwrap_or_else(|| {
        models.push(model);
        models.len() - 1
    })
}

/// Gives the most vertices that each of so many models may have.
fn most_vertices(models: usize) -> usize {
    (MESH_BYTES / BYTES_PER_VERTEX / models.max(1)).clamp(8, MOST_VERTICES)
}

fn hex(colour: Colour) -> String {
    let Colour { red, green, blue } = colour;
    format!("#{red:02x}{green:02x}{blue:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_meshes_together_keep_within_what_a_page_may_take() {
        for models in [1, 40, 96, MOST_STEPS] {
            let vertices = most_vertices(models);
            assert!((8..=MOST_VERTICES).contains(&vertices));
            let bytes = models * vertices * BYTES_PER_VERTEX;
            assert!(bytes <= MESH_BYTES, "{models}");
        }
    }

    #[test]
    fn the_viewer_fetches_nothing_and_does_not_end_its_script() {
        let viewer = viewer();
        for part in ["http", "import ", "export ", "fetch(", "</", "innerHTML"] {
            assert!(!viewer.contains(part), "{part}");
        }
    }
}
