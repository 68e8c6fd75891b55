//! The arm of a physical cell: six joints, a suction cup, a container to fill from above.
//!
//! [`Arm`](arm::Arm) is made of a parameter file or [by name](arms); [`pick::find`] says where its cup holds an item;
//! [`PlacePlanner`](motion::PlacePlanner) plans the motion that places it, checked for reach, joint ranges,
//! singularities and collisions; [`ArmCheck`](feasibility::ArmCheck) is that as one more validity check of the
//! planning engine.
//! [`plan_cycle`](motion::PlacePlanner::plan_cycle) adds the pick and the transfer, and times it all.
//! [`ArmStation`](station::ArmStation) is all of it made of settings.
//!
//! All positions are in the container frame: metres, right-handed, z up, the origin at an inner bottom corner.

pub mod arm;
pub mod arms;
pub mod cell;
mod clearance;
mod columns;
pub mod cycle;
pub mod error;
pub mod feasibility;
pub mod gripper;
pub mod joints;
pub mod kinematics;
pub mod motion;
pub mod parameters;
pub mod path;
pub mod pick;
pub mod refusal;
pub mod shapes;
pub mod station;
pub mod surface;
mod surroundings;
mod track;
pub mod trajectory;
