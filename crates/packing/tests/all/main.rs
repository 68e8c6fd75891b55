//! The engine against slow references, golden vectors and examples, in one program.
#![cfg(test)]

mod allocations;
mod coarse;
mod drawn;
mod expected;
mod golden;
mod hidden;
mod invariants;
mod kernels;
mod limits;
mod loads;
mod orders;
mod planning;
mod raster;
mod rooms;
mod scene_value;
mod search;
mod setting_aside;
mod streams;
mod support;
mod tapered;
