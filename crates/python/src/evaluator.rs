//! A heuristic that is a Python function.

use std::sync::{Arc, Mutex, PoisonError};

use numpy::{AllowTypeChange, PyArrayLike3, PyUntypedArrayMethods};
use ppnpack_packing::kernel::grid::{Grid, Units};
use ppnpack_packing::kernel::item::ShapeId;
use ppnpack_packing::kernel::placement::{Placement, RestingPlacement};
use ppnpack_packing::kernel::resting::RestingHeights;
use ppnpack_packing::ranking::evaluator::Evaluator;
use ppnpack_packing::ranking::proposals::{CandidateProposals, Proposals};
use ppnpack_packing::ranking::step::{
    Candidate, Evaluated, PlacementCounts, StageResult, StepInput,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::arrays::{array, values};
use crate::evaluation::{OUTSIDE, everywhere};
use crate::item::Item;

/// The items of the step that is planned, as Python knows them.
pub(crate) type Known = Arc<Mutex<Vec<(ShapeId, Py<Item>)>>>;

/// Ranks placements by the values that a Python function gives all of an item's placements at once.
pub(crate) struct PythonEvaluator {
    function: Py<PyAny>,
    grid: Grid,
    known: Known,
    resting: RestingHeights,
    /// Placements, the best last.
    ranking: Vec<Evaluated>,
    /// Counts, by index of the candidate.
    counts: Vec<PlacementCounts>,
    left_out: Vec<usize>,
}

impl PythonEvaluator {
    pub(crate) fn new(function: Py<PyAny>, grid: &Grid, known: Known) -> Self {
        Self {
            function,
            grid: grid.clone(),
            known,
            resting: RestingHeights::new(grid),
            ranking: Vec::new(),
            counts: Vec::new(),
            left_out: Vec::new(),
        }
    }

    /// Asks for the values of all placements of a candidate, row-major; what does not fit has none
    /// that counts.
    fn values(
        &self,
        input: &StepInput<'_>,
        held: &Candidate,
        resting: &[Units],
        fits: &[bool],
    ) -> PyResult<Vec<f64>> {
        let (nx, ny) = (self.grid.nx(), self.grid.ny());
        let shape = [held.item.views().len(), nx, ny];
        Python::attach(|py| {
            let heightmap = input.scene.heightmap().heights().to_vec();
            let item = self.known_item(py, held)?;
            let arguments = (
                array(py, [nx, ny], heightmap)?,
                item,
                array(py, shape, resting.to_vec())?,
                array(py, shape, fits.to_vec())?,
            );
            let answer = self.function.bind(py).call1(arguments)?;
            let needed = format!("where {shape:?} is needed: [yaw, x, y]");
            let answer: PyArrayLike3<'_, f64, AllowTypeChange> =
                answer.extract().map_err(|_| {
                    PyTypeError::new_err(format!("the evaluator gave no array of numbers {needed}"))
                })?;
            if answer.shape() == shape {
                return Ok(values(&answer));
            }
            let found = answer.shape();
            Err(PyValueError::new_err(format!(
                "the evaluator gave values of shape {found:?} {needed}"
            )))
        })
    }

    fn known_item(&self, py: Python<'_>, held: &Candidate) -> PyResult<Py<Item>> {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let mut known = known.iter();
        match known.find(|(shape, _)| *shape == held.item.shape()) {
            Some((_, item)) => Ok(item.clone_ref(py)),
            None => Py::new(py, Item::of(held.clone(), None, None)),
        }
    }
}

impl Evaluator for PythonEvaluator {
    fn rank(
        &mut self,
        input: &StepInput<'_>,
        group: &[usize],
        proposals: &Proposals,
    ) -> StageResult {
        self.ranking.clear();
        self.left_out.clear();
        self.counts = vec![PlacementCounts::default(); input.candidates.len()];
        let candidates = || {
            let candidate = |index: &usize| Some((*index, input.candidates.get(*index)?));
            group.iter().filter_map(candidate)
        };
        let items = candidates().map(|(_, held)| &*held.item);
        self.resting.update(input.scene.heightmap(), items);
        for (candidate, held) in candidates() {
            let resting = everywhere(&self.grid, &held.item, &mut self.resting);
            let fits = fits(&self.grid, held, &resting);
            let values = self.values(input, held, &resting, &fits)?;
            let is_proposed = proposed(&self.grid, held, proposals.of(candidate));
            let mut counts = PlacementCounts::default();
            let all = resting.iter().zip(&fits).zip(&values).zip(&is_proposed);
            for (index, (((height, fits), value), is_proposed)) in all.enumerate() {
                let is_possible = *height != OUTSIDE;
                counts.possible += u64::from(is_possible);
                counts.proposed += u64::from(is_possible && *is_proposed);
                if !*fits || !*is_proposed {
                    continue;
                }
                counts.fitting += 1;
                if value.is_finite() {
                    let resting = RestingPlacement {
                        placement: placement(&self.grid, index),
                        resting_height: *height,
                    };
                    self.ranking.push(Evaluated {
                        candidate,
                        resting,
                        value: *value,
                    });
                }
            }
            if let Some(counted) = self.counts.get_mut(candidate) {
                *counted = counts;
            }
        }
        self.ranking.sort_unstable_by(|a, b| b.rank_cmp(a));
        Ok(())
    }

    fn next_best(&mut self, _input: &StepInput<'_>) -> StageResult<Option<Evaluated>> {
        while let Some(next) = self.ranking.pop() {
            if !self.left_out.contains(&next.candidate) {
                return Ok(Some(next));
            }
        }
        Ok(None)
    }

    fn leave_out(&mut self, candidate: usize) {
        self.left_out.push(candidate);
    }

    fn counts(&self, candidate: usize) -> PlacementCounts {
        self.counts.get(candidate).copied().unwrap_or_default()
    }
}

/// Gives the placement with this row-major index.
fn placement(grid: &Grid, index: usize) -> Placement {
    let cells = grid.nx() * grid.ny();
    Placement {
        yaw: index / cells,
        x: index % cells / grid.ny(),
        y: index % grid.ny(),
    }
}

/// Says of each placement whether the item stays at or below the rim.
fn fits(grid: &Grid, held: &Candidate, resting: &[Units]) -> Vec<bool> {
    let of_yaws = resting.chunks_exact(grid.nx() * grid.ny());
    let of_yaws = of_yaws.zip(held.item.views());
    let fits = of_yaws.flat_map(|(heights, view)| {
        let fits = |height: &Units| *height != OUTSIDE && view.fits_at(grid, *height);
        heights.iter().map(fits)
    });
    fits.collect()
}

/// Says of each placement whether it was proposed.
fn proposed(
    grid: &Grid,
    held: &Candidate,
    proposals: CandidateProposals<&[Placement]>,
) -> Vec<bool> {
    let cells = grid.nx() * grid.ny();
    let count = held.item.views().len() * cells;
    let CandidateProposals::Some(placements) = proposals else {
        return vec![true; count];
    };
    let mut is_proposed = vec![false; count];
    for at in placements {
        let is_on_grid = at.x < grid.nx() && at.y < grid.ny();
        let index = at.yaw * cells + at.x * grid.ny() + at.y;
        if let Some(place) = is_proposed.get_mut(index).filter(|_| is_on_grid) {
            *place = true;
        }
    }
    is_proposed
}
