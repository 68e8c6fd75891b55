//! Conversions from the stack's messages to those of ROS: states, sessions and frames.

use nalgebra::Isometry3;
use ppnpack_wire::convert;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;

use crate::rmw::messages::{
    Announcement, Body, CellState, Header, Item, Point, Pose, Quaternion, Session, Time, Transform,
    TransformStamped, Vector3,
};

/// Names the frame of a container, in which all coordinates are.
pub(crate) fn container_frame(cell: &Cell) -> String {
    format!("{cell}/container")
}

/// Gives the header of a message of now, in a frame.
pub(crate) fn header(frame_id: &str) -> Header {
    Header {
        stamp: Time::now(),
        frame_id: frame_id.to_owned(),
    }
}

/// Places a frame in another one, now.
pub(crate) fn frame(parent: &str, child_frame_id: String, pose: &Pose) -> TransformStamped {
    let Point { x, y, z } = pose.position;
    TransformStamped {
        header: header(parent),
        child_frame_id,
        transform: Transform {
            translation: Vector3 { x, y, z },
            rotation: pose.orientation.clone(),
        },
    }
}

/// Places the frames of the items in a container.
pub(crate) fn item_frames(cell: &Cell, state: &v1::CellState) -> Vec<TransformStamped> {
    let container = container_frame(cell);
    let frames = state.bodies.iter().filter_map(|body| {
        let at = convert::pose::read_required("pose", body.container_from_item.as_ref());
        let child = format!("{cell}/item/{}", body.item_id);
        Some(frame(&container, child, &pose_of(&at.ok()?)))
    });
    frames.collect()
}

/// Gives a pose of the stack's code.
pub(crate) fn pose_of(pose: &Isometry3<f64>) -> Pose {
    self::pose(Some(&convert::pose::write(pose)))
}

/// Gives a pose; a part that is not told is that of the origin.
pub(crate) fn pose(pose: Option<&v1::Pose>) -> Pose {
    let pose = pose.copied().unwrap_or_default();
    let at = pose.position.unwrap_or_default();
    let (x, y, z) = (at.x_m, at.y_m, at.z_m);
    let position = Point { x, y, z };
    let v1::Quaternion { x, y, z, w } = pose.orientation.unwrap_or(v1::Quaternion {
        w: 1.0,
        ..v1::Quaternion::default()
    });
    Pose {
        position,
        orientation: Quaternion { x, y, z, w },
    }
}

pub(crate) fn state(cell: &Cell, state: &v1::CellState) -> CellState {
    let bodies = state.bodies.iter().map(|body| Body {
        item_id: body.item_id.clone(),
        object: body.object.clone(),
        pose: pose(body.container_from_item.as_ref()),
        is_inside: body.is_inside,
        is_found: body.is_found,
    });
    let hold = state.hold.clone();
    CellState {
        header: header(&container_frame(cell)),
        state_number: state.state_number,
        executing_placement_id: state.executing_placement_id.clone(),
        bodies: bodies.collect(),
        is_simulated: state.is_simulated,
        is_held: hold.is_some(),
        hold_reason: hold.unwrap_or_default().reason,
    }
}

pub(crate) fn session(cell: &Cell, session: &v1::Session) -> Session {
    let items = session.items.iter().map(|item| Item {
        item_id: item.item_id.clone(),
        object: item.object.clone(),
        state: number(item.state),
        container: item.container.clone(),
        pose: pose(item.container_from_item.as_ref()),
    });
    Session {
        header: header(&container_frame(cell)),
        session_id: session.session_id.clone(),
        items: items.collect(),
        pending_decision_id: session.pending.clone().unwrap_or_default().decision_id,
        step: session.step,
        is_automatic: session.is_automatic,
        buffer: session.buffer,
        end: number(session.end),
        failure: session.failure.clone(),
    }
}

/// Reads the announcement of an item of the catalogue.
pub(crate) fn read_announcement(item: &Announcement) -> v1::Announcement {
    v1::Announcement {
        item_id: item.item_id.clone(),
        shape: Some(v1::announcement::Shape::Object(item.object.clone())),
        rules: Some(v1::ItemRules {
            is_fragile: item.is_fragile,
            is_bottom_only: item.is_bottom_only,
            is_upright: item.is_upright,
            carries_kg: None,
        }),
        ..v1::Announcement::default()
    }
}

/// Gives a number of an enumeration, numbered alike in ROS; one that is too large is nobody's.
fn number(value: i32) -> u8 {
    u8::try_from(value).unwrap_or(u8::MAX)
}
