//! What lies in a container, as markers for `RViz`: each item as a small box with its name above.

use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;

use super::messages;
use crate::rmw::messages::{ColorRgba, Marker, MarkerArray, Vector3};

/// How large a mark is, and how high its letters are, in metres.
const MARK_M: f64 = 0.02;

/// The colours of what lies within the container, and of what does not.
const INSIDE: ColorRgba = color(0.2, 0.6, 0.9);
const OUTSIDE: ColorRgba = color(0.9, 0.2, 0.2);

/// What a marker is, and what is done with it, as `visualization_msgs/Marker` numbers it.
const CUBE: i32 = 1;
const TEXT_VIEW_FACING: i32 = 9;
const DELETEALL: i32 = 3;

/// Gives what lies in a container, in place of what lay there before.
pub(crate) fn of_state(cell: &Cell, state: &v1::CellState) -> MarkerArray {
    let clear = Marker {
        action: DELETEALL,
        ..Marker::default()
    };
    let header = messages::header(&messages::container_frame(cell.as_str()));
    let bodies = state.bodies.iter().flat_map(|body| {
        let mark = Marker {
            header: header.clone(),
            ns: format!("body/{}", body.item_id),
            r#type: CUBE,
            pose: messages::pose(body.container_from_item.as_ref()),
            scale: Vector3 {
                x: MARK_M,
                y: MARK_M,
                z: MARK_M,
            },
            color: if body.is_inside { INSIDE } else { OUTSIDE },
            frame_locked: true,
            ..Marker::default()
        };
        let mut name = Marker {
            id: 1,
            r#type: TEXT_VIEW_FACING,
            text: body.object.clone(),
            ..mark.clone()
        };
        name.pose.position.z += MARK_M;
        [mark, name]
    });
    MarkerArray {
        markers: std::iter::once(clear).chain(bodies).collect(),
    }
}

const fn color(r: f32, g: f32, b: f32) -> ColorRgba {
    ColorRgba { r, g, b, a: 1.0 }
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;
    use ppnpack_wire::convert::pose;

    use super::*;

    #[test]
    fn a_scene_is_drawn_in_place_of_the_one_before() {
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
        let MarkerArray { markers } = of_state(&Cell::new("cell-1").unwrap(), &state);
        let [clear, mark, name] = markers.as_slice() else {
            panic!("{markers:?}");
        };
        assert_eq!(clear.action, DELETEALL);
        assert_eq!((mark.r#type, name.r#type), (CUBE, TEXT_VIEW_FACING));
        assert_eq!((mark.pose.position.z, name.text.as_str()), (0.05, "mug"));
        assert_ne!(mark.id, name.id);
        for marker in [mark, name] {
            assert_eq!(marker.header.frame_id, "cell-1/container");
            assert_eq!((marker.ns.as_str(), marker.color.a), ("body/a", 1.0));
        }
    }
}
