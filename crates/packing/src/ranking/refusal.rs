//! Why a placement is not valid.

use std::sync::Arc;

/// Condition that a placement does not meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum Cause {
    /// The item's upper surface would stay above the rim.
    #[error("above the rim")]
    AboveRim,
    /// The item must stand on the floor, and would not.
    #[error("not on the floor")]
    NotOnFloor,
    /// The item would not stand, by the surfaces in metres.
    #[error("unstable")]
    Unstable,
    /// The item would not stand, by the paper's test on cells.
    #[error("unstable by the published test")]
    UnstableByPublishedTest,
    /// The item must stay upright, and could fall over.
    #[error("could fall over")]
    CouldFallOver,
    /// The item would not stay where it is placed: it was tried in a simulation.
    #[error("would not stay")]
    Unsteady,
    /// An item below would carry more than it may.
    #[error("too heavy for what lies below")]
    Load,
    /// The container would be too heavy on one side.
    #[error("the container would be out of balance")]
    Balance,
    /// The item would lie above one that leaves the container earlier.
    #[error("above what leaves earlier")]
    Sequence,
    /// The arm cannot make the placement.
    #[error("not possible for the arm")]
    Arm,
}

/// Why a check refused a placement, without figures of single ones: equal refusals are counted.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Refusal {
    /// Condition that is not met.
    pub cause: Cause,
    /// Why not, for people, where the cause alone does not tell.
    pub detail: Option<Arc<str>>,
}

impl Refusal {
    /// A refusal with a reason for people.
    pub fn because(cause: Cause, detail: impl Into<Arc<str>>) -> Self {
        Self {
            cause,
            detail: Some(detail.into()),
        }
    }

    /// The detail as it follows a cause in a sentence; empty where there is none.
    pub(crate) fn explanation(&self) -> String {
        let detail = self.detail.as_ref();
        detail.map_or_else(String::new, |detail| format!(": {detail}"))
    }
}

impl From<Cause> for Refusal {
    fn from(cause: Cause) -> Self {
        Self {
            cause,
            detail: None,
        }
    }
}

/// How many placements were refused, by what they do not meet.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Refusals(Vec<(Refusal, u64)>);

impl Refusals {
    /// Counts placements.
    pub fn count(&mut self, refusal: Refusal, placements: u64) {
        match self.0.iter_mut().find(|(known, _)| *known == refusal) {
            Some((_, count)) => *count += placements,
            None => self.0.push((refusal, placements)),
        }
    }

    /// Adds those of another.
    pub fn add(&mut self, other: &Self) {
        for (refusal, count) in &other.0 {
            self.count(refusal.clone(), *count);
        }
    }

    /// Each refusal with its count.
    pub fn iter(&self) -> impl Iterator<Item = (&Refusal, u64)> {
        self.0.iter().map(|(refusal, count)| (refusal, *count))
    }

    /// All of them together.
    pub fn total(&self) -> u64 {
        self.0.iter().map(|(_, count)| count).sum()
    }

    /// The cause of most refusals, with the detail that is most frequent among those.
    pub fn most(&self) -> Option<&Refusal> {
        let of_cause = |cause: Cause| {
            let same = self.0.iter().filter(|(refusal, _)| refusal.cause == cause);
            same.map(|(_, count)| count).sum::<u64>()
        };
        let most = self.0.iter().max_by(|(a, of_a), (b, of_b)| {
            let by_cause = of_cause(a.cause).cmp(&of_cause(b.cause));
            by_cause.then(of_a.cmp(of_b)).then_with(|| a.cmp(b))
        });
        most.map(|(refusal, _)| refusal)
    }

    /// Forgets all, keeping the memory.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}

impl FromIterator<(Refusal, u64)> for Refusals {
    fn from_iter<I: IntoIterator<Item = (Refusal, u64)>>(refusals: I) -> Self {
        let mut counted = Self::default();
        for (refusal, count) in refusals {
            counted.count(refusal, count);
        }
        counted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_frequent_cause_comes_with_its_most_frequent_detail() {
        let arm = |detail: &str| Refusal::because(Cause::Arm, detail);
        let refusals: Refusals = [
            (Cause::Unstable.into(), 5),
            (arm("out of reach"), 2),
            (arm("a wall"), 3),
            (arm("out of reach"), 2),
        ]
        .into_iter()
        .collect();
        assert_eq!(refusals.most(), Some(&arm("out of reach")));
        assert_eq!(refusals.total(), 12);
        assert_eq!(Refusals::default().most(), None);
    }
}
