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
        if candidate >= self.candidates.len() {
            return None;
        }
        let taken = self.candidates.remove(candidate);
        self.refill();
        Some(taken)
    }

    fn refill(&mut self) {
        while self.candidates.len() < self.capacity
            && let Some(candidate) = self.arrivals.next()
        {
            self.candidates.push(candidate);
        }
    }
}
