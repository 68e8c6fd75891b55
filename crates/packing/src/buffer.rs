//! The buffer: the first items of a sequence that are not packed yet, from which a step may choose.

use crate::candidate::Candidate;

/// A sequence of arriving items seen through a buffer of limited size.
#[derive(Debug, Clone)]
pub struct Buffer {
    candidates: Vec<Candidate>,
    capacity: usize,
    arrivals: std::vec::IntoIter<Candidate>,
}

impl Buffer {
    /// The buffer of a sequence that lets a step choose among `capacity` items, at least one.
    pub fn new(sequence: Vec<Candidate>, capacity: usize) -> Self {
        let capacity = capacity.max(1);
        let mut buffer = Self {
            candidates: Vec::with_capacity(capacity),
            capacity,
            arrivals: sequence.into_iter(),
        };
        buffer.refill();
        buffer
    }

    /// The items a step may choose, in the order of arrival.
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    /// Takes a candidate out by its index and lets the next item arrive; `None` where there is no such candidate.
    pub fn take(&mut self, candidate: usize) -> Option<Candidate> {
        let is_held = candidate < self.candidates.len();
        let taken = is_held.then(|| self.candidates.remove(candidate));
        self.refill();
        taken
    }

    fn refill(&mut self) {
        let free = self.capacity - self.candidates.len();
        self.candidates.extend(self.arrivals.by_ref().take(free));
    }
}
