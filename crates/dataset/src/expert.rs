//! The labels of a step: which placements of each candidate the exhaustive search finds best.

use ppnpack_packing::checks::check::BoxedCheck;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::objective::SettingError;
use ppnpack_packing::ranking::evaluator::Evaluator;
use ppnpack_packing::ranking::proposals::Proposals;
use ppnpack_packing::ranking::search::{Search, SearchSettings};
use ppnpack_packing::ranking::step::{Candidate, Evaluated, StageError, StepInput};

use crate::record::{CandidateRecord, Corner, TIE_TOLERANCE, YawOptima};
use crate::values::Values;

/// Labels candidates by an exhaustive search with validity checks.
pub struct Expert {
    search: Search,
    checks: Vec<BoxedCheck>,
    proposals: Proposals,
    with_values: bool,
}

impl Expert {
    /// Makes an expert that judges as `settings` say; `with_values` also keeps the value of every
    /// placement.
    pub fn new(
        grid: &Grid,
        settings: &SearchSettings,
        checks: Vec<BoxedCheck>,
        with_values: bool,
    ) -> Result<Self, SettingError> {
        Ok(Self {
            search: Search::new(grid, settings)?,
            checks,
            proposals: Proposals::default(),
            with_values,
        })
    }

    /// Labels a candidate of a step: placements by increasing value, until every yaw has its
    /// optimum with all ties.
    pub(crate) fn label(
        &mut self,
        input: &StepInput<'_>,
        candidate: usize,
        object: u32,
    ) -> Result<CandidateRecord, StageError> {
        let Some(held) = input.candidates.get(candidate) else {
            return Err(format!("the buffer has no candidate {candidate}").into());
        };
        let none = || Optimum {
            found: YawOptima::NONE,
            is_settled: false,
        };
        let mut optima: Vec<Optimum> = held.item.views().iter().map(|_| none()).collect();
        let values = || Values::none_valid(input.grid, &held.item);
        let mut values = self.with_values.then(values);
        self.proposals.clear();
        let all = input.candidates.iter();
        all.for_each(|_| self.proposals.push_all());
        self.search.rank(input, &[candidate], &self.proposals)?;
        while let Some(found) = self.search.next_best(input)? {
            let placement = found.resting.placement;
            let Some(optimum) = optima.get_mut(placement.yaw) else {
                continue;
            };
            // Values come in increasing order: a greater one than the ties' says that there are no
            // more of them.
            optimum.is_settled |= found.value > optimum.found.value + TIE_TOLERANCE;
            let is_wanted = !optimum.is_settled || values.is_some();
            if is_wanted && self.is_valid(input, held, &found)? {
                optimum.add(&found);
                if let Some(values) = &mut values {
                    values.enter(&placement, found.value);
                }
            }
            if values.is_none() && optima.iter().all(|optimum| optimum.is_settled) {
                break;
            }
        }
        for optimum in &mut optima {
            optimum.found.placements.sort_unstable();
        }
        Ok(CandidateRecord {
            object,
            yaws: optima.into_iter().map(|optimum| optimum.found).collect(),
            values,
        })
    }

    fn is_valid(
        &mut self,
        input: &StepInput<'_>,
        held: &Candidate,
        found: &Evaluated,
    ) -> Result<bool, StageError> {
        for check in &mut self.checks {
            if !check.judge(input, held, &found.resting)?.is_accepted() {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

/// The optimum of a yaw while it is looked for.
struct Optimum {
    found: YawOptima,
    /// Whether all ties are found.
    is_settled: bool,
}

impl Optimum {
    /// Adds a valid placement, if it is among the best.
    fn add(&mut self, found: &Evaluated) {
        if self.is_settled {
            return;
        }
        self.found.value = self.found.value.min(found.value);
        let placement = found.resting.placement;
        // A grid has at most 2048 cells along a side.
        let (x, y) = (placement.x as u16, placement.y as u16);
        self.found.placements.push(Corner { x, y });
    }
}
