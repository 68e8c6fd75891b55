//! Messages as bytes.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use ppnpack_ros::cdr::{self, Bytes};
use ppnpack_ros::messages::action_msgs::{CancelGoalRequest, GoalInfo};
use ppnpack_ros::messages::builtin_interfaces::Time;
use ppnpack_ros::messages::geometry_msgs::{Point, Pose, Quaternion};
use ppnpack_ros::messages::ppnpack_msgs::{Body, CellState};
use ppnpack_ros::messages::sensor_msgs::{PointCloud2, PointField};
use ppnpack_ros::messages::std_msgs::{Header, Text};
use ppnpack_ros::messages::std_srvs::TriggerRequest;
use ppnpack_ros::messages::unique_identifier_msgs::Uuid;
use proptest::prelude::*;

fn text(data: &str) -> Text {
    Text {
        data: data.to_owned(),
    }
}

#[test]
fn bytes_are_those_that_the_format_prescribes() {
    let hello = [&[0, 1, 0, 0, 6, 0, 0, 0][..], b"hello\0"];
    assert_eq!(cdr::encode(&text("hello")).unwrap(), hello.concat());
    assert_eq!(
        cdr::encode(&TriggerRequest::default()).unwrap(),
        [0_u8, 1, 0, 0, 0]
    );
    // Some leave the one byte of an empty message out.
    assert!(cdr::decode::<TriggerRequest>(&[0, 1, 0, 0]).is_ok());
    // An array has no length, and a number begins at a multiple of its size from the end of the first four bytes.
    let goal = CancelGoalRequest {
        goal_info: GoalInfo {
            goal_id: Uuid { uuid: [7; 16] },
            stamp: Time { sec: 1, nanosec: 2 },
        },
    };
    let expected: [&[u8]; 3] = [&[0, 1, 0, 0], &[7; 16], &[1, 0, 0, 0, 2, 0, 0, 0]];
    assert_eq!(cdr::encode(&goal).unwrap(), expected.concat());
}

#[test]
fn both_orders_of_bytes_are_read() {
    let big = [&[0, 0, 0, 0, 0, 0, 0, 3][..], b"hi\0"].concat();
    assert_eq!(cdr::decode::<Text>(&big).unwrap(), text("hi"));
    let refused: [(&[u8], &str); 5] = [
        (&[], "nothing"),
        (&[0, 1, 0, 0], "no message"),
        (&[0, 3, 0, 0, 1, 0, 0, 0, 0], "another encoding"),
        (
            &[0, 1, 0, 0, 255, 255, 255, 255, 0],
            "a length that is announced and not there",
        ),
        (&[0, 1, 0, 0, 2, 0, 0, 0, 0xff, 0], "no UTF-8"),
    ];
    for (payload, what) in refused {
        assert!(cdr::decode::<Text>(payload).is_err(), "{what}");
    }
}

fn pose() -> impl Strategy<Value = Pose> {
    any::<[f64; 7]>().prop_map(|[x, y, z, i, j, k, w]| Pose {
        position: Point { x, y, z },
        orientation: Quaternion {
            x: i,
            y: j,
            z: k,
            w,
        },
    })
}

fn state() -> impl Strategy<Value = CellState> {
    let body = (".{0,8}", pose(), any::<[bool; 2]>());
    let body = body.prop_map(|(item_id, pose, [is_inside, is_found])| Body {
        object: format!("{item_id}."),
        item_id,
        pose,
        is_inside,
        is_found,
    });
    let bodies = proptest::collection::vec(body, 0..4);
    (any::<(i32, u64)>(), ".{0,5}", bodies).prop_map(|((sec, state_number), text, bodies)| {
        CellState {
            header: Header {
                stamp: Time { sec, nanosec: 7 },
                frame_id: text.clone(),
            },
            state_number,
            bodies,
            hold_reason: text,
            ..CellState::default()
        }
    })
}

proptest! {
    #[test]
    fn messages_are_read_as_they_were_written(state in state()) {
        let payload = cdr::encode(&state).unwrap();
        // NaN is not equal to itself, but its bytes are.
        let read: CellState = cdr::decode(&payload).unwrap();
        prop_assert_eq!(cdr::encode(&read).unwrap(), payload);
    }

    #[test]
    fn what_is_cut_is_refused_and_never_panics(state in state(), cut in any::<prop::sample::Index>()) {
        let payload = cdr::encode(&state).unwrap();
        let cut = cut.index(payload.len());
        prop_assert!(cdr::decode::<CellState>(&payload[..cut]).is_err());
    }

    #[test]
    fn whatever_comes_is_read_or_refused(payload in proptest::collection::vec(any::<u8>(), 0..200)) {
        cdr::decode::<CellState>(&payload).ok();
        cdr::decode::<PointCloud2>(&payload).ok();
    }

    #[test]
    fn bytes_are_taken_as_a_whole(data in proptest::collection::vec(any::<u8>(), 0..100)) {
        let cloud = PointCloud2 {
            fields: vec![PointField { name: "x".to_owned(), ..PointField::default() }],
            data: Bytes(data),
            is_dense: true,
            ..PointCloud2::default()
        };
        let payload = cdr::encode(&cloud).unwrap();
        prop_assert_eq!(cdr::decode::<PointCloud2>(&payload).unwrap(), cloud);
    }
}
