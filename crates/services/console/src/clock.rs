//! The time of day, as pages are told it.

/// Milliseconds since 1970.
pub(crate) fn now_ms() -> u64 {
    ppnpack_service::clock::now_ns() / 1_000_000
}
