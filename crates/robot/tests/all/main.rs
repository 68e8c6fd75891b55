//! The arm from outside.
#![cfg(test)]

mod common;
mod cycle;
mod feasibility;
mod kinematics;
mod oracle;
mod pick;
mod station;
