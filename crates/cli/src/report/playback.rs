//! The packing step by step, for the viewer in the page.

use std::sync::Arc;

use nalgebra::Isometry3;
use ppnpack_catalogue::object::Model;
use ppnpack_packing::episode::Step;
use ppnpack_picture::Colour;
use serde::Serialize;

use super::simplified::QuantisedMesh;
use super::{Packing, Settled};

/// Draws a [`Playback`] in a page's `#playback`.
const VIEWER: &str = include_str!("playback.js");

/// More steps are not played: their page would be too large.
const MOST_STEPS: usize = 1_000;

/// What all meshes together take at most, before base64, in bytes.
const MESH_BYTES: usize = 900_000;

/// What a vertex takes with the two triangles that a closed surface has for each.
const BYTES_PER_VERTEX: usize = 6 + 2 * 6;

/// Even if there is room, no mesh has more vertices: enough to recognise it by.
const MOST_VERTICES: usize = 1_200;

/// A packing as the viewer needs it.
#[derive(Debug, Serialize)]
pub(super) struct Playback {
    /// The container's inner size.
    container_m: [f64; 3],
    /// Each shape once.
    models: Vec<QuantisedMesh>,
    steps: Vec<PlayedStep>,
}

/// What a step placed.
#[derive(Debug, Serialize)]
struct PlayedStep {
    item: String,
    /// What was decided and what became of it, for people.
    told: String,
    /// `#rrggbb`, as in the picture.
    colour: String,
    /// How it lies at the end; absent where it does not lie in or on the container.
    #[serde(skip_serializing_if = "Option::is_none")]
    lies: Option<Lies>,
}

#[derive(Debug, Serialize)]
struct Lies {
    /// Index of its shape.
    model: usize,
    /// The origin of the item frame in the container frame.
    position_m: [f64; 3],
    /// The quaternion's w, x, y, z.
    rotation: [f64; 4],
}

impl Playback {
    /// Of a packing; none where nothing was placed or too much to be played.
    pub(super) fn of(packing: &Packing) -> Option<Self> {
        if packing.steps.is_empty() || packing.steps.len() > MOST_STEPS {
            return None;
        }
        let mut models: Vec<&Arc<Model>> = Vec::new();
        let steps = packing.steps.iter().zip(&packing.settled);
        let steps = steps.map(|(step, settled)| PlayedStep {
            item: step.candidate.item.name().to_string(),
            told: told(packing, step, *settled),
            colour: hex(Colour::of_item(step.candidate.arrival)),
            lies: packing.lies(step.candidate.arrival).map(|content| {
                let model = index_of(&mut models, &content.model);
                Lies::new(model, &content.container_from_item)
            }),
        });
        let steps = steps.collect();
        let most = most_vertices(models.len());
        let meshes = models.iter();
        let meshes = meshes.map(|model| QuantisedMesh::of(&model.mesh, most));
        let size = packing.settings.grid.container();
        Some(Self {
            container_m: [size.x_m, size.y_m, size.z_m],
            models: meshes.collect::<Option<_>>()?,
            steps,
        })
    }

    /// The section of the page: the picture is shown where the viewer cannot be.
    pub(super) fn section(&self) -> String {
        let data = script_safe(&serde_json::to_string(self).unwrap_or_default());
        let last = self.steps.len();
        format!(
            "<section id=playback hidden aria-labelledby=playback-title><h2 id=playback-title>Step by step</h2>\
             <div class=player><div><canvas tabindex=0 role=application aria-label=\"The container in 3D. Arrow keys turn it, plus and \
             minus zoom, page up and page down go through the steps.\"></canvas>\
             <p class=sub>Drag or arrow keys turn, pinch, plus and minus zoom. Items are shown as they lie at the end.</p></div>\
             <div><p class=controls><button type=button class=play>Play</button>\
             <input type=range min=0 max={last} value={last} step=1 aria-label=\"Step\"></p>\
             <div class=now aria-live=polite></div></div></div></section>\
             <p id=no-playback class=sub>The packing can be played step by step in a browser with JavaScript and WebGL. This one does not \
             run them; the picture above shows the end.</p>\
             <script type=\"application/json\" id=playback-data>{data}</script><script>{VIEWER}</script>"
        )
    }
}

impl Lies {
    fn new(model: usize, container_from_item: &Isometry3<f64>) -> Self {
        let rotation = container_from_item.rotation.quaternion();
        Self {
            model,
            position_m: container_from_item.translation.vector.into(),
            rotation: [rotation.w, rotation.i, rotation.j, rotation.k],
        }
    }
}

/// What a step decided, and what became of it.
fn told(packing: &Packing, step: &Step, settled: Settled) -> String {
    let resolution = packing.settings.grid.resolution();
    let at = step.choice.resting;
    let cell_cm = resolution.cell_m() * 100.0;
    let height_cm = f64::from(at.resting_height) * resolution.height_unit_m() * 100.0;
    let yaw_deg = packing.yaw_rad(step).unwrap_or_default().to_degrees();
    let decided = format!(
        "Placed at x {:.1} cm, y {:.1} cm, {height_cm:.1} cm above the floor, turned by {yaw_deg:.0}°; value {:.2}, decided in {:.1} ms.",
        at.placement.x as f64 * cell_cm,
        at.placement.y as f64 * cell_cm,
        step.choice.value,
        step.timings.total().as_secs_f64() * 1e3
    );
    match settled.unsteadiness() {
        Some(what) => format!("{decided} It {what}."),
        None => format!("{decided} It stayed where it was placed."),
    }
}

/// The place of a model among those, which it joins if it is new.
fn index_of<'a>(models: &mut Vec<&'a Arc<Model>>, model: &'a Arc<Model>) -> usize {
    let known = models.iter().position(|other| Arc::ptr_eq(other, model));
    known.unwrap_or_else(|| {
        models.push(model);
        models.len() - 1
    })
}

/// How many vertices each of so many models may have.
fn most_vertices(models: usize) -> usize {
    (MESH_BYTES / BYTES_PER_VERTEX / models.max(1)).clamp(8, MOST_VERTICES)
}

fn hex(colour: Colour) -> String {
    let Colour { red, green, blue } = colour;
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// JSON that cannot end the script element that holds it.
fn script_safe(json: &str) -> String {
    json.replace('<', "\\u003c")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_ends_the_script_and_all_read_as_before() {
        let name = "</script><script>alert(\"1\")//<!--";
        let json = script_safe(&serde_json::to_string(name).unwrap());
        assert!(!json.contains('<'), "{json}");
        assert_eq!(serde_json::from_str::<String>(&json).unwrap(), name);
    }

    #[test]
    fn all_meshes_together_keep_within_what_a_page_may_take() {
        for models in [1, 40, 96, MOST_STEPS] {
            let vertices = most_vertices(models);
            assert!((8..=MOST_VERTICES).contains(&vertices));
            assert!(
                models * vertices * BYTES_PER_VERTEX <= MESH_BYTES,
                "{models}"
            );
        }
    }

    #[test]
    fn the_viewer_fetches_nothing_and_does_not_end_its_script() {
        for part in ["http", "import", "fetch(", "</", "innerHTML"] {
            assert!(!VIEWER.contains(part), "{part}");
        }
    }
}
