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
    /// Every possible one at some yaws.
    AllAt(YawRange),
    /// These. One that leaves the container is never valid.
    Some(&'a [Placement]),
}

/// Consecutive yaws of a resolution: those from `first` to below `end`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct YawRange {
    /// Index of the first yaw.
    pub first: usize,
    /// Index after the last one.
    pub end: usize,
}

impl YawRange {
    /// All yaws of an item.
    pub fn all(item: &Item) -> Self {
        Self {
            first: 0,
            end: item.views().len(),
        }
    }

    /// Whether a yaw is among them.
    pub fn contains(self, yaw: usize) -> bool {
        (self.first..self.end).contains(&yaw)
    }
}

/// What is proposed for one candidate, with its placements kept elsewhere.
#[derive(Debug, Clone)]
enum Entry {
    All,
    AllAt(YawRange),
    Some(std::ops::Range<usize>),
}

/// The proposals of a step, per candidate; a candidate that nothing was said of has none.
#[derive(Debug, Clone, Default)]
pub struct Proposals {
    placements: Vec<Placement>,
    entries: Vec<Entry>,
    /// Why these are not the proposals that were wanted.
    degraded: Option<String>,
}

impl Proposals {
    /// Forgets all proposals, keeping the memory.
    pub fn clear(&mut self) {
        self.placements.clear();
        self.entries.clear();
        self.degraded = None;
    }

    /// Says that these proposals stand in for those that were wanted, and why.
    pub fn degrade(&mut self, reason: impl Into<String>) {
        self.degraded = Some(reason.into());
    }

    /// Why these proposals stand in for others, where they do.
    pub fn degraded(&self) -> Option<&str> {
        self.degraded.as_deref()
    }

    /// Adds the next candidate, with every possible placement.
    pub fn push_all(&mut self) {
        self.entries.push(Entry::All);
    }

    /// Adds the next candidate, with every possible placement at these yaws.
    pub fn push_all_at(&mut self, yaws: YawRange) {
        self.entries.push(Entry::AllAt(yaws));
    }

    /// Adds the next candidate, with these placements.
    pub fn push(&mut self, placements: impl IntoIterator<Item = Placement>) {
        let start = self.placements.len();
        self.placements.extend(placements);
        let end = self.placements.len();
        self.entries.push(Entry::Some(start..end));
    }

    /// Whether some placement of some candidate is not proposed, as far as is known without counting.
    pub(crate) fn is_pruned(&self) -> bool {
        let is_all = |entry: &Entry| matches!(entry, Entry::All);
        !self.entries.iter().all(is_all)
    }

    /// Proposes everything for all candidates.
    pub(crate) fn widen(&mut self) {
        self.placements.clear();
        self.entries.fill(Entry::All);
    }

    /// What is proposed for a candidate.
    pub fn of(&self, candidate: usize) -> CandidateProposals<'_> {
        match self.entries.get(candidate) {
            Some(Entry::All) => CandidateProposals::All,
            Some(Entry::AllAt(yaws)) => CandidateProposals::AllAt(*yaws),
            Some(Entry::Some(range)) => {
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

/// A proposer whose failure does not end the planning: the search is exhaustive then, and the plan says why.
pub struct OrExhaustive {
    proposer: Result<Box<dyn Proposer>, String>,
    reason: Option<String>,
}

impl OrExhaustive {
    /// Asks a proposer, as long as it answers.
    pub fn new(proposer: Box<dyn Proposer>) -> Self {
        Self {
            proposer: Ok(proposer),
            reason: None,
        }
    }

    /// Stands in for a proposer that is not there, for this reason.
    pub fn instead(reason: impl Into<String>) -> Self {
        Self {
            proposer: Err(reason.into()),
            reason: None,
        }
    }

    /// Logs a reason when it is new.
    fn note(&mut self, reason: Option<String>) {
        if self.reason != reason {
            match &reason {
                Some(reason) => tracing::warn!(reason, "searching exhaustively"),
                None => tracing::info!("the proposer answers again"),
            }
            self.reason = reason;
        }
    }
}

impl Proposer for OrExhaustive {
    fn propose(
        &mut self,
        input: &StepInput<'_>,
        proposals: &mut Proposals,
    ) -> Result<(), StageError> {
        let reason = match &mut self.proposer {
            Ok(proposer) => proposer
                .propose(input, proposals)
                .err()
                .map(|error| error.to_string()),
            Err(reason) => Some(reason.clone()),
        };
        if let Some(reason) = &reason {
            ProposeAll.propose(input, proposals)?;
            proposals.degrade(reason.as_str());
        }
        self.note(reason);
        Ok(())
    }
}

/// The share of all placements `|P|` that is proposed, in percent: `K`.
///
/// `|P|` counts every yaw and cell of the grid ([`all_count`]), as the paper does. Some of these placements leave the
/// container, so `K` % of `|P|` is a larger share of those that are possible.
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

    /// This many times the share, and all at most.
    #[must_use]
    pub(crate) fn times(self, factor: f64) -> Self {
        Self((self.0 * factor).min(100.0))
    }

    /// The share of a number of placements, rounded up.
    pub fn of(self, placements: u64) -> u64 {
        (placements as f64 * self.0 / 100.0).ceil() as u64
    }
}

/// Proposes `K` % of `|P|` for each candidate, drawn from its possible placements; all of them where they are fewer.
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
            let mut wanted = self
                .share
                .of(all_count(input.grid, &candidate.item))
                .min(possible);
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

/// All placements `|P|` of an item: its yaws times the container's cells.
pub fn all_count(grid: &Grid, item: &Item) -> u64 {
    (item.views().len() * grid.nx() * grid.ny()) as u64
}

/// How many placements of an item lie within the container, over all yaws.
pub fn possible_count(grid: &Grid, item: &Item) -> u64 {
    possible_count_at(grid, item, YawRange::all(item))
}

/// How many placements of an item at some yaws lie within the container.
pub fn possible_count_at(grid: &Grid, item: &Item, yaws: YawRange) -> u64 {
    let views = item.views().iter().take(yaws.end).skip(yaws.first);
    views
        .map(|view| offsets(grid.nx(), view.nx()) as u64 * offsets(grid.ny(), view.ny()) as u64)
        .sum()
}

/// How many placements of an item lie within the container, over all yaws; 0 for one that is taller than it.
pub fn possible_count_below_rim(grid: &Grid, item: &Item) -> u64 {
    let mut views = item.views().iter();
    if views.any(|view| view.height() <= grid.rim()) {
        possible_count(grid, item)
    } else {
        0
    }
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

    /// Fails every second time.
    struct Unsteady(u32);

    impl Proposer for Unsteady {
        fn propose(
            &mut self,
            input: &StepInput<'_>,
            proposals: &mut Proposals,
        ) -> Result<(), StageError> {
            self.0 += 1;
            proposals.clear();
            if self.0.is_multiple_of(2) {
                return Err("out of order".into());
            }
            input.candidates.iter().for_each(|_| proposals.push([]));
            Ok(())
        }
    }

    #[test]
    fn a_failing_proposer_gives_way_to_the_exhaustive_search_and_the_reason_is_kept() {
        use crate::heightmap::{Heightmap, Scene};
        use crate::item::ViewSurfaces;
        let grid = Grid::reference();
        let view = ViewSurfaces {
            nx: 1,
            ny: 1,
            top: vec![1],
            bottom: vec![0],
            underside: None,
            origin_from_corner_m: nalgebra::Vector3::zeros(),
            centre_of_mass_m: None,
        };
        let item = Item::new("cube", vec![view; 4], 0.0).unwrap();
        let scene = Scene::from_heightmap(Heightmap::empty(&grid));
        let candidates = [crate::step::Candidate::new(0, std::sync::Arc::new(item))];
        let input = StepInput::new(&grid, &scene, &candidates);
        let mut proposals = Proposals::default();
        let mut proposer = OrExhaustive::new(Box::new(Unsteady(0)));
        for round in 0..4 {
            proposer.propose(&input, &mut proposals).unwrap();
            let fails = round % 2 == 1;
            let expected = fails.then_some("out of order");
            assert_eq!(proposals.degraded(), expected, "round {round}");
            let all = proposals.of(0) == CandidateProposals::All;
            assert_eq!(all, fails, "round {round}");
        }
        let mut absent = OrExhaustive::instead("no weights");
        absent.propose(&input, &mut proposals).unwrap();
        assert_eq!(proposals.degraded(), Some("no weights"));
        assert_eq!(proposals.of(0), CandidateProposals::All);
    }

    #[test]
    fn shares_outside_0_to_100_are_refused() {
        for percent in [0.0, -1.0, 100.1, f64::NAN] {
            assert!(Percent::new(percent).is_err(), "{percent}");
        }
        assert_eq!(Percent::new(5.0).unwrap().of(1001), 51);
    }
}
