//! Placements.

use numpy::{PyArray2, PyReadonlyArray2};
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::kernel::item::ItemView;
use ppnpack_packing::kernel::placement::{self, RestingPlacement};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{array, values};
use crate::error::OrRaise;
use crate::item::Item;

/// The place of an item on the grid.
///
/// yaw: index of a yaw of the grid. x, y: cell of the footprint's corner with the lowest indices.
/// resting_height: of the item's lowest point above the floor, in units. Of a plan also slot, the
/// item's index in the buffer, pose, which of the poses that were given of it, value, that of the
/// objective (lower is better), and lowered_m, how far below its place the item touches what lies
/// there, in metres (0 where it was not tried): a cell places it there.
#[pyclass(frozen, eq, get_all, module = "ppnpack")]
#[derive(Clone, PartialEq)]
pub(crate) struct Placement {
    pub(crate) yaw: usize,
    pub(crate) x: usize,
    pub(crate) y: usize,
    pub(crate) resting_height: i16,
    pub(crate) slot: usize,
    pub(crate) pose: usize,
    pub(crate) value: Option<f64>,
    pub(crate) lowered_m: f64,
}

impl Placement {
    /// Converts it to the engine's.
    pub(crate) fn resting(&self) -> RestingPlacement {
        let Self { yaw, x, y, .. } = *self;
        RestingPlacement {
            placement: placement::Placement { yaw, x, y },
            resting_height: self.resting_height,
        }
    }
}

#[pymethods]
impl Placement {
    #[new]
    #[pyo3(signature = (yaw, x, y, resting_height, *, slot = 0, pose = 0, value = None))]
    fn new(
        yaw: usize,
        x: usize,
        y: usize,
        resting_height: i16,
        slot: usize,
        pose: usize,
        value: Option<f64>,
    ) -> Self {
        Self {
            yaw,
            x,
            y,
            resting_height,
            slot,
            pose,
            value,
            lowered_m: 0.0,
        }
    }

    fn __repr__(&self) -> String {
        let Self { yaw, x, y, .. } = self;
        let (slot, pose, height) = (self.slot, self.pose, self.resting_height);
        format!(
            "<ppnpack.Placement slot {slot}, pose {pose}, yaw {yaw}, cell ({x}, {y}), {height} units high>"
        )
    }
}

/// Gives the heightmap once an item lies where it was placed, and stays there: a new int16 [nx,
/// ny].
#[pyfunction]
pub(crate) fn place<'py>(
    py: Python<'py>,
    heightmap: PyReadonlyArray2<'py, i16>,
    item: &Item,
    placement: &Placement,
) -> PyResult<Bound<'py, PyArray2<i16>>> {
    let (nx, ny) = heightmap.as_array().dim();
    let mut placed = Heightmap::from_units(nx, ny, values(&heightmap)).or_value_error()?;
    let view = item.item().views().get(placement.yaw);
    let inside = |view: &&ItemView| {
        placement.x.saturating_add(view.nx()) <= nx
            && placement.y.saturating_add(view.ny()) <= ny
            && placement.resting_height >= 0
    };
    let view = view.filter(inside).ok_or_else(|| {
        let name = item.item().name();
        PyValueError::new_err(format!("item {name} is not inside the container there"))
    })?;
    lay(&mut placed, view, &placement.resting());
    array(py, [nx, ny], placed.heights().to_vec())
}

/// Raises a heightmap to the upper surface of what rests on it.
pub(crate) fn lay(heightmap: &mut Heightmap, view: &ItemView, at: &RestingPlacement) {
    let placement::Placement { x, y, .. } = at.placement;
    for (dx, dy, _, top) in view.cells() {
        heightmap.raise(x + dx, y + dy, at.resting_height.saturating_add(top));
    }
}
