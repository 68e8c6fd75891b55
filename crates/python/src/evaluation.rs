//! Evaluation of one item on one container, at every offset.

use numpy::{PyArray3, PyUntypedArrayMethods};
use ppnpack_packing::kernel::grid::{self, Units};
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::kernel::item;
use ppnpack_packing::kernel::objective::{Heuristic, SettingError, Weights};
use ppnpack_packing::kernel::resting::RestingHeights;
use ppnpack_packing::planning::survey::survey;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value;

use crate::arrays::array;
use crate::error::OrRaise;
use crate::grid::Grid;
use crate::item::Item;
use crate::scene::SceneArgument;
use crate::settings::settings;

/// The resting height of a placement whose footprint is not inside the container.
pub(crate) const OUTSIDE: Units = -1;

/// Figures of every placement of an item; arrays are [yaw, x, y] by the cell of the footprint's
/// corner.
///
/// resting_height: int16, in units; -1 where the footprint is not inside the container. fits: bool,
/// whether the item stays at or below the rim. stable: bool, whether it does and the paper's
/// stability test accepts it. value: float64, the objective with its balance term, lower is better;
/// inf where the item does not fit.
#[pyclass(frozen, get_all, module = "ppnpack")]
pub(crate) struct Evaluation {
    resting_height: Py<PyArray3<i16>>,
    fits: Py<PyArray3<bool>>,
    stable: Py<PyArray3<bool>>,
    value: Py<PyArray3<f64>>,
}

#[pymethods]
impl Evaluation {
    fn __repr__(&self, py: Python<'_>) -> String {
        let shape = self.value.bind(py).shape();
        format!("<ppnpack.Evaluation of placements {shape:?}: [yaw, x, y]>")
    }
}

/// The same, row-major, before it is moved into arrays.
struct Surveys {
    resting_height: Vec<Units>,
    fits: Vec<bool>,
    stable: Vec<bool>,
    value: Vec<f64>,
}

/// Evaluates an item on a container at every offset.
///
/// scene: a Scene or an int16 heightmap [nx, ny]. heuristic: "sdfm", "dbl", "hm" or "mta". weights:
/// a dictionary of those of the objective that are not the published ones.
#[pyfunction]
#[pyo3(signature = (grid, scene, item, heuristic = "sdfm", weights = None))]
pub(crate) fn evaluate(
    py: Python<'_>,
    grid: &Grid,
    scene: &Bound<'_, PyAny>,
    item: &Item,
    heuristic: &str,
    weights: Option<&Bound<'_, PyDict>>,
) -> PyResult<Evaluation> {
    let heuristic = match serde_json::from_value(Value::from(heuristic)).or_value_error()? {
        Heuristic::FirstFit | Heuristic::Random => {
            return Err(PyValueError::new_err(format!(
                "{heuristic} has no values: evaluate by sdfm, dbl, hm or mta"
            )));
        }
        heuristic => heuristic,
    };
    let weights: Weights = settings("weights", weights, None, py)?;
    let grid = &grid.inner;
    item.check(grid)?;
    let item = item.item();
    let scene = SceneArgument::read(grid, scene)?;
    let heightmap = || scene.get().heightmap();
    let surveys = py.detach(|| Surveys::of(grid, heightmap(), item, heuristic, &weights));
    let surveys = surveys.or_value_error()?;
    let shape = [item.views().len(), grid.nx(), grid.ny()];
    Ok(Evaluation {
        resting_height: array(py, shape, surveys.resting_height)?.unbind(),
        fits: array(py, shape, surveys.fits)?.unbind(),
        stable: array(py, shape, surveys.stable)?.unbind(),
        value: array(py, shape, surveys.value)?.unbind(),
    })
}

/// Gives the height at which an item comes to rest at every placement, in units: int16 [yaw, x, y],
/// -1 where its footprint is not inside the container. Many times quicker than evaluate.
#[pyfunction]
pub(crate) fn resting_heights<'py>(
    py: Python<'py>,
    grid: &Grid,
    scene: &Bound<'_, PyAny>,
    item: &Item,
) -> PyResult<Bound<'py, PyArray3<i16>>> {
    let grid = &grid.inner;
    item.check(grid)?;
    let item = item.item();
    let scene = SceneArgument::read(grid, scene)?;
    let heights = py.detach(|| {
        let mut resting = RestingHeights::new(grid);
        resting.update(scene.get().heightmap(), std::iter::once(&**item));
        everywhere(grid, item, &mut resting)
    });
    array(py, [item.views().len(), grid.nx(), grid.ny()], heights)
}

/// Gives the resting heights of an item, row-major over all yaws and cells of a grid.
pub(crate) fn everywhere(
    grid: &grid::Grid,
    item: &item::Item,
    resting: &mut RestingHeights,
) -> Vec<Units> {
    let mut heights = vec![OUTSIDE; item.views().len() * grid.nx() * grid.ny()];
    write_everywhere(grid, item, resting, &mut heights);
    heights
}

/// Writes them to where there is room for all.
pub(crate) fn write_everywhere(
    grid: &grid::Grid,
    item: &item::Item,
    resting: &mut RestingHeights,
    heights: &mut [Units],
) {
    heights.fill(OUTSIDE);
    let of_yaws = heights.chunks_exact_mut(grid.nx() * grid.ny());
    for (of_yaw, map) in of_yaws.zip(resting.of(item)) {
        for (row, found) in of_yaw.chunks_exact_mut(grid.ny()).zip(map.rows()) {
            if let Some(row) = row.get_mut(..found.len()) {
                row.copy_from_slice(found);
            }
        }
    }
}

impl Surveys {
    fn of(
        grid: &grid::Grid,
        heightmap: &Heightmap,
        item: &item::Item,
        heuristic: Heuristic,
        weights: &Weights,
    ) -> Result<Self, SettingError> {
        let cells = grid.nx() * grid.ny();
        let placements = item.views().len() * cells;
        let mut all = Self {
            resting_height: vec![OUTSIDE; placements],
            fits: vec![false; placements],
            stable: vec![false; placements],
            value: vec![f64::INFINITY; placements],
        };
        for (yaw, view) in item.views().iter().enumerate() {
            for at in survey(grid, heightmap, view, heuristic, weights)? {
                let index = yaw * cells + at.x * grid.ny() + at.y;
                put(&mut all.resting_height, index, at.resting_height);
                put(&mut all.fits, index, at.fits);
                put(&mut all.stable, index, at.fits && at.is_stable);
                if at.fits {
                    put(&mut all.value, index, at.value);
                }
            }
        }
        Ok(all)
    }
}

fn put<T>(values: &mut [T], index: usize, value: T) {
    if let Some(place) = values.get_mut(index) {
        *place = value;
    }
}
