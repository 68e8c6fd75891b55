//! The protocol of a cell, as the pure state machines that planner and bridge are: no network, no disk, no clock.
//!
//! [`session`] is what the planner knows: which items came, what was decided, what became of it. [`ledger`] is what the
//! bridge knows: what was asked for, how it ended, what lies in the container. [`pursuit`] is what the one makes of the other's
//! answers. Their services write each change to disk before they acknowledge it. `tests/protocol` goes through all the ways in
//! which they can meet.

pub mod ledger;
pub mod message;
pub mod placing;
pub mod pursuit;
pub mod session;
