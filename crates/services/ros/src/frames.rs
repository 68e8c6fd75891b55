//! Frames: where containers and items are, for `tf2`.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use nalgebra::Isometry3;
use ppnpack_ros::messages::builtin_interfaces::Time;
use ppnpack_ros::messages::geometry_msgs::{Quaternion, Transform, TransformStamped, Vector3};
use ppnpack_ros::messages::std_msgs::Header;
use ppnpack_ros::messages::tf2_msgs::TfMessage;
use ppnpack_ros::names::Name;
use ppnpack_ros::{Node, Publisher, Qos, RosError};
use ppnpack_wire::keys::Cell;

/// The frame that all others are in.
const WORLD: &str = "world";

/// The frame of a container, in which all coordinates are.
pub(crate) fn container(cell: &str) -> String {
    format!("{cell}/container")
}

/// The frame of an item that lies in a container.
pub(crate) fn item(cell: &Cell, item_id: &str) -> String {
    format!("{cell}/item/{item_id}")
}

/// Says where frames are.
pub(crate) struct Frames {
    moving: Publisher<TfMessage>,
    fixed: Publisher<TfMessage>,
    /// What is fixed, by the frame: whoever comes later is told of all.
    known: Mutex<BTreeMap<String, TransformStamped>>,
}

impl Frames {
    pub(crate) fn new(node: &Node) -> Result<Self, RosError> {
        let moving = Qos {
            depth: 100,
            ..Qos::EVENTS
        };
        Ok(Self {
            moving: node.publisher(&Name::new("/tf")?, moving)?,
            fixed: node.publisher(&Name::new("/tf_static")?, Qos::LATCHED)?,
            known: Mutex::default(),
        })
    }

    /// Where a container is from now on.
    pub(crate) fn fix_container(
        &self,
        cell: &Cell,
        world_from_container: &Isometry3<f64>,
    ) -> Result<(), RosError> {
        let frame = container(cell.as_str());
        let now = Time::now();
        let stamped = stamped(&now, WORLD.to_owned(), frame.clone(), world_from_container);
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        known.insert(frame, stamped);
        let transforms = known.values().cloned().collect();
        drop(known);
        self.fixed.publish(&TfMessage { transforms })
    }

    /// Where frames of a container were at a time.
    pub(crate) fn tell(
        &self,
        cell: &Cell,
        at: &Time,
        frames: impl IntoIterator<Item = (String, Isometry3<f64>)>,
    ) -> Result<(), RosError> {
        let transforms = frames.into_iter();
        let transforms = transforms
            .map(|(frame, pose)| stamped(at, container(cell.as_str()), frame, &pose))
            .collect::<Vec<_>>();
        if transforms.is_empty() {
            return Ok(());
        }
        self.moving.publish(&TfMessage { transforms })
    }
}

fn stamped(
    at: &Time,
    frame_id: String,
    child_frame_id: String,
    parent_from_child: &Isometry3<f64>,
) -> TransformStamped {
    let translation = parent_from_child.translation.vector;
    let rotation = parent_from_child.rotation.coords;
    TransformStamped {
        header: Header {
            stamp: at.clone(),
            frame_id,
        },
        child_frame_id,
        transform: Transform {
            translation: Vector3 {
                x: translation.x,
                y: translation.y,
                z: translation.z,
            },
            rotation: Quaternion {
                x: rotation.x,
                y: rotation.y,
                z: rotation.z,
                w: rotation.w,
            },
        },
    }
}
