//! The perception service over real sessions: heightmaps, items that are recognised on trays and
//! found again after they were placed.
#![cfg(test)]

mod inspecting;
#[path = "../../../../wire/tests/support/payload.rs"]
mod payload;
mod rig;
mod ros;
mod serving;
mod trays;
