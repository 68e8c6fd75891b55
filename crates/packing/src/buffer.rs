//! The buffer: the first items of a sequence that are not packed yet, from which a step may choose.

use std::iter::Peekable;
use std::vec::IntoIter;

use crate::candidate::Candidate;

/// A sequence of arriving items seen through a buffer of limited size.
///
/// The candidates of an item, one for each of its poses, stand next to each other: they arrive together, count as one
/// item, and leave together.
#[derive(Debug, Clone)]
pub struct Buffer {
    candidates: Vec<Candidate>,
    capacity: usize,
    arrivals: Peekable<IntoIter<Candidate>>,
}

impl Buffer {
    /// The buffer of a sequence that lets a step choose among `capacity` items, at least one. Neighbours in the
    /// sequence with the same arrival are the poses of one item.
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

    /// What a step may choose: the items in the order of arrival, each in all of its poses.
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    /// The items in the order of arrival: the candidates of each.
    pub fn items(&self) -> impl Iterator<Item = &[Candidate]> {
        self.candidates.chunk_by(|a, b| a.arrival == b.arrival)
    }

    /// Takes a candidate out by its index, with the other poses of its item, and lets the next item arrive; `None`
    /// where there is no such candidate.
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::item::{Item, ViewSurfaces};

    /// Items with so many poses each.
    fn sequence(poses: &[usize]) -> Vec<Candidate> {
        let surfaces = ViewSurfaces::of_cells(1, 1, vec![1], vec![0]);
        let item = Arc::new(Item::new("cell", vec![surfaces], 0.0).unwrap());
        let of_item = |(arrival, poses): (usize, &usize)| {
            let item = Arc::clone(&item);
            (0..*poses).map(move |pose| Candidate {
                pose,
                ..Candidate::new(arrival, Arc::clone(&item))
            })
        };
        poses.iter().enumerate().flat_map(of_item).collect()
    }

    fn held(buffer: &Buffer) -> Vec<(usize, usize)> {
        let candidates = buffer.candidates().iter();
        candidates.map(|held| (held.arrival, held.pose)).collect()
    }

    #[test]
    fn the_capacity_counts_items_whatever_their_poses() {
        let mut buffer = Buffer::new(sequence(&[1, 3, 2, 1]), 2);
        assert_eq!(held(&buffer), [(0, 0), (1, 0), (1, 1), (1, 2)]);
        assert_eq!(buffer.items().count(), 2);
        let taken = buffer.take(2).unwrap();
        assert_eq!((taken.arrival, taken.pose), (1, 1));
        assert_eq!(held(&buffer), [(0, 0), (2, 0), (2, 1)]);
        buffer.take(0).unwrap();
        assert_eq!(held(&buffer), [(2, 0), (2, 1), (3, 0)]);
        assert!(buffer.take(3).is_none());
        buffer.take(1).unwrap();
        buffer.take(0).unwrap();
        assert!(buffer.candidates().is_empty() && buffer.take(0).is_none());
    }

    #[test]
    fn a_buffer_holds_one_item_at_least() {
        let buffer = Buffer::new(sequence(&[2, 1]), 0);
        assert_eq!(held(&buffer), [(0, 0), (0, 1)]);
    }
}
