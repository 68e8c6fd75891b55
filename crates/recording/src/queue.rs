//! What came and was not written yet: a queue with a bound, that holds nobody up.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Instant;

use ppnpack_service::sync::lock;
use zenoh::bytes::ZBytes;

use crate::topic::Topic;

/// Entries at most, however small.
const MOST_ENTRIES: usize = 65_536;

/// A message of a channel.
#[derive(Debug, Clone)]
pub(crate) struct Sample {
    pub(crate) topic: Topic,
    /// When it came, in nanoseconds since 1970.
    pub(crate) at_ns: u64,
    pub(crate) payload: ZBytes,
}

/// Something to be written.
#[derive(Debug, Clone)]
pub(crate) struct Entry {
    pub(crate) sample: Sample,
    /// Which must be in the file before it, each by its id.
    pub(crate) shapes: Vec<NamedShape>,
}

/// An encoded [`Shape`](ppnpack_wire::v1::Shape), and its id.
#[derive(Debug, Clone)]
pub(crate) struct NamedShape {
    pub(crate) id: Vec<u8>,
    pub(crate) payload: ZBytes,
}

impl Entry {
    pub(crate) fn new(sample: Sample) -> Self {
        Self {
            sample,
            shapes: Vec::new(),
        }
    }

    fn bytes(&self) -> usize {
        self.sample.payload.len()
    }
}

/// A queue of samples that takes at most so many bytes. What does not fit is dropped, and counted by channel.
#[derive(Debug)]
pub(crate) struct Queue {
    state: Mutex<State>,
    arrived: Condvar,
    limit_bytes: usize,
}

#[derive(Debug, Default)]
struct State {
    entries: VecDeque<Entry>,
    bytes: usize,
    dropped: BTreeMap<Topic, u64>,
    is_closed: bool,
}

/// What a queue gives.
#[derive(Debug)]
pub(crate) enum Taken {
    Entry(Box<Entry>),
    /// Nothing came before the deadline.
    Nothing,
    /// Nothing comes any more.
    End,
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
        let bytes = entry.bytes();
        let has_room = state.bytes + bytes <= self.limit_bytes;
        if state.is_closed || !has_room || state.entries.len() >= MOST_ENTRIES {
            *state.dropped.entry(entry.sample.topic).or_default() += 1;
            return;
        }
        state.bytes += bytes;
        state.entries.push_back(entry);
        drop(state);
        self.arrived.notify_one();
    }

    /// Counts a sample that was dropped elsewhere.
    pub(crate) fn count_dropped(&self, topic: &Topic) {
        *lock(&self.state).dropped.entry(topic.clone()).or_default() += 1;
    }

    /// The next entry; waits for it until the deadline.
    pub(crate) fn take(&self, deadline: Instant) -> Taken {
        let left = deadline.saturating_duration_since(Instant::now());
        let waits = |state: &mut State| state.entries.is_empty() && !state.is_closed;
        let waited = self
            .arrived
            .wait_timeout_while(lock(&self.state), left, waits);
        let mut state = waited.unwrap_or_else(PoisonError::into_inner).0;
        match state.entries.pop_front() {
            Some(entry) => {
                state.bytes -= entry.bytes();
                Taken::Entry(Box::new(entry))
            }
            None if state.is_closed => Taken::End,
            None => Taken::Nothing,
        }
    }

    /// Takes nothing more; what is in it is still given.
    pub(crate) fn close(&self) {
        lock(&self.state).is_closed = true;
        self.arrived.notify_all();
    }

    /// How many samples were dropped so far, by channel.
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
        Entry::new(Sample {
            topic: topic(stream),
            at_ns: 0,
            payload: vec![0; bytes].into(),
        })
    }

    fn taken(queue: &Queue) -> Option<usize> {
        match queue.take(Instant::now()) {
            Taken::Entry(entry) => Some(entry.bytes()),
            Taken::Nothing | Taken::End => None,
        }
    }

    #[test]
    fn what_does_not_fit_is_dropped_and_counted() {
        let queue = Queue::new(100);
        queue.push(entry(Stream::Plan, 60));
        queue.push(entry(Stream::Cloud, 50));
        queue.push(entry(Stream::Plan, 40));
        assert_eq!(taken(&queue), Some(60));
        queue.push(entry(Stream::Cloud, 50));
        assert_eq!([taken(&queue), taken(&queue)], [Some(40), Some(50)]);
        assert_eq!(taken(&queue), None);
        let dropped = queue.dropped().into_iter().collect::<Vec<_>>();
        assert_eq!(dropped, [(topic(Stream::Cloud), 1)]);
    }

    #[test]
    fn a_closed_queue_gives_what_is_in_it_and_ends() {
        let queue = Queue::new(100);
        queue.push(entry(Stream::Plan, 1));
        queue.close();
        queue.push(entry(Stream::Plan, 2));
        assert_eq!(taken(&queue), Some(1));
        assert!(matches!(queue.take(Instant::now()), Taken::End));
    }
}
