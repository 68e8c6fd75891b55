//! From messages of the stack to those of ROS.

pub(crate) mod markers;
pub(crate) mod messages;
