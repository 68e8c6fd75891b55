//! Where the placements of a ranking come from: several searches, each of a share of the work, merged by value.

use std::collections::VecDeque;

use ppnpack_packing::step::Evaluated;
use ppnpack_packing::valid::Tally;
use ppnpack_wire::keys::Instance;

use super::split::Part;

/// A search of a share of the work, which goes on where it stopped.
#[derive(Debug)]
pub(crate) struct Source {
    pub(crate) share: Vec<Part>,
    pub(crate) searcher: Searcher,
    /// Placements that came and were not taken yet, by the order of the ranking.
    found: VecDeque<Evaluated>,
    /// The last placement that came.
    last: Option<Evaluated>,
    is_complete: bool,
}

/// Who searches.
#[derive(Debug)]
pub(crate) enum Searcher {
    /// A heuristic service, and what it said became of the placements.
    Service(Instance, Vec<Tally>),
    /// This process, by the number of the search.
    Here(usize),
    /// Nobody any more: its share was given to others.
    Gone,
}

impl Source {
    pub(crate) fn new(share: Vec<Part>, searcher: Searcher) -> Self {
        Self {
            share,
            searcher,
            found: VecDeque::new(),
            last: None,
            is_complete: false,
        }
    }

    /// The place of a search whose share was given to others: those after it keep their numbers.
    pub(crate) fn gone() -> Self {
        Self {
            is_complete: true,
            ..Self::new(Vec::new(), Searcher::Gone)
        }
    }

    /// Takes in the next placements of the search; `is_complete` says that there are none after them.
    pub(crate) fn extend(
        &mut self,
        placements: impl IntoIterator<Item = Evaluated>,
        is_complete: bool,
    ) {
        self.found.extend(placements);
        self.last = self.found.back().copied().or(self.last);
        self.is_complete = is_complete;
    }

    /// The next placement, where one came.
    pub(crate) fn peek(&self) -> Option<Evaluated> {
        self.found.front().copied()
    }

    /// Takes the next placement.
    pub(crate) fn take(&mut self) -> Option<Evaluated> {
        self.found.pop_front()
    }

    /// The last placement that came.
    pub(crate) fn last(&self) -> Option<&Evaluated> {
        self.last.as_ref()
    }

    /// Whether it is not known which placement comes next.
    pub(crate) fn is_dry(&self) -> bool {
        self.found.is_empty() && !self.is_complete
    }
}

/// Takes the best placement that came from any source. Only where none is dry is it the next of the whole ranking.
pub(crate) fn take_best(sources: &mut [Source]) -> Option<Evaluated> {
    let heads = sources
        .iter_mut()
        .filter_map(|source| Some((source.peek()?, source)));
    let (_, source) = heads.min_by(|(a, _), (b, _)| a.rank_cmp(b))?;
    source.take()
}

#[cfg(test)]
mod tests {
    use ppnpack_packing::placement::{Placement, RestingPlacement};

    use super::*;

    fn at(candidate: usize, x: usize, value: f64) -> Evaluated {
        let placement = Placement { yaw: 0, x, y: 0 };
        Evaluated {
            candidate,
            resting: RestingPlacement {
                placement,
                resting_height: 0,
            },
            value,
        }
    }

    #[test]
    fn placements_of_all_sources_come_by_value_candidate_and_place() {
        let mut sources = [
            Source::new(Vec::new(), Searcher::Here(0)),
            Source::new(Vec::new(), Searcher::Here(1)),
        ];
        assert!(sources[0].is_dry());
        sources[0].extend([at(1, 0, 1.0), at(1, 3, 2.0)], false);
        sources[1].extend([at(0, 7, 1.0), at(1, 2, 2.0)], true);
        let mut taken = Vec::new();
        while sources.iter().all(|source| !source.is_dry()) {
            taken.extend(take_best(&mut sources));
        }
        // The first source is dry then: what it gives next may come before what the other still has.
        assert_eq!(
            taken,
            [at(0, 7, 1.0), at(1, 0, 1.0), at(1, 2, 2.0), at(1, 3, 2.0)]
        );
        assert_eq!(sources[0].last(), Some(&at(1, 3, 2.0)));
        sources[0].extend([], true);
        assert_eq!(take_best(&mut sources), None);
    }
}
