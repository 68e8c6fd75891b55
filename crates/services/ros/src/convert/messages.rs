//! States, decisions, outcomes and sessions.

use ppnpack_ros::messages::builtin_interfaces::Time;
use ppnpack_ros::messages::geometry_msgs::{Point, Pose, Quaternion};
use ppnpack_ros::messages::ppnpack_msgs::{
    Announcement, Body, CellState, Decision, Item, Outcome, Session,
};
use ppnpack_ros::messages::std_msgs::Header;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;

use crate::frames;

/// The header of what is so now, in the frame of a container.
pub(crate) fn header(container: &str) -> Header {
    Header {
        stamp: Time::now(),
        frame_id: frames::container(container),
    }
}

/// A pose; what is not told is at the origin.
pub(crate) fn pose(pose: Option<&v1::Pose>) -> Pose {
    let position = pose.and_then(|pose| pose.position.as_ref());
    let orientation = pose.and_then(|pose| pose.orientation.as_ref());
    Pose {
        position: position.map_or_else(Point::default, |at| Point {
            x: at.x_m,
            y: at.y_m,
            z: at.z_m,
        }),
        orientation: orientation.map_or(Quaternion::IDENTITY, |turn| Quaternion {
            x: turn.x,
            y: turn.y,
            z: turn.z,
            w: turn.w,
        }),
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
    CellState {
        header: header(cell.as_str()),
        state_number: state.state_number,
        executing_placement_id: state.executing_placement_id.clone(),
        bodies: bodies.collect(),
        is_simulated: state.is_simulated,
        is_held: state.hold.is_some(),
        hold_reason: state
            .hold
            .as_ref()
            .map_or_else(String::new, |hold| hold.reason.clone()),
    }
}

pub(crate) fn outcome(cell: &Cell, outcome: &v1::Outcome) -> Outcome {
    Outcome {
        header: header(cell.as_str()),
        placement_id: outcome.placement_id.clone(),
        item_id: outcome.item_id.clone(),
        kind: number(outcome.kind),
        failure: outcome.failure.clone(),
        has_pose: outcome.container_from_item.is_some(),
        pose: pose(outcome.container_from_item.as_ref()),
        is_found: outcome.is_found,
        is_inside: outcome.is_inside,
        slide_m: outcome.slide_m,
        tilt_rad: outcome.tilt_rad,
        state_number: outcome.state_number,
    }
}

/// The outcome that somebody tells of a decision.
pub(crate) fn read_outcome(decision_id: &str, outcome: &Outcome) -> v1::Outcome {
    let (at, turn) = (&outcome.pose.position, &outcome.pose.orientation);
    let pose = || v1::Pose {
        position: Some(v1::Vector3 {
            x_m: at.x,
            y_m: at.y,
            z_m: at.z,
        }),
        orientation: Some(v1::Quaternion {
            x: turn.x,
            y: turn.y,
            z: turn.z,
            w: turn.w,
        }),
    };
    v1::Outcome {
        placement_id: decision_id.to_owned(),
        item_id: outcome.item_id.clone(),
        kind: outcome.kind.into(),
        failure: outcome.failure.clone(),
        container_from_item: outcome.has_pose.then(pose),
        is_found: outcome.is_found,
        is_inside: outcome.is_inside,
        slide_m: outcome.slide_m,
        tilt_rad: outcome.tilt_rad,
        state_number: outcome.state_number,
    }
}

pub(crate) fn decision(cell: &Cell, decision: &v1::Decision) -> Decision {
    let container = match decision.container.as_str() {
        "" => cell.as_str(),
        name => name,
    };
    Decision {
        header: header(container),
        decision_id: decision.decision_id.clone(),
        session_id: decision.session_id.clone(),
        step: decision.step,
        item_id: decision.item_id.clone(),
        object: decision.object.clone(),
        container: decision.container.clone(),
        resting_pose: decision.pose,
        pose: pose(decision.container_from_item.as_ref()),
        value: decision.value,
        buffer: decision.buffer.clone(),
        state_number: decision.state_number,
        decided_at_ns: decision.decided_at_ns,
        degraded: decision.degraded.clone(),
    }
}

pub(crate) fn session(cell: &Cell, session: &v1::Session) -> Session {
    let pending = session.pending.as_ref();
    Session {
        header: header(cell.as_str()),
        session_id: session.session_id.clone(),
        items: session.items.iter().map(item).collect(),
        pending_decision_id: pending
            .map_or_else(String::new, |decision| decision.decision_id.clone()),
        step: session.step,
        is_automatic: session.is_automatic,
        buffer: session.buffer,
        end: number(session.end),
        failure: session.failure.clone(),
    }
}

pub(crate) fn item(item: &v1::SessionItem) -> Item {
    Item {
        item_id: item.item_id.clone(),
        object: item.object.clone(),
        state: number(item.state),
        container: item.container.clone(),
        pose: pose(item.container_from_item.as_ref()),
    }
}

/// The announcement of an item of the catalogue.
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

/// A number of an enumeration, numbered alike in ROS; what does not go into it is nobody's.
pub(crate) fn number(value: i32) -> u8 {
    u8::try_from(value).unwrap_or(u8::MAX)
}

/// Why items have no place, for people.
pub(crate) fn reasons(reasons: &[v1::ItemReason]) -> String {
    let reasons = reasons
        .iter()
        .map(|reason| format!("{}: {}", reason.item_id, reason.text));
    reasons.collect::<Vec<_>>().join("; ")
}
