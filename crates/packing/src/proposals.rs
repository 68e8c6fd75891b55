//! Proposals: the placements of each candidate that a step evaluates.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::item::Item;
use crate::placement::Placement;
use crate::step::{StageError, StepInput};
use crate::{grid::Grid, random};

/// The placements proposed for one candidate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CandidateProposals<'a> {
    /// Every possible one.
    All,
    /// These. One that leaves the container is never valid.
    Some(&'a [Placement]),
}

/// The proposals of a step, per candidate; a candidate that nothing was said of has none.
#[derive(Debug, Clone, Default)]
pub struct Proposals {
    placements: Vec<Placement>,
    /// Per candidate: the range of its placements, or `None` for all.
    ranges: Vec<Option<std::ops::Range<usize>>>,
}

impl Proposals {
    /// Forgets all proposals, keeping the memory.
    pub fn clear(&mut self) {
        self.placements.clear();
        self.ranges.clear();
    }

    /// Adds the next candidate, with every possible placement.
    pub fn push_all(&mut self) {
        self.ranges.push(None);
    }

    /// Adds the next candidate, with these placements.
    pub fn push(&mut self, placements: impl IntoIterator<Item = Placement>) {
        let start = self.placements.len();
        self.placements.extend(placements);
        self.ranges.push(Some(start..self.placements.len()));
    }

    /// What is proposed for a candidate.
    pub fn of(&self, candidate: usize) -> CandidateProposals<'_> {
        match self.ranges.get(candidate) {
            Some(None) => CandidateProposals::All,
            Some(Some(range)) => {
                CandidateProposals::Some(self.placements.get(range.clone()).unwrap_or(&[]))
            }
            None => CandidateProposals::Some(&[]),
        }
    }
}

/// Proposes placements for every candidate of a step: the first stage of Algorithm 1.
pub trait Proposer: Send {
    /// Fills `proposals` with one entry per candidate, in their order.
    ///
    /// # Errors
    /// What kept the proposer from answering.
    fn propose(
        &mut self,
        input: &StepInput<'_>,
        proposals: &mut Proposals,
    ) -> Result<(), StageError>;
}

/// Proposes every placement: the exhaustive search.
#[derive(Debug, Clone, Copy, Default)]
pub struct ProposeAll;

impl Proposer for ProposeAll {
    fn propose(
        &mut self,
        input: &StepInput<'_>,
        proposals: &mut Proposals,
    ) -> Result<(), StageError> {
        proposals.clear();
        input.candidates.iter().for_each(|_| proposals.push_all());
        Ok(())
    }
}

/// The share of placements that is proposed, in percent: `K`.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Percent(f64);

/// A share that is not above 0 and at most 100.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("the share of placements K must be above 0 and at most 100 percent, but is {0}")]
pub struct PercentError(f64);

impl Percent {
    /// A share in percent.
    ///
    /// # Errors
    /// [`PercentError`] where it is not above 0 and at most 100.
    pub fn new(percent: f64) -> Result<Self, PercentError> {
        if percent > 0.0 && percent <= 100.0 {
            Ok(Self(percent))
        } else {
            Err(PercentError(percent))
        }
    }

    /// The share, in percent.
    pub fn percent(self) -> f64 {
        self.0
    }

    /// The share of a number of placements, rounded up.
    pub fn of(self, placements: u64) -> u64 {
        (placements as f64 * self.0 / 100.0).ceil() as u64
    }
}

/// Proposes a random share of each candidate's possible placements.
#[derive(Debug, Clone)]
pub struct ProposeRandom {
    share: Percent,
    seed: u64,
}

impl ProposeRandom {
    /// Proposes `share` of the placements, drawn with this seed.
    pub fn new(share: Percent, seed: u64) -> Self {
        Self { share, seed }
    }
}

impl Proposer for ProposeRandom {
    fn propose(
        &mut self,
        input: &StepInput<'_>,
        proposals: &mut Proposals,
    ) -> Result<(), StageError> {
        proposals.clear();
        for candidate in input.candidates {
            let stream = random::mix(random::mix(self.seed, input.step), candidate.arrival as u64);
            let mut random = ChaCha8Rng::seed_from_u64(stream);
            let possible = possible_count(input.grid, &candidate.item);
            let mut wanted = self.share.of(possible);
            // Selection sampling (Knuth, algorithm S): one pass, each subset equally likely, in order.
            let mut left = possible;
            proposals.push(
                possible_placements(input.grid, &candidate.item).filter(|_| {
                    let chosen = random.random_range(0..left.max(1)) < wanted;
                    left = left.saturating_sub(1);
                    wanted -= u64::from(chosen);
                    chosen
                }),
            );
        }
        Ok(())
    }
}

/// How many placements of an item lie within the container, over all yaws.
pub fn possible_count(grid: &Grid, item: &Item) -> u64 {
    item.views()
        .iter()
        .map(|view| offsets(grid.nx(), view.nx()) as u64 * offsets(grid.ny(), view.ny()) as u64)
        .sum()
}

/// The placements of an item that lie within the container, by yaw, x, y.
pub fn possible_placements(grid: &Grid, item: &Item) -> impl Iterator<Item = Placement> {
    let (nx, ny) = (grid.nx(), grid.ny());
    item.views()
        .iter()
        .enumerate()
        .flat_map(move |(yaw, view)| {
            let along_y = offsets(ny, view.ny());
            (0..offsets(nx, view.nx()))
                .flat_map(move |x| (0..along_y).map(move |y| Placement { yaw, x, y }))
        })
}

fn offsets(cells: usize, footprint: usize) -> usize {
    (cells + 1).saturating_sub(footprint)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_outside_0_to_100_are_refused() {
        for percent in [0.0, -1.0, 100.1, f64::NAN] {
            assert!(Percent::new(percent).is_err(), "{percent}");
        }
        assert_eq!(Percent::new(5.0).unwrap().of(1001), 51);
    }
}
