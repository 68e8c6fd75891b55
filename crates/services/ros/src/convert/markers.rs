//! What viewers draw, as markers: the scenes that are made for Foxglove, primitive by primitive.

use foxglove::messages::{
    self as scene, CubePrimitive, LinePrimitive, SceneEntity, SceneUpdate, TextPrimitive,
    TriangleListPrimitive,
};
use ppnpack_ros::messages::builtin_interfaces::Time;
use ppnpack_ros::messages::geometry_msgs::{Point, Pose, Quaternion, Vector3};
use ppnpack_ros::messages::std_msgs::{ColorRgba, Header};
use ppnpack_ros::messages::visualization_msgs::{Marker, MarkerArray};

/// How thick lines are, and how high a capital letter is, in metres, where a scene has them in pixels.
const LINE_M: f64 = 0.002;
const TEXT_M: f64 = 0.02;

/// A scene, in place of the one before.
pub(crate) fn of_scene(scene: &SceneUpdate) -> MarkerArray {
    let clear = Marker {
        action: Marker::DELETEALL,
        ..Marker::default()
    };
    let entities = scene.entities.iter().flat_map(of_entity);
    MarkerArray {
        markers: std::iter::once(clear).chain(entities).collect(),
    }
}

/// The markers of an entity: its name is their namespace, in which they are numbered.
fn of_entity(entity: &SceneEntity) -> Vec<Marker> {
    let cubes = entity.cubes.iter().map(cube);
    let lines = entity.lines.iter().map(lines);
    let triangles = entity.triangles.iter().map(triangles);
    let texts = entity.texts.iter().map(text);
    let markers = cubes.chain(lines).chain(triangles).chain(texts);
    let header = Header {
        stamp: Time::now(),
        frame_id: entity.frame_id.clone(),
    };
    let numbered = (0..).zip(markers).map(|(id, marker)| Marker {
        header: header.clone(),
        ns: entity.id.clone(),
        id,
        action: Marker::ADD,
        frame_locked: true,
        ..marker
    });
    numbered.collect()
}

fn cube(cube: &CubePrimitive) -> Marker {
    let size = cube.size.as_ref();
    Marker {
        r#type: Marker::CUBE,
        scale: size.map_or_else(Vector3::default, |size| Vector3 {
            x: size.x,
            y: size.y,
            z: size.z,
        }),
        ..plain(cube.pose.as_ref(), cube.color.as_ref())
    }
}

fn lines(lines: &LinePrimitive) -> Marker {
    let is_list = lines.r#type() == scene::line_primitive::Type::LineList;
    let mut points = points(&lines.points, &lines.indices);
    if is_list {
        // Only whole pairs are drawn.
        points.truncate(points.len() / 2 * 2);
    }
    Marker {
        r#type: match is_list {
            true => Marker::LINE_LIST,
            false => Marker::LINE_STRIP,
        },
        scale: Vector3 {
            x: match lines.scale_invariant {
                true => LINE_M,
                false => lines.thickness,
            },
            ..Vector3::default()
        },
        points,
        ..plain(lines.pose.as_ref(), lines.color.as_ref())
    }
}

fn triangles(triangles: &TriangleListPrimitive) -> Marker {
    let mut points = points(&triangles.points, &triangles.indices);
    points.truncate(points.len() / 3 * 3);
    Marker {
        r#type: Marker::TRIANGLE_LIST,
        scale: Vector3 {
            x: 1.0,
            y: 1.0,
            z: 1.0,
        },
        points,
        ..plain(triangles.pose.as_ref(), triangles.color.as_ref())
    }
}

fn text(text: &TextPrimitive) -> Marker {
    Marker {
        r#type: Marker::TEXT_VIEW_FACING,
        scale: Vector3 {
            z: TEXT_M,
            ..Vector3::default()
        },
        text: text.text.clone(),
        ..plain(text.pose.as_ref(), text.color.as_ref())
    }
}

/// Points in the order of their indices; those that an index names and that are not there are left out.
fn points(points: &[scene::Point3], indices: &[u32]) -> Vec<Point> {
    let point = |at: &scene::Point3| Point {
        x: at.x,
        y: at.y,
        z: at.z,
    };
    if indices.is_empty() {
        return points.iter().map(point).collect();
    }
    let named = indices.iter().filter_map(|index| {
        let index = usize::try_from(*index).ok()?;
        points.get(index).map(point)
    });
    named.collect()
}

fn plain(pose: Option<&scene::Pose>, color: Option<&scene::Color>) -> Marker {
    let position = pose.and_then(|pose| pose.position.as_ref());
    let orientation = pose.and_then(|pose| pose.orientation.as_ref());
    Marker {
        pose: Pose {
            position: position.map_or_else(Point::default, |at| Point {
                x: at.x,
                y: at.y,
                z: at.z,
            }),
            orientation: orientation.map_or(Quaternion::IDENTITY, |turn| Quaternion {
                x: turn.x,
                y: turn.y,
                z: turn.z,
                w: turn.w,
            }),
        },
        color: color.map_or_else(ColorRgba::default, |color| ColorRgba {
            r: color.r as f32,
            g: color.g as f32,
            b: color.b as f32,
            a: color.a as f32,
        }),
        ..Marker::default()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;
    use ppnpack_packing::grid::ContainerSize;
    use ppnpack_packing::motion::LegKind;
    use ppnpack_wire::convert::pose;
    use ppnpack_wire::debug_plan::{self, ArmLines, PlannedStep, TipPath};
    use ppnpack_wire::keys::Cell;
    use ppnpack_wire::{debug, v1};

    use super::*;

    #[test]
    fn a_scene_is_drawn_in_place_of_the_one_before() {
        let cell = Cell::new("cell-1").unwrap();
        let body = v1::Body {
            item_id: "a".to_owned(),
            object: "mug".to_owned(),
            container_from_item: Some(pose::write(&Isometry3::translation(0.1, 0.1, 0.05))),
            ..v1::Body::default()
        };
        let state = v1::CellState {
            bodies: vec![body],
            ..v1::CellState::default()
        };
        let scene = debug::state(&cell, 0, &state);
        let MarkerArray { markers } = of_scene(&scene);
        let drawn: Vec<(&str, i32, i32)> = markers
            .iter()
            .map(|marker| (marker.ns.as_str(), marker.id, marker.r#type))
            .collect();
        assert_eq!(markers[0].action, Marker::DELETEALL);
        assert_eq!(
            drawn[1..],
            [
                ("body/a", 0, Marker::CUBE),
                ("body/a", 1, Marker::TEXT_VIEW_FACING),
            ]
        );
        assert_eq!(markers[1].scale.z, 0.02);
        assert_eq!(markers[1].pose.position.z, 0.05);
        assert_eq!(markers[2].text, "mug");
        for marker in &markers[1..] {
            assert_eq!(marker.header.frame_id, "cell-1/container");
            assert!(marker.color.a > 0.0);
        }
    }

    #[test]
    fn an_arm_and_its_way_are_strips_as_thick_as_the_scene_has_them() {
        let points: Vec<_> = [0.1, 0.2, 0.4]
            .map(|z| nalgebra::Point3::new(0.0, 0.1, z))
            .into();
        let leg = TipPath {
            kind: LegKind::Insert,
            points: points.clone(),
        };
        let step = PlannedStep {
            arm: Some(ArmLines {
                links: points,
                legs: vec![leg],
                cycle_s: 3.4,
            }),
            ..PlannedStep::default()
        };
        let cell = Cell::new("cell-1").unwrap();
        let scene = debug_plan::scene(&cell, 0, ContainerSize::REFERENCE, &step);
        let MarkerArray { markers } = of_scene(&scene);
        assert_eq!(
            (markers[1].r#type, markers[1].points.len()),
            (Marker::LINE_LIST, 24),
            "twelve edges"
        );
        let drawn = markers[2..]
            .iter()
            .map(|marker| (marker.ns.as_str(), marker.r#type));
        assert_eq!(
            drawn.collect::<Vec<_>>(),
            [
                ("arm", Marker::LINE_STRIP),
                ("trajectory", Marker::LINE_STRIP),
                ("trajectory", Marker::TEXT_VIEW_FACING),
            ]
        );
        for (marker, line) in [(2, 1), (3, 2)] {
            let line = &scene.entities[line].lines[0];
            assert_eq!(markers[marker].scale.x, line.thickness);
            assert_eq!(markers[marker].points.len(), 3);
        }
        assert_eq!(markers[4].text, "cycle 3.4 s");
    }
}
