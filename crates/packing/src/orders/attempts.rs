//! In which order a step tries to pack: by all rules before those that give way do so.

use super::Orders;
use crate::candidate::Candidate;

/// One try of a step to pack something.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Attempt {
    /// Whether rules give way that may.
    pub gives_way: bool,
}

impl Attempt {
    /// By all rules.
    pub const STRICT: Self = Self { gives_way: false };

    /// Without rules that give way.
    pub const LENIENT: Self = Self { gives_way: true };
}

impl Orders {
    /// The tries of a step over these containers, until one finds something. Whatever has a valid placement has one in the last of them:
    /// where the last finds nothing, nothing can be packed.
    pub fn attempts(&self, containers: &[usize], candidates: &[Candidate]) -> Vec<Attempt> {
        let gives_way = |container: &usize| {
            let mut bars = candidates.iter();
            bars.any(|held| {
                let bar = self.bar(*container, held.arrival);
                bar.is_some_and(|bar| bar.gives_way())
            })
        };
        match containers.iter().any(gives_way) {
            true => vec![Attempt::STRICT, Attempt::LENIENT],
            false => vec![Attempt::STRICT],
        }
    }

    /// Whether a container may take the item of this arrival in this try.
    pub fn admits(&self, attempt: Attempt, container: usize, arrival: usize) -> bool {
        let bar = self.bar(container, arrival);
        bar.is_none_or(|bar| attempt.gives_way && bar.gives_way())
    }
}
