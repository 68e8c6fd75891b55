//! What each service of a cell says in ROS.

pub(crate) mod bridge;
mod follow;
mod pack;
pub(crate) mod perception;
pub(crate) mod planner;
mod sessions;
