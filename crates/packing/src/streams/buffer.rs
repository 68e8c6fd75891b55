//! The buffer: the first items of a sequence that are not packed yet, from which a step may choose.

use std::iter::Peekable;
use std::vec::IntoIter;

use crate::ranking::step::Candidate;

/// A sequence of arriving items seen through a buffer of limited size.
///
/// The candidates of an item, one for each of its poses, stand next to each other: they arrive
/// together, count as one item, and leave together.
#[derive(Debug, Clone)]
pub struct Buffer {
    candidates: Vec<Candidate>,
    capacity: usize,
    arrivals: Peekable<IntoIter<Candidate>>,
}

impl Buffer {
    /// The buffer of a sequence that lets a step choose among `capacity` items, at least one.
    /// Neighbours in the sequence with the same arrival are the poses of one item.
    pub fn new(sequence: Vec<Candidate>, capacity: usize) -> Self {
        let capacity = capacity.max(1);
        let mut buffer = Self {
            candidates: Vec::with_capacity(capacity),
            capacity,
            arrivals: sequence.into_iter().peekable(),
        };
        buffer.refill();
        buffer
    }

    /// Gives the items a step may choose among, in the order of arrival, each in all of its poses.
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    /// The items in the order of arrival: the candidates of each.
    pub fn items(&self) -> impl Iterator<Item = &[Candidate]> {
        self.candidates.chunk_by(|a, b| a.arrival == b.arrival)
    }

    /// Takes a candidate out by its index, with the other poses of its item, and lets the next item
    /// arrive; `None` where there is no such candidate.
    pub fn take(&mut self, candidate: usize) -> Option<Candidate> {
        let taken = self.candidates.get(candidate)?.clone();
        self.candidates.retain(|held| held.arrival != taken.arrival);
        self.refill();
        Some(taken)
    }

    fn refill(&mut self) {
        for _ in self.items().count()..self.capacity {
            let Some(first) = self.arrivals.next() else {
                return;
            };
            let arrival = first.arrival;
            self.candidates.push(first);
            while let Some(pose) = self.arrivals.next_if(|next| next.arrival == arrival) {
                self.candidates.push(pose);
            }
        }
    }
}
