//! A node of ROS 2 over Zenoh, as `rmw_zenoh` has them, without ROS.
//!
//! A [`Node`] publishes topics and answers services on any Zenoh session. Others find it by the
//! liveliness tokens that it declares ([`keys`]). Messages are structs ([`messages`]), put into
//! bytes as plain CDR ([`cdr`]). The protocol is that of Jazzy and later:
//! <https://github.com/ros2/rmw_zenoh/blob/rolling/docs/design.md>.
//!
//! Two crates have this protocol, and neither serves in place of this module:
//!
//! - `hiroz` 0.2.1 adds 88 packages to 620, and Zenoh's default features, serial lines and shared
//!   memory to every service. It opens a session of its own, never the stack's. `tests/ros2` holds
//!   this module against it.
//! - `ros2-client` 0.12.1 adds 64 packages and Zenoh's default features. Own types are sent under a
//!   hash of zeros, which no subscriber of `rmw_zenoh` matches. Publishers keep no last message.

pub(crate) mod cdr;
pub(crate) mod keys;
pub(crate) mod messages;
mod node;
mod service;

pub(crate) use node::{Node, Publisher};
pub(crate) use service::{Request, Server};
