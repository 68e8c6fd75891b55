//! Ranking the best placements by what they leave, too.

use std::collections::VecDeque;

use crate::kernel::placement::Placement;
use crate::ranking::evaluator::Evaluator;
use crate::ranking::proposals::Proposals;
use crate::ranking::refusal::Refusals;
use crate::ranking::scene_value::{SceneValue, Squares, figures};
use crate::ranking::step::{Evaluated, PlacementCounts, Shortfall, StageResult, StepInput};

/// Number of placements of each candidate, that is of each pose, that are valued.
const VALUED: usize = 15;

/// Maximum number looked at to find [`VALUED`]: the others lie next to one of these.
const LOOKED_AT: usize = 40 * VALUED;

/// Distance below which placements at neighbouring yaws leave much the same, in metres.
const APART_M: f64 = 0.01;

const LITRES: f64 = 1e3;

/// Gives the best placements of another evaluator in the order of objective and
/// [value](SceneValue), and then the others as they come.
///
/// The values of the placements stay those of the objective.
pub struct Farsighted {
    inner: Box<dyn Evaluator>,
    weight: f64,
    coefficients: Vec<f64>,
    first: VecDeque<Evaluated>,
    /// Members of `first` that were given.
    given: Vec<(usize, Placement)>,
}

impl Farsighted {
    /// Ranks the best placements of `inner` anew.
    pub fn new(inner: Box<dyn Evaluator>, value: &SceneValue) -> Self {
        Self {
            inner,
            weight: value.weight,
            coefficients: value.in_use(),
            first: VecDeque::new(),
            given: Vec::new(),
        }
    }

    /// The best placements of a candidate that are not next to one another.
    fn best_of(
        &mut self,
        input: &StepInput<'_>,
        candidate: usize,
        proposals: &Proposals,
    ) -> StageResult<Vec<Evaluated>> {
        self.inner.rank(input, &[candidate], proposals)?;
        let mut best: Vec<Evaluated> = Vec::with_capacity(VALUED);
        for _ in 0..LOOKED_AT {
            let Some(next) = self.inner.next_best(input)? else {
                break;
            };
            let at = next.resting.placement;
            let mut others = best.iter();
            if !others.any(|other| are_near(input, at, other.resting.placement)) {
                best.push(next);
            }
            if best.len() >= VALUED {
                break;
            }
        }
        Ok(best)
    }

    /// The objective of a placement less what the item and what it leaves are worth.
    fn worth(&self, input: &StepInput<'_>, before: &Squares, placement: &Evaluated) -> f64 {
        let Some(held) = input.candidates.get(placement.candidate) else {
            return placement.value;
        };
        let at = &placement.resting;
        let Some(view) = held.item.views().get(at.placement.yaw) else {
            return placement.value;
        };
        let figures = figures(input, &before.with(view, at), placement.candidate);
        let pairs = self.coefficients.iter().zip(figures);
        let share: f64 = pairs
            .map(|(coefficient, figure)| coefficient * figure)
            .sum();
        let size = input.grid.container();
        let left_m3 = share * size.x_m * size.y_m * size.z_m;
        placement.value - self.weight * LITRES * (held.item.mesh_volume_m3() + left_m3)
    }
}

/// Whether two placements of an item leave much the same.
fn are_near(input: &StepInput<'_>, one: Placement, other: Placement) -> bool {
    let resolution = input.grid.resolution();
    let apart_m = |a: usize, b: usize| a.abs_diff(b) as f64 * resolution.cell_m();
    let turned = one.yaw.abs_diff(other.yaw);
    let turned = turned.min(resolution.yaws().count() - turned);
    let (x_m, y_m) = (apart_m(one.x, other.x), apart_m(one.y, other.y));
    turned <= 1 && x_m.max(y_m) < APART_M - 1e-9
}

impl Evaluator for Farsighted {
    fn rank(
        &mut self,
        input: &StepInput<'_>,
        group: &[usize],
        proposals: &Proposals,
    ) -> StageResult {
        self.given.clear();
        let before = Squares::of(input.grid, input.scene.heightmap());
        let mut valued: Vec<(f64, Evaluated)> = Vec::new();
        for candidate in group {
            for placement in self.best_of(input, *candidate, proposals)? {
                valued.push((self.worth(input, &before, &placement), placement));
            }
        }
        // A stable sort: of equals, the candidate and placement that the objective gives first.
        valued.sort_by(|(one, _), (other, _)| one.total_cmp(other));
        self.first = valued.into_iter().map(|(_, placement)| placement).collect();
        self.inner.rank(input, group, proposals)
    }

    fn next_best(&mut self, input: &StepInput<'_>) -> StageResult<Option<Evaluated>> {
        if let Some(next) = self.first.pop_front() {
            self.given.push((next.candidate, next.resting.placement));
            return Ok(Some(next));
        }
        loop {
            let next = self.inner.next_best(input)?;
            let key = next.map(|next| (next.candidate, next.resting.placement));
            if key.is_none_or(|key| !self.given.contains(&key)) {
                return Ok(next);
            }
        }
    }

    fn leave_out(&mut self, candidate: usize) {
        self.first
            .retain(|placement| placement.candidate != candidate);
        self.inner.leave_out(candidate);
    }

    fn counts(&self, candidate: usize) -> PlacementCounts {
        self.inner.counts(candidate)
    }

    fn add_refusals(&self, candidate: usize, refusals: &mut Refusals) {
        self.inner.add_refusals(candidate, refusals);
    }

    fn shortfall(&self) -> Option<&Shortfall> {
        self.inner.shortfall()
    }
}
