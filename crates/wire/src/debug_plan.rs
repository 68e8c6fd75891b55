//! What a step was planned on and what came of it, for people to look at: a `foxglove.SceneUpdate` with the meshes of all that lies there.

use foxglove::messages::{
    Color, LinePrimitive, Point3, SceneEntity, SceneUpdate, TextPrimitive, TriangleListPrimitive,
    line_primitive,
};
use nalgebra::Isometry3;
use ppnpack_packing::grid::ContainerSize;
use ppnpack_packing::model::Model;
use ppnpack_packing::motion::LegKind;

use crate::debug::{ItemBox, color, cube, edges, frame, in_place_of_all, label, pose, timestamp};
use crate::keys::Cell;

/// Triangles of a mesh that are drawn at most; a larger one is drawn as its box.
const MOST_TRIANGLES: usize = 20_000;

/// What is decided.
const CHOICE: Color = color(0.95, 0.65, 0.15, 0.9);

/// What would be next, each less visible than the one before.
const RUNNER_UP: Color = color(0.95, 0.85, 0.35, 0.25);

/// The arm, and how thick it is drawn, in metres.
const ARM: Color = color(0.45, 0.48, 0.52, 0.9);
const ARM_M: f64 = 0.02;

/// How thick the way of the cup's tip is with the item and without it, in metres.
const HOLDING_M: f64 = 0.008;
const EMPTY_M: f64 = 0.003;

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

/// An arm and its way over a cycle, as lines. In the container frame, in metres.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmLines {
    /// The origins of the arm's base and links, the flange and the cup's tip, in this order, as the arm lets go of the item; empty
    /// where the cycle does not say when it does.
    pub links: Vec<nalgebra::Point3<f64>>,
    /// The way of the cup's tip, leg by leg.
    pub legs: Vec<TipPath>,
    /// How long the cycle takes, in seconds.
    pub cycle_s: f64,
}

/// The way of the cup's tip over a leg of a cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct TipPath {
    /// What is done.
    pub kind: LegKind,
    /// Points along the way, in the container frame, in metres.
    pub points: Vec<nalgebra::Point3<f64>>,
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
    /// The arm that carries out what was chosen, where there is one.
    pub arm: Option<ArmLines>,
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
    let arm = step.arm.as_ref();
    let seen = arm.filter(|arm| !arm.links.is_empty());
    entities.extend(seen.map(|arm| SceneEntity {
        lines: vec![strip(&arm.links, ARM_M, ARM)],
        ..entity("arm".to_owned())
    }));
    entities.extend(arm.map(|arm| SceneEntity {
        lines: arm.legs.iter().filter_map(tip_path).collect(),
        texts: cycle_time(arm).into_iter().collect(),
        ..entity("trajectory".to_owned())
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
    Some(TriangleListPrimitive {
        pose: Some(pose(&placed.container_from_item)),
        points: drawn.vertices.iter().map(point).collect(),
        color: Some(colour),
        colors: Vec::new(),
        indices: drawn.triangles.iter().flatten().copied().collect(),
    })
}

fn point(at: &nalgebra::Point3<f64>) -> Point3 {
    Point3 {
        x: at.x,
        y: at.y,
        z: at.z,
    }
}

/// A line from point to point.
fn strip(points: &[nalgebra::Point3<f64>], thickness_m: f64, colour: Color) -> LinePrimitive {
    LinePrimitive {
        r#type: line_primitive::Type::LineStrip.into(),
        pose: Some(pose(&Isometry3::identity())),
        thickness: thickness_m,
        scale_invariant: false,
        points: points.iter().map(point).collect(),
        color: Some(colour),
        colors: Vec::new(),
        indices: Vec::new(),
    }
}

/// The way back is the way there: with the item it is wide and faint, without it narrow and full, so that both are seen. A leg that
/// leads nowhere has none.
fn tip_path(leg: &TipPath) -> Option<LinePrimitive> {
    let (thickness_m, colour) = match leg.kind {
        LegKind::Descend => (EMPTY_M, color(0.15, 0.30, 0.65, 1.0)),
        LegKind::Lift => (HOLDING_M, color(0.95, 0.75, 0.15, 0.5)),
        LegKind::Transfer => (HOLDING_M, color(0.95, 0.55, 0.10, 0.5)),
        LegKind::Insert => (HOLDING_M, color(0.85, 0.30, 0.10, 0.5)),
        LegKind::Retreat => (EMPTY_M, color(0.10, 0.50, 0.55, 1.0)),
        LegKind::Return => (EMPTY_M, color(0.25, 0.55, 0.85, 1.0)),
    };
    let leads = leg.points.len() > 1;
    leads.then(|| strip(&leg.points, thickness_m, colour))
}

/// How long a cycle takes, where its way begins.
fn cycle_time(arm: &ArmLines) -> Option<TextPrimitive> {
    let begins = arm.legs.iter().find_map(|leg| leg.points.first())?;
    let at = Isometry3::translation(begins.x, begins.y, begins.z);
    Some(written(&at, format!("cycle {:.1} s", arm.cycle_s)))
}

/// What is written at an object's origin.
fn text(placed: &Placed<'_>) -> TextPrimitive {
    written(&placed.container_from_item, placed.label.to_owned())
}

/// A text at a place, facing the viewer.
fn written(container_from_text: &Isometry3<f64>, text: String) -> TextPrimitive {
    TextPrimitive {
        pose: Some(pose(container_from_text)),
        billboard: true,
        font_size: 10.0,
        scale_invariant: true,
        color: Some(color(0.2, 0.2, 0.2, 1.0)),
        text,
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

    fn arm() -> ArmLines {
        let points = [[0.1, -0.3, 0.2], [0.1, -0.3, 0.5], [0.2, 0.1, 0.5]];
        let points: Vec<nalgebra::Point3<f64>> = points.map(nalgebra::Point3::from).into();
        let leg = |kind: LegKind| TipPath {
            kind,
            points: points.clone(),
        };
        ArmLines {
            legs: vec![
                leg(LegKind::Lift),
                leg(LegKind::Return),
                TipPath {
                    kind: LegKind::Descend,
                    points: vec![points[0]],
                },
            ],
            links: points.clone(),
            cycle_s: 3.42,
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
            arm: Some(arm()),
        };
        let size = ContainerSize {
            x_m: 0.4,
            y_m: 0.3,
            z_m: 0.2,
        };
        let scene = scene(&Cell::new("cell-1").unwrap(), 0, size, &step);
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
                "runner_up/2",
                "arm",
                "trajectory"
            ]
        );
        assert_eq!(scene.entities[1].triangles[0].indices.len(), 36);
        assert!(scene.entities[2].cubes.is_empty() && !scene.entities[2].triangles.is_empty());
        let (drawn, way) = (&scene.entities[5], &scene.entities[6]);
        assert_eq!(drawn.lines[0].points.len(), 3);
        assert_eq!(way.lines.len(), 2, "one leg leads nowhere");
        for line in drawn.lines.iter().chain(&way.lines) {
            assert_eq!(line.r#type(), line_primitive::Type::LineStrip);
            assert!(!line.scale_invariant && line.indices.is_empty());
        }
        assert_ne!(way.lines[0].color, way.lines[1].color);
        assert!(way.lines[0].thickness > way.lines[1].thickness);
        assert_eq!(way.texts[0].text, "cycle 3.4 s");
        let at = way.texts[0].pose.as_ref().unwrap();
        let at = at.position.as_ref().unwrap();
        assert_eq!((at.x, at.y, at.z), (0.1, -0.3, 0.2));
    }

    #[test]
    fn an_arm_that_is_not_known_to_let_go_is_not_drawn_but_its_way_is() {
        let step = PlannedStep {
            arm: Some(ArmLines {
                links: Vec::new(),
                ..arm()
            }),
            ..PlannedStep::default()
        };
        let size = ContainerSize::REFERENCE;
        let scene = scene(&Cell::new("cell-1").unwrap(), 0, size, &step);
        let ids = scene.entities.iter().map(|entity| entity.id.as_str());
        assert_eq!(ids.collect::<Vec<_>>(), ["container", "trajectory"]);
    }
}
