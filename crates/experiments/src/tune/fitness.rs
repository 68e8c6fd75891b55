//! What weights are judged by: volume, less a price for what does not stay where it is placed.

use serde::Serialize;

use crate::filling::Run;
use crate::statistics::{Mean, percentage};

/// What each percent of unsteady placements above the limit costs, in percent of volume.
const PRICE: f64 = 2.0;

/// How good weights are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Fitness {
    /// The difference less the price of unsteady placements; higher is better.
    pub(super) value_percent: f64,
    /// Of the mesh volume to that with the start's weights, sequence by sequence.
    pub(super) difference_percent: Mean,
    /// Not a number where nothing was placed.
    pub(super) unsteady_percent: f64,
    pub(super) unsteady: usize,
    pub(super) placed: usize,
}

impl Fitness {
    /// Of weights that packed the same sequences as the start's. A sequence of which the start packed nothing has no
    /// difference to it and is left out.
    pub(super) fn of(packed: &[Run], start: &[Run], limit_percent: f64) -> Self {
        let compared = packed.iter().zip(start);
        let compared = compared.filter(|(_, start)| start.meshes_m3 > 0.0);
        let differences =
            compared.map(|(packed, start)| 100.0 * (packed.meshes_m3 / start.meshes_m3 - 1.0));
        let difference_percent = Mean::of(differences);
        let sum = |count: fn(&Run) -> usize| packed.iter().map(count).sum::<usize>();
        let (unsteady, placed) = (sum(|packed| packed.unsteady), sum(|packed| packed.placed));
        let unsteady_percent = percentage(unsteady, placed);
        Self {
            value_percent: difference_percent.mean - penalty(unsteady_percent, limit_percent),
            difference_percent,
            unsteady_percent,
            unsteady,
            placed,
        }
    }
}

/// In percent of volume; none where nothing was placed, and nothing can be unsteady.
fn penalty(unsteady_percent: f64, limit_percent: f64) -> f64 {
    // The greater of a number and what is none is the number.
    PRICE * (unsteady_percent - limit_percent).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn packed(meshes_m3: f64, unsteady: usize) -> Run {
        Run {
            meshes_m3,
            placed: 50,
            unsteady,
            ..Run::default()
        }
    }

    #[test]
    fn the_start_is_no_better_than_itself() {
        let start = [packed(0.010, 1), packed(0.014, 0)];
        let fitness = Fitness::of(&start, &start, 2.0);
        assert_eq!(fitness.value_percent, 0.0);
        assert_eq!(fitness.difference_percent, Mean::default());
        assert_eq!((fitness.unsteady, fitness.placed), (1, 100));
    }

    #[test]
    fn volumes_are_compared_sequence_by_sequence() {
        let start = [packed(0.010, 0), packed(0.020, 0)];
        let better = [packed(0.011, 0), packed(0.024, 0)];
        let fitness = Fitness::of(&better, &start, 2.0);
        assert!((fitness.difference_percent.mean - 15.0).abs() < 1e-9);
        assert!((fitness.value_percent - 15.0).abs() < 1e-9);
    }

    #[test]
    fn unsteady_placements_cost_above_the_limit_alone() {
        let start = [packed(0.010, 0), packed(0.010, 0)];
        let value = |unsteady| {
            let packed = [packed(0.010, unsteady), packed(0.010, 0)];
            Fitness::of(&packed, &start, 2.0).value_percent
        };
        assert_eq!(value(2), 0.0);
        assert!((value(3) + 2.0).abs() < 1e-9);
        assert!((value(7) + 10.0).abs() < 1e-9);
    }

    #[test]
    fn nothing_packed_is_bad_and_still_a_number() {
        let start = [packed(0.010, 0), packed(0.0, 0)];
        let nothing = [Run::default(), Run::default()];
        let fitness = Fitness::of(&nothing, &start, 2.0);
        assert_eq!(fitness.value_percent, -100.0);
    }
}
