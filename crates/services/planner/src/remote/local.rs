//! Searches in this process.

use ppnpack_packing::grid::Grid;
use ppnpack_packing::method::Method;
use ppnpack_packing::objective::WeightError;
use ppnpack_packing::proposals::Proposals;
use ppnpack_packing::search::Search;
use ppnpack_packing::step::{Evaluated, StageError, StepInput};
use ppnpack_packing::valid::{Tally, ValidSearch};

use super::split::Part;

/// Searches that work is split into at most, as each keeps memory of its own. Beyond them, each service that fails adds
/// one.
pub(crate) const MAX_SEARCHES: usize = 16;

/// Searches that go on beside each other, each by its number; made when they are first needed and kept with their
/// memory.
pub(crate) struct LocalSearches {
    grid: Grid,
    method: Method,
    /// The most that each may take.
    limit_bytes: usize,
    searches: Vec<ValidSearch>,
}

impl LocalSearches {
    /// Searches that take at most so many bytes each.
    ///
    /// # Errors
    /// [`WeightError`] where a weight is negative or not finite.
    pub(crate) fn new(
        grid: &Grid,
        method: &Method,
        limit_bytes: usize,
    ) -> Result<Self, WeightError> {
        let mut searches = Self {
            grid: grid.clone(),
            method: method.clone(),
            limit_bytes,
            searches: Vec::new(),
        };
        searches.add()?;
        Ok(searches)
    }

    fn add(&mut self) -> Result<(), WeightError> {
        let search = Search::new(&self.grid, &self.method.search_settings())?;
        let search = search.bounded().within_bytes(self.limit_bytes);
        let checks = self.method.stability.checks();
        self.searches
            .push(ValidSearch::new(Box::new(search), checks));
        Ok(())
    }

    /// The method that they follow.
    pub(crate) fn method(&self) -> &Method {
        &self.method
    }

    /// Starts a search of some parts, each of another candidate.
    pub(crate) fn rank(
        &mut self,
        number: usize,
        input: &StepInput<'_>,
        parts: &[Part],
    ) -> Result<(), StageError> {
        while self.searches.len() <= number {
            self.add()?;
        }
        let mut proposals = Proposals::default();
        for candidate in 0..input.candidates.len() {
            match parts.iter().find(|part| part.candidate == candidate) {
                None => proposals.push([]),
                Some(part) => match &part.proposals {
                    None => proposals.push_all_at(part.yaws),
                    Some(placements) => proposals.push(placements.iter().copied()),
                },
            }
        }
        let group: Vec<usize> = parts.iter().map(|part| part.candidate).collect();
        if let Some(search) = self.searches.get_mut(number) {
            search.rank(input, &group, &proposals)?;
        }
        Ok(())
    }

    /// The next valid placement of a search; `None` after the last.
    pub(crate) fn next(
        &mut self,
        number: usize,
        input: &StepInput<'_>,
    ) -> Result<Option<Evaluated>, StageError> {
        let Some(search) = self.searches.get_mut(number) else {
            return Ok(None);
        };
        let next = search.next_valid(input)?;
        Ok(next.map(|valid| valid.placement))
    }

    /// Whether a search stopped because the time was over.
    pub(crate) fn is_cut(&self, number: usize) -> bool {
        self.searches.get(number).is_some_and(ValidSearch::is_cut)
    }

    /// What became of a candidate's placements in a search.
    pub(crate) fn tally(&self, number: usize, candidate: usize) -> Option<Tally> {
        let search = self.searches.get(number)?;
        Some(search.tally(candidate))
    }
}
