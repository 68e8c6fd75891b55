//! The arm: what it can hold, its check against brute force, where pruned proposals pay with it.

pub(crate) mod holding;
pub(crate) mod oracle;
pub(crate) mod proposals;

/// Random placements and the brute-force oracle of the tests of `robot`.
#[path = "../../../robot/tests/common/mod.rs"]
mod common;
