//! Messages that wait to be written: a bounded queue that holds nobody up.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Instant;

use ppnpack_service::actor::Closed;
use ppnpack_service::clock::now_ns;
use ppnpack_service::sync::lock;
use zenoh::bytes::ZBytes;

use crate::topic::Topic;

/// Maximum of entries, however small.
const MOST_ENTRIES: usize = 65_536;

#[derive(Debug)]
pub(crate) struct Entry {
    pub(crate) topic: Topic,
    /// When it came, in nanoseconds since 1970.
    pub(crate) at_ns: u64,
    pub(crate) payload: ZBytes,
    /// Shapes that have to be in the file before it.
    pub(crate) shapes: Vec<NamedShape>,
}

/// The id of a [`Shape`](ppnpack_wire::v1::Shape), and its encoding.
pub(crate) type NamedShape = (Vec<u8>, ZBytes);

impl Entry {
    /// Takes a message that comes now and names no shapes.
    pub(crate) fn now(topic: Topic, payload: impl Into<ZBytes>) -> Self {
        Self {
            topic,
            at_ns: now_ns(),
            payload: payload.into(),
            shapes: Vec::new(),
        }
    }
}

/// A queue of at most so many bytes. Drops what does not fit, and counts it by channel.
pub(crate) struct Queue {
    state: Mutex<State>,
    arrived: Condvar,
    limit_bytes: usize,
}

#[derive(Default)]
struct State {
    entries: VecDeque<Entry>,
    bytes: usize,
    dropped: BTreeMap<Topic, u64>,
    is_closed: bool,
}

impl Queue {
    pub(crate) fn new(limit_bytes: usize) -> Self {
        Self {
            state: Mutex::default(),
            arrived: Condvar::new(),
            limit_bytes,
        }
    }

    /// Adds an entry, or drops it where there is no room.
    pub(crate) fn push(&self, entry: Entry) {
        let mut state = lock(&self.state);
        let bytes = state.bytes + entry.payload.len();
        if state.is_closed || bytes > self.limit_bytes || state.entries.len() >= MOST_ENTRIES {
            *state.dropped.entry(entry.topic).or_default() += 1;
            return;
        }
        state.bytes = bytes;
        state.entries.push_back(entry);
        drop(state);
        self.arrived.notify_one();
    }

    pub(crate) fn count_dropped(&self, topic: Topic) {
        *lock(&self.state).dropped.entry(topic).or_default() += 1;
    }

    /// Takes the next entry; `None` where none comes before the deadline.
    ///
    /// # Errors
    /// [`Closed`] once the queue is closed and empty.
    pub(crate) fn take(&self, deadline: Instant) -> Result<Option<Entry>, Closed> {
        let left = deadline.saturating_duration_since(Instant::now());
        let waits = |state: &mut State| state.entries.is_empty() && !state.is_closed;
        let state = lock(&self.state);
        let waited = self.arrived.wait_timeout_while(state, left, waits);
        let mut state = waited.unwrap_or_else(PoisonError::into_inner).0;
        match state.entries.pop_front() {
            Some(entry) => {
                state.bytes -= entry.payload.len();
                Ok(Some(entry))
            }
            None if state.is_closed => Err(Closed),
            None => Ok(None),
        }
    }

    /// Takes nothing more in; what is in it is still given.
    pub(crate) fn close(&self) {
        lock(&self.state).is_closed = true;
        self.arrived.notify_all();
    }

    pub(crate) fn dropped(&self) -> BTreeMap<Topic, u64> {
        lock(&self.state).dropped.clone()
    }
}

#[cfg(test)]
mod tests {
    use ppnpack_wire::keys::{Cell, Stream};

    use super::*;

    fn topic(stream: Stream) -> Topic {
        Topic::Stream(Cell::new("cell-1").unwrap(), stream)
    }

    fn entry(stream: Stream, bytes: usize) -> Entry {
        Entry::now(topic(stream), vec![0; bytes])
    }

    fn taken(queue: &Queue) -> Result<Option<usize>, Closed> {
        let taken = queue.take(Instant::now());
        taken.map(|entry| entry.map(|entry| entry.payload.len()))
    }

    #[test]
    fn what_does_not_fit_is_dropped_and_counted() {
        let queue = Queue::new(100);
        queue.push(entry(Stream::Plan, 60));
        queue.push(entry(Stream::Cloud, 50));
        queue.push(entry(Stream::Plan, 40));
        assert_eq!(taken(&queue), Ok(Some(60)));
        queue.push(entry(Stream::Cloud, 50));
        assert_eq!(taken(&queue), Ok(Some(40)));
        assert_eq!(taken(&queue), Ok(Some(50)));
        assert_eq!(taken(&queue), Ok(None));
        let dropped = BTreeMap::from([(topic(Stream::Cloud), 1)]);
        assert_eq!(queue.dropped(), dropped);
    }

    #[test]
    fn a_closed_queue_gives_what_is_in_it_and_ends() {
        let queue = Queue::new(100);
        queue.push(entry(Stream::Plan, 1));
        queue.close();
        queue.push(entry(Stream::Plan, 2));
        assert_eq!(taken(&queue), Ok(Some(1)));
        assert_eq!(taken(&queue), Err(Closed));
    }
}
