//! What a step was planned on and what came of it, for people to look at: a `foxglove.SceneUpdate` with the meshes of all that lies there.

use foxglove::messages::{Color, Point3, SceneEntity, TextPrimitive, TriangleListPrimitive};
use nalgebra::Isometry3;
use ppnpack_packing::grid::ContainerSize;
use ppnpack_packing::model::Model;

use crate::debug::{
    ItemBox, SceneUpdate, color, cube, edges, frame, in_place_of_all, label, pose, timestamp,
};
use crate::keys::Cell;

/// Triangles of a mesh that are drawn at most; a larger one is drawn as its box.
const MOST_TRIANGLES: usize = 20_000;

/// What is decided.
const CHOICE: Color = color(0.95, 0.65, 0.15, 0.9);

/// What would be next, each less visible than the one before.
const RUNNER_UP: Color = color(0.95, 0.85, 0.35, 0.25);

/// An object somewhere in the container.
#[derive(Debug, Clone, Copy)]
pub struct Placed<'a> {
    /// Tells it from the others.
    pub id: &'a str,
    /// What is written beside it.
    pub label: &'a str,
    /// Its geometry.
    pub model: &'a Model,
    /// Where the model's frame is.
    pub container_from_item: Isometry3<f64>,
}

/// A step: what lay there, what was chosen, and what would have been next.
#[derive(Debug, Clone, Default)]
pub struct PlannedStep<'a> {
    /// What lay there.
    pub bodies: Vec<Placed<'a>>,
    /// What was chosen, where its solid is known.
    pub choice: Option<Placed<'a>>,
    /// What was chosen, as a box.
    pub choice_box: Option<ItemBox>,
    /// The next best placements, as boxes.
    pub runners_up: Vec<ItemBox>,
}

/// The step as a scene that replaces the one before.
pub fn scene(
    cell: &Cell,
    at_ns: i64,
    container: ContainerSize,
    step: &PlannedStep<'_>,
) -> SceneUpdate {
    let entity = |id: String| SceneEntity {
        timestamp: Some(timestamp(at_ns)),
        frame_id: frame(cell),
        id,
        ..SceneEntity::default()
    };
    let mut entities = vec![SceneEntity {
        lines: vec![edges(container)],
        ..entity("container".to_owned())
    }];
    entities.extend(step.bodies.iter().map(|body| SceneEntity {
        triangles: mesh(body, colour_of(body.label)).into_iter().collect(),
        texts: vec![text(body)],
        ..entity(format!("body/{}", body.id))
    }));
    let chosen = step.choice.as_ref().and_then(|choice| mesh(choice, CHOICE));
    let boxed = step.choice_box.as_ref();
    entities.extend(boxed.map(|boxed| SceneEntity {
        cubes: match chosen {
            Some(_) => Vec::new(),
            None => vec![cube(boxed, CHOICE)],
        },
        triangles: chosen.clone().into_iter().collect(),
        texts: vec![label(boxed)],
        ..entity("choice".to_owned())
    }));
    entities.extend(step.runners_up.iter().enumerate().map(|(rank, next)| {
        let seen = 1.0 / (rank + 1) as f64;
        let alpha = RUNNER_UP.a * seen;
        SceneEntity {
            cubes: vec![cube(
                next,
                Color {
                    a: alpha,
                    ..RUNNER_UP
                },
            )],
            texts: vec![label(next)],
            ..entity(format!("runner_up/{}", rank + 1))
        }
    }));
    in_place_of_all(at_ns, entities)
}

/// The mesh of an object where it is; its box where it has too many triangles, and `None` where it has none.
fn mesh(placed: &Placed<'_>, colour: Color) -> Option<TriangleListPrimitive> {
    let own = &placed.model.mesh;
    let boxed = match own.triangles.len() {
        0 => return None,
        1..=MOST_TRIANGLES => None,
        _ => Some(own.bounds()?.mesh()),
    };
    let drawn = boxed.as_ref().unwrap_or(own);
    let points = drawn.vertices.iter().map(|at| Point3 {
        x: at.x,
        y: at.y,
        z: at.z,
    });
    Some(TriangleListPrimitive {
        pose: Some(pose(&placed.container_from_item)),
        points: points.collect(),
        color: Some(colour),
        colors: Vec::new(),
        indices: drawn.triangles.iter().flatten().copied().collect(),
    })
}

/// What is written at an object's origin, facing the viewer.
fn text(placed: &Placed<'_>) -> TextPrimitive {
    TextPrimitive {
        pose: Some(pose(&placed.container_from_item)),
        billboard: true,
        font_size: 10.0,
        scale_invariant: true,
        color: Some(color(0.2, 0.2, 0.2, 1.0)),
        text: placed.label.to_owned(),
    }
}

/// A colour for a name: the same for the same, and others for others as a rule.
fn colour_of(name: &str) -> Color {
    // FNV-1a.
    let hash = name.bytes().fold(0x811c_9dc5_u32, |hash, byte| {
        (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193)
    });
    let turn = f64::from(hash % 360) / 360.0;
    let part = |shift: f64| 0.45 + 0.35 * (std::f64::consts::TAU * (turn + shift)).cos();
    color(part(0.0), part(1.0 / 3.0), part(2.0 / 3.0), 0.95)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};
    use ppnpack_packing::model::MassProperties;
    use ppnpack_packing::model::mesh::Mesh;

    use super::*;
    use crate::debug::Foxglove;

    fn model() -> Model {
        Model {
            name: "box".to_owned(),
            mesh: Mesh::cuboid([0.0; 3], [0.1; 3]),
            volume_m3: 0.001,
            pieces: Vec::new(),
            mass: MassProperties {
                mass_kg: 1.0,
                centre_of_mass_m: nalgebra::Point3::origin(),
                inertia_kg_m2: Matrix3::identity(),
            },
            carries_kg: None,
            resting_poses: Vec::new(),
        }
    }

    #[test]
    fn a_step_is_drawn_with_all_that_is_known_of_it() {
        let model = model();
        let placed = Placed {
            id: "a",
            label: "box",
            model: &model,
            container_from_item: Isometry3::identity(),
        };
        let boxed = ItemBox {
            id: "b".to_owned(),
            label: "box".to_owned(),
            container_from_middle: Isometry3::identity(),
            size_m: Vector3::repeat(0.1),
            is_inside: true,
        };
        let step = PlannedStep {
            bodies: vec![placed],
            choice: Some(placed),
            choice_box: Some(boxed.clone()),
            runners_up: vec![boxed.clone(), boxed],
        };
        let size = ContainerSize {
            x_m: 0.4,
            y_m: 0.3,
            z_m: 0.2,
        };
        let Foxglove(scene) = scene(&Cell::new("cell-1").unwrap(), 0, size, &step);
        let ids: Vec<&str> = scene
            .entities
            .iter()
            .map(|entity| entity.id.as_str())
            .collect();
        assert_eq!(
            ids,
            [
                "container",
                "body/a",
                "choice",
                "runner_up/1",
                "runner_up/2"
            ]
        );
        assert_eq!(scene.entities[1].triangles[0].indices.len(), 36);
        assert!(scene.entities[2].cubes.is_empty() && !scene.entities[2].triangles.is_empty());
    }
}
