//! In which order a step tries to pack: what is urgent first, and by all rules before those that give way do so.

use std::collections::BTreeSet;

use super::Orders;
use crate::candidate::Candidate;

/// One try of a step to pack something.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Attempt {
    /// Only items as urgent as this; `None`: all.
    urgency: Option<u32>,
    /// Whether rules give way that may.
    pub gives_way: bool,
}

impl Attempt {
    /// Of all items, by all rules.
    pub const STRICT: Self = Self {
        urgency: None,
        gives_way: false,
    };

    /// Of all items, without rules that give way.
    pub const LENIENT: Self = Self {
        urgency: None,
        gives_way: true,
    };
}

impl Orders {
    /// The tries of a step over these containers, until one finds something. Whatever has a valid placement has one in the last of them:
    /// where the last finds nothing, nothing can be packed.
    pub fn attempts(&self, containers: &[usize], candidates: &[Candidate]) -> Vec<Attempt> {
        let arrivals = candidates.iter().map(|held| held.arrival);
        let levels: BTreeSet<u32> = arrivals.map(|arrival| self.urgency(arrival)).collect();
        let wanted: Vec<Option<u32>> = match levels.len() {
            0 | 1 => vec![None],
            _ => levels.into_iter().rev().map(Some).collect(),
        };
        let is_staged = wanted.len() > 1;
        let mut attempts = Vec::new();
        for urgency in wanted {
            let strict = Attempt {
                urgency,
                ..Attempt::STRICT
            };
            attempts.push(strict);
            if self.has_what_gives_way(strict, containers, candidates) {
                attempts.push(Attempt {
                    gives_way: true,
                    ..strict
                });
            }
        }
        attempts.extend(is_staged.then_some(Attempt::LENIENT));
        attempts
    }

    /// Whether a container may take the item of this arrival in this try.
    pub fn admits(&self, attempt: Attempt, container: usize, arrival: usize) -> bool {
        let is_wanted = |urgency| self.urgency(arrival) == urgency;
        if !attempt.urgency.is_none_or(is_wanted) {
            return false;
        }
        let bar = self.bar(container, arrival);
        bar.is_none_or(|bar| attempt.gives_way && bar.gives_way())
    }

    /// Whether a rule that gives way keeps an item of this try out of a container.
    fn has_what_gives_way(
        &self,
        strict: Attempt,
        containers: &[usize],
        candidates: &[Candidate],
    ) -> bool {
        let lenient = Attempt {
            gives_way: true,
            ..strict
        };
        let mut pairs = containers.iter().flat_map(|container| {
            let arrivals = candidates.iter().map(|held| held.arrival);
            arrivals.map(move |arrival| (*container, arrival))
        });
        pairs.any(|(container, arrival)| {
            self.admits(lenient, container, arrival) && !self.admits(strict, container, arrival)
        })
    }

    /// How urgent an item is; one of which nothing is known is not.
    fn urgency(&self, arrival: usize) -> u32 {
        let line = self.lines.get(&arrival);
        line.map_or(0, |line| line.item.urgency)
    }
}
