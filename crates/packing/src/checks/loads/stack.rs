//! Loads of the items of a pile.

use std::collections::BTreeMap;

/// How often loads are passed down at most; a pile where items do not rest on each other in a
/// circle needs no more than it is high.
const PASSES: usize = 64;

/// Loads that change by less than this are settled, in kilograms.
const SETTLED_KG: f64 = 1e-9;

/// Parts of an item's weight by the indices of those that bear them; the floor bears the rest.
pub(super) type Shares = BTreeMap<usize, f64>;

#[derive(Debug, Clone, Default)]
pub(super) struct Stack {
    shares: Vec<Shares>,
    pub(super) carried_kg: Vec<f64>,
    /// Mass of all that rests on each item, wholly or in part, directly or not, in kilograms: no
    /// way to spread the weight loads it with more.
    pub(super) above_kg: Vec<f64>,
}

impl Stack {
    pub(super) fn new(masses_kg: &[f64], shares: Vec<Shares>) -> Self {
        let mut stack = Self {
            above_kg: vec![0.0; shares.len()],
            shares,
            ..Self::default()
        };
        stack.carried_kg = stack.borne(masses_kg);
        for (shares, mass_kg) in stack.shares.iter().zip(masses_kg) {
            let below = stack.below(shares);
            for (above_kg, is_below) in stack.above_kg.iter_mut().zip(&below) {
                *above_kg += if *is_below { *mass_kg } else { 0.0 };
            }
        }
        stack
    }

    /// Gives the load that a further item, resting so, adds to each of the others, in kilograms.
    pub(super) fn added_kg(&self, mass_kg: f64, shares: &Shares) -> Vec<f64> {
        let mut direct_kg = vec![0.0; self.shares.len()];
        for (on, part) in shares {
            if let Some(direct_kg) = direct_kg.get_mut(*on) {
                *direct_kg += part * mass_kg;
            }
        }
        let passed_kg = self.borne(&direct_kg);
        let total_kg = direct_kg.iter().zip(passed_kg);
        total_kg.map(|(direct, passed)| direct + passed).collect()
    }

    /// Gives the load of each item where each has this weight, by fixed-point iteration of `b_j =
    /// sum_i part_ij (w_i + b_i)`.
    fn borne(&self, weights_kg: &[f64]) -> Vec<f64> {
        let mut borne_kg = vec![0.0; self.shares.len()];
        for _ in 0..PASSES {
            let mut next_kg = vec![0.0; self.shares.len()];
            for ((shares, weight_kg), own_kg) in self.shares.iter().zip(weights_kg).zip(&borne_kg) {
                for (on, part) in shares {
                    if let Some(next_kg) = next_kg.get_mut(*on) {
                        *next_kg += part * (weight_kg + own_kg);
                    }
                }
            }
            let mut changes = next_kg.iter().zip(&borne_kg);
            let is_settled = changes.all(|(next, before)| (next - before).abs() < SETTLED_KG);
            borne_kg = next_kg;
            if is_settled {
                break;
            }
        }
        borne_kg
    }

    /// Says which items bear some of these shares, directly or not.
    fn below(&self, shares: &Shares) -> Vec<bool> {
        let mut is_below = vec![false; self.shares.len()];
        let mut open: Vec<usize> = shares.keys().copied().collect();
        while let Some(index) = open.pop() {
            let Some((shares, is_below)) = self.shares.get(index).zip(is_below.get_mut(index))
            else {
                continue;
            };
            if !std::mem::replace(is_below, true) {
                open.extend(shares.keys());
            }
        }
        is_below
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_that_rest_on_each_other_have_an_end() {
        let stack = |shares: &[(usize, f64)]| {
            let shares = shares.iter().map(|share| Shares::from([*share]));
            Stack::new(&[1.0; 3], shares.collect())
        };
        let halves = stack(&[(1, 0.5), (0, 0.5), (7, 1.0)]);
        // x = (1 + x) / 2.
        assert!((halves.carried_kg[0] - 1.0).abs() < 1e-6);
        assert_eq!(halves.above_kg[0], 2.0);
        assert!(stack(&[(1, 1.0), (0, 1.0)]).carried_kg[0].is_finite());
    }
}
