//! Proposals: the placements of each candidate that a step evaluates.

mod drawn;

use std::ops::Range;

use ppnpack_numbers::{SettingError, require};

use crate::kernel::grid::Grid;
use crate::kernel::item::Item;
use crate::kernel::placement::Placement;
use crate::ranking::step::{StageResult, StepInput};
pub use drawn::{ProposeRandom, ProposeTries};

/// The placements proposed for one candidate; `P` are those that are named.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CandidateProposals<P> {
    /// Every possible one.
    All,
    /// These. One that leaves the container is never valid.
    Some(P),
}

/// The proposals of a step, per candidate; a candidate that nothing was said of has none.
#[derive(Debug, Clone, Default)]
pub struct Proposals {
    placements: Vec<Placement>,
    entries: Vec<CandidateProposals<Range<usize>>>,
    /// Why these are not the proposals that were wanted.
    degraded: Option<String>,
    /// Whether nothing else may be placed, even where none of these is valid.
    is_final: bool,
}

impl Proposals {
    /// Forgets all proposals, keeping the memory.
    pub fn clear(&mut self) {
        self.placements.clear();
        self.entries.clear();
        self.degraded = None;
        self.is_final = false;
    }

    /// Says that nothing else may be placed: where none is valid, the step has no choice.
    pub fn finish(&mut self) {
        self.is_final = true;
    }

    pub(crate) fn is_final(&self) -> bool {
        self.is_final
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
        self.entries.push(CandidateProposals::All);
    }

    /// Adds the next candidate, with these placements.
    pub fn push(&mut self, placements: impl IntoIterator<Item = Placement>) {
        let start = self.placements.len();
        self.placements.extend(placements);
        let range = start..self.placements.len();
        self.entries.push(CandidateProposals::Some(range));
    }

    /// Whether some placement is not proposed, as far as is known without counting, and may be.
    pub(crate) fn may_be_widened(&self) -> bool {
        !self.is_final && self.entries.iter().any(|of| *of != CandidateProposals::All)
    }

    pub(crate) fn widen(&mut self) {
        self.placements.clear();
        self.entries.fill(CandidateProposals::All);
    }

    /// Gives the proposals for a candidate.
    pub fn of(&self, candidate: usize) -> CandidateProposals<&[Placement]> {
        let range = match self.entries.get(candidate) {
            Some(CandidateProposals::All) => return CandidateProposals::All,
            Some(CandidateProposals::Some(range)) => range.clone(),
            None => 0..0,
        };
        CandidateProposals::Some(self.placements.get(range).unwrap_or(&[]))
    }
}

/// Proposes placements for every candidate of a step: the first stage of Algorithm 1.
pub trait Proposer: Send {
    /// Fills `proposals` with one entry per candidate, in their order.
    fn propose(&mut self, input: &StepInput<'_>, proposals: &mut Proposals) -> StageResult;
}

/// Proposes every placement: the exhaustive search.
#[derive(Debug, Clone, Copy, Default)]
pub struct ProposeAll;

impl Proposer for ProposeAll {
    fn propose(&mut self, input: &StepInput<'_>, proposals: &mut Proposals) -> StageResult {
        proposals.clear();
        input.candidates.iter().for_each(|_| proposals.push_all());
        Ok(())
    }
}

/// A proposer whose failure does not end the planning: all is searched then, and the plan says why.
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
    fn propose(&mut self, input: &StepInput<'_>, proposals: &mut Proposals) -> StageResult {
        let reason = match &mut self.proposer {
            Ok(proposer) => {
                let error = proposer.propose(input, proposals).err();
                error.map(|error| error.to_string())
            }
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
/// `|P|` counts every yaw and cell of the grid ([`all_count`]), as the paper does. Some of these
/// placements leave the container, so `K` % of `|P|` is a larger share of those that are possible.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Percent(f64);

impl Percent {
    /// A share in percent.
    ///
    /// # Errors
    /// [`SettingError`] where it is not above 0 and at most 100.
    pub fn new(percent: f64) -> Result<Self, SettingError> {
        let expected = "above 0 and at most 100 percent";
        require("the share of placements K", percent, expected, |percent| {
            percent > 0.0 && percent <= 100.0
        })?;
        Ok(Self(percent))
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

    /// Gives `ceil(K / 100 |P|)`, the number of placements that the paper keeps of `|P|`.
    pub fn of(self, placements: u64) -> u64 {
        (placements as f64 * self.0 / 100.0).ceil() as u64
    }
}

/// Counts all placements of an item as the paper does: `|P|` is yaws times the container's cells.
pub fn all_count(grid: &Grid, item: &Item) -> u64 {
    (item.views().len() * grid.nx() * grid.ny()) as u64
}

/// How many placements of an item lie within the container, over all yaws.
pub fn possible_count(grid: &Grid, item: &Item) -> u64 {
    let corners = item
        .views()
        .iter()
        .map(|view| view.corners((grid.nx(), grid.ny())));
    corners.map(|(nx, ny)| (nx * ny) as u64).sum()
}

/// The same; 0 for an item that is taller than the container at every yaw.
pub fn possible_count_below_rim(grid: &Grid, item: &Item) -> u64 {
    let mut views = item.views().iter();
    match views.any(|view| view.height() <= grid.rim()) {
        true => possible_count(grid, item),
        false => 0,
    }
}
