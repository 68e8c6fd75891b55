//! The values of placements.

use pulp::{Simd, WithSimd};

use super::{Pending, Search};
use crate::kernel::{columns_after, contact, distance_sum};
use crate::objective::Heuristic;
use crate::random;
use crate::step::StepInput;

/// What the values of placements are computed from.
#[derive(Clone, Copy)]
pub(super) struct Evaluation<'a> {
    pub(super) search: &'a Search,
    pub(super) input: &'a StepInput<'a>,
}

impl Evaluation<'_> {
    #[inline(always)]
    fn value(&self, at: &Pending) -> f64 {
        let Search {
            objective,
            resting,
            distance,
            views,
            seed,
            ..
        } = self.search;
        let Pending { x, y, height, .. } = *at;
        let Some(state) = views.get(at.view) else {
            return f64::INFINITY;
        };
        let held = self.input.candidates.get(state.candidate);
        let Some((held, view)) =
            held.and_then(|held| Some((held, held.item.views().get(state.yaw)?)))
        else {
            return f64::INFINITY;
        };
        let container = resting.container();
        let base = x * container.stride() + y;
        let constant = state.terms.constant;
        match objective.heuristic {
            Heuristic::Sdfm => {
                let Some(distance) = distance else {
                    return f64::INFINITY;
                };
                let sum = distance_sum(distance.levels(), base, view, height);
                objective.sdfm(height, sum as f64 / view.voxel_count() as f64, constant)
            }
            Heuristic::Dbl => objective.dbl(height, x, y, constant),
            Heuristic::Hm => {
                let columns = columns_after(container, base, view, height);
                objective.hm(columns, x, y, constant)
            }
            Heuristic::Mta => objective.mta(contact(container, (x, y), view, height), constant),
            Heuristic::FirstFit => {
                let (nx, ny) = container.size();
                ((state.yaw * nx + x) * ny + y) as f64
            }
            Heuristic::Random => {
                let of_item = random::mix(random::mix(*seed, self.input.step), held.arrival as u64);
                let (nx, ny) = container.size();
                let of_placement = ((state.yaw * nx + x) * ny + y) as u64;
                random::unit(random::mix(of_item, of_placement))
            }
        }
    }
}

/// Computes the values of some placements.
pub(super) struct EvaluateAll<'a> {
    pub(super) evaluation: Evaluation<'a>,
    pub(super) chunk: &'a mut [Pending],
}

impl WithSimd for EvaluateAll<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for pending in self.chunk {
            pending.value = self.evaluation.value(pending);
        }
    }
}
