//! `geometry_msgs`: lengths in metres, rotations as unit quaternions.

use super::messages;
use super::std_msgs::Header;

messages! {
    /// A point.
    Point = "geometry_msgs/msg/Point" {
        /// Along x.
        x: f64,
        /// Along y.
        y: f64,
        /// Along z.
        z: f64,
    }

    /// A direction or an extent.
    Vector3 = "geometry_msgs/msg/Vector3" {
        /// Along x.
        x: f64,
        /// Along y.
        y: f64,
        /// Along z.
        z: f64,
    }

    /// A rotation; the default is none, and no rotation of ROS.
    Quaternion = "geometry_msgs/msg/Quaternion" {
        /// The imaginary part along x.
        x: f64,
        /// The imaginary part along y.
        y: f64,
        /// The imaginary part along z.
        z: f64,
        /// The real part.
        w: f64,
    }

    /// Where something is and how it is turned.
    Pose = "geometry_msgs/msg/Pose" {
        /// Where its origin is.
        position: Point,
        /// How it is turned.
        orientation: Quaternion,
    }

    /// From one frame to another.
    Transform = "geometry_msgs/msg/Transform" {
        /// Where the origin of the other is.
        translation: Vector3,
        /// How the other is turned.
        rotation: Quaternion,
    }

    /// Where a frame is in another one.
    TransformStamped = "geometry_msgs/msg/TransformStamped" {
        /// When, and in which frame.
        header: Header,
        /// The frame that is told of.
        child_frame_id: String,
        /// Where it is.
        transform: Transform,
    }
}

impl Quaternion {
    /// No rotation.
    pub const IDENTITY: Self = Self {
        x: 0.0,
        y: 0.0,
        z: 0.0,
        w: 1.0,
    };
}
