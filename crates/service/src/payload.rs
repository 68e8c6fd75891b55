//! Payloads of Zenoh, read as messages.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use ::metrics::Counter;
use ppnpack_wire::error::check_size;
use ppnpack_wire::{WireError, decode};
use prost::{Message, Name};
use zenoh::bytes::ZBytes;

use crate::metrics::{self, Metric};

/// Decodes a payload of at most `limit` bytes; a larger one is not even put together.
pub(crate) fn read<M: Message + Name + Default>(
    payload: &ZBytes,
    limit: usize,
) -> Result<M, WireError> {
    check_size(M::NAME, payload.len(), limit)?;
    decode(&payload.to_bytes(), limit)
}

/// Counts malformed messages, and writes at most one line a second about them.
pub(crate) struct Malformed {
    kind: String,
    counter: Counter,
    since: Instant,
    /// The time of the last line, in seconds since `since`, and one more.
    last_line_s: AtomicU64,
}

impl Malformed {
    /// Counts those of a kind: a stream, or a service and method.
    pub(crate) fn new(kind: String) -> Self {
        Self {
            counter: metrics::counter(Metric::MalformedTotal, &[("kind", &kind)]),
            kind,
            since: Instant::now(),
            last_line_s: AtomicU64::new(0),
        }
    }

    pub(crate) fn count(&self, error: &dyn std::fmt::Display) {
        self.counter.increment(1);
        let now_s = self.since.elapsed().as_secs() + 1;
        if self.last_line_s.swap(now_s, Ordering::Relaxed) != now_s {
            tracing::warn!(kind = self.kind, %error, "malformed message refused");
        }
    }
}
