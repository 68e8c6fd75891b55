//! The protocol of a cell, as pure state machines: no network, no disk, no clock.
//!
//! [`session`] is the planner's: the items that came, the decisions on them and the outcomes.
//! [`ledger`] is the bridge's: the placements that were asked for, their ends, and the content of
//! the container. [`pursuit`] follows a decision by the bridge's answers. The services write each
//! change to disk before they acknowledge it. `tests/protocol` explores all the ways in which they
//! can meet.

pub mod ledger;
pub mod message;
pub mod placing;
pub mod pursuit;
pub mod session;
