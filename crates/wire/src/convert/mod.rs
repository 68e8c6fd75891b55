//! Conversions between messages and types of the domain, one module per message.
//!
//! `read` checks everything that the schemas promise and gives the domain's type; `write` is its
//! inverse. A value is read as it was written, bit for bit, but for the sign of a zero.

pub mod check;
pub mod cloud;
pub mod cycle;
mod execution;
pub mod grid;
pub mod item;
pub mod load;
mod numbers;
pub mod objective;
mod pairs;
pub mod placement;
pub mod pose;
pub mod scene;
pub mod settling;
pub mod solid;
