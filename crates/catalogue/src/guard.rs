//! A fence around geometry of other crates that panics on degenerate input.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs `work`; `None` where it panics.
///
/// parry's decomposition asserts and indexes where rounding defeats it, which depends on
/// the mesh of a user. `work` must own or discard everything that a panic could leave half done.
pub(crate) fn guarded<T>(work: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(work)).ok()
}
