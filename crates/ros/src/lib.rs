//! Nodes of ROS 2 over Zenoh, as `rmw_zenoh` has them, without ROS.
//!
//! A [`Node`] publishes topics, answers services and carries out the goals of actions, on any Zenoh session. Others find it
//! by the liveliness tokens that it declares ([`keys`]): it is listed by `ros2 node list`, its topics by `ros2 topic list`. Messages are
//! structs ([`messages`]) whose type hash is made of their own fields ([`description`]), so that what is announced and what is sent cannot
//! differ, and are put into bytes as plain CDR ([`cdr`]).
//!
//! The protocol is that of `rmw_zenoh` for ROS 2 Jazzy and later: <https://github.com/ros2/rmw_zenoh/blob/rolling/docs/design.md>.
//!
//! ```
//! use ppnpack_ros::description::TypeHash;
//! use ppnpack_ros::messages::tf2_msgs::TfMessage;
//!
//! assert_eq!(
//!     TypeHash::of_message::<TfMessage>().to_string(),
//!     "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"
//! );
//! ```

pub mod action;
mod attachment;
pub mod cdr;
pub mod description;
mod error;
pub mod keys;
mod latched;
pub mod messages;
pub mod names;
pub mod node;
pub mod publisher;
pub mod qos;
pub mod service;

pub use error::RosError;
pub use node::Node;
pub use publisher::Publisher;
pub use qos::Qos;
