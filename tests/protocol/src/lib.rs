//! The protocol of a cell, exhausted.
//!
//! The planner's session, the bridge's ledger and what the one makes of the other's answers are the
//! code that ships (`ppnpack-protocol`). Around them, here, is what they meet: requests that are
//! lost, late, doubled and out of order, processes that are killed between any two steps, disks
//! that are lost or restored from a backup, a robot that goes on when nobody watches it, pictures
//! of any age, people who hold the cell, reach into it and acknowledge.
//!
//! [`World`] is all of that at one moment and [`Action`] what may happen next.
//! [`Exhaust`](exhaust::Exhaust) has stateright go through every order in which it can;
//! [`wander`](wander::wander) goes through random ones of larger worlds. What breaks a promise of
//! docs/reliability.md is a [`Broken`], and [`shrink`](wander::shrink) makes the shortest story of
//! it.

mod action;
mod bridge;
mod canonical;
pub mod configuration;
mod driver;
pub mod exhaust;
mod people;
mod planner;
mod recovery;
mod shared;
pub mod wander;
mod world;

pub use action::Action;
pub use configuration::Configuration;
pub use world::{Broken, World};
