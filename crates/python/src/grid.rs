//! Grids.

use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use ppnpack_packing::kernel::grid::{self, ContainerSize, GridSettings, Resolution, Yaws};
use ppnpack_packing::kernel::heightmap::Heightmap;
use pyo3::prelude::*;

use crate::arrays::{array, array1, values};
use crate::error::OrRaise;

/// A container seen as a grid of cells with heights in units.
///
/// Grid() is that of `ppnpack pack`: 128 x 128 cells of 2.5 mm, 150 units of 2 mm, 16 yaws. Cell
/// (x, y) covers [x, x + 1) x [y, y + 1) cells of the container frame: right-handed, z up, the
/// origin at an inner bottom corner of the box around the opening.
///
/// container_m: inner sides at the rim along x and y, and the height, in metres. cell_m: the edge of
/// a cell. height_unit_m: one unit of height. yaws: how many, evenly over half a turn, or angles in
/// radians, counter-clockwise seen from above. draft_rad: the angle by which each wall leans
/// outwards. corner_radius_m: the radius of the vertical edges.
#[pyclass(frozen, eq, module = "ppnpack")]
#[derive(Clone, PartialEq)]
pub(crate) struct Grid {
    pub(crate) inner: grid::Grid,
}

/// The number of yaws, or their angles.
#[derive(FromPyObject)]
enum YawsArgument {
    Count(usize),
    Radians(Vec<f64>),
}

#[pymethods]
impl Grid {
    #[new]
    #[pyo3(signature = (
        container_m = None, cell_m = None, height_unit_m = None, yaws = None, draft_rad = 0.0, corner_radius_m = 0.0
    ))]
    fn new(
        container_m: Option<(f64, f64, f64)>,
        cell_m: Option<f64>,
        height_unit_m: Option<f64>,
        yaws: Option<YawsArgument>,
        draft_rad: f64,
        corner_radius_m: f64,
    ) -> PyResult<Self> {
        let usual = GridSettings::default();
        let yaws = match yaws {
            None => Yaws::half_turn(usual.yaws),
            Some(YawsArgument::Count(count)) => Yaws::half_turn(count),
            Some(YawsArgument::Radians(radians)) => Yaws::from_radians(radians),
        };
        let size = |(x_m, y_m, z_m)| ContainerSize::cuboid(x_m, y_m, z_m);
        let container = ContainerSize {
            draft_rad,
            corner_radius_m,
            ..container_m.map_or(usual.container, size)
        };
        let cell_m = cell_m.unwrap_or(usual.cell_m);
        let height_unit_m = height_unit_m.unwrap_or(usual.height_unit_m);
        let yaws = yaws.or_value_error()?;
        let resolution = Resolution::new(cell_m, height_unit_m, yaws).or_value_error()?;
        let inner = grid::Grid::new(container, resolution).or_value_error()?;
        Ok(Self { inner })
    }

    /// The paper's grid: 32 x 32 cells of 1 cm, 150 units of 2 mm, yaws of 0, 45, 90 and 135
    /// degrees.
    #[staticmethod]
    fn reference() -> Self {
        let inner = grid::Grid::reference();
        Self { inner }
    }

    /// Cells along x.
    #[getter]
    fn nx(&self) -> usize {
        self.inner.nx()
    }

    /// Cells along y.
    #[getter]
    fn ny(&self) -> usize {
        self.inner.ny()
    }

    /// The container's height, in units.
    #[getter]
    fn rim(&self) -> i16 {
        self.inner.rim()
    }

    /// The container's inner sides along x, y and z, at the rim, in metres.
    #[getter]
    fn container_m(&self) -> (f64, f64, f64) {
        let ContainerSize { x_m, y_m, z_m, .. } = self.inner.container();
        (x_m, y_m, z_m)
    }

    /// The angle by which each wall leans outwards from the vertical, in radians.
    #[getter]
    fn draft_rad(&self) -> f64 {
        self.inner.container().draft_rad
    }

    /// The radius of the vertical edges between the walls, in metres.
    #[getter]
    fn corner_radius_m(&self) -> f64 {
        self.inner.container().corner_radius_m
    }

    /// The container's inner volume, in cubic metres.
    #[getter]
    fn volume_m3(&self) -> f64 {
        self.inner.container().volume_m3()
    }

    /// The edge of a cell, in metres.
    #[getter]
    fn cell_m(&self) -> f64 {
        self.inner.resolution().cell_m()
    }

    /// One unit of height, in metres.
    #[getter]
    fn height_unit_m(&self) -> f64 {
        self.inner.resolution().height_unit_m()
    }

    /// The yaws, in radians: float64 [yaws].
    #[getter]
    fn yaws_rad<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        array1(py, self.inner.resolution().yaws().radians().to_vec())
    }

    /// The shape of what there is of each placement of an item: (yaws, nx, ny).
    #[getter]
    fn shape(&self) -> (usize, usize, usize) {
        let yaws = self.inner.resolution().yaws().count();
        (yaws, self.inner.nx(), self.inner.ny())
    }

    /// Gives the heightmap of an empty container: int16 [nx, ny], zeros where no wall leans in.
    fn empty<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i16>>> {
        let empty = Heightmap::empty(&self.inner);
        let shape = (self.inner.nx(), self.inner.ny());
        array(py, shape.into(), empty.heights().to_vec())
    }

    /// Converts heights in metres, float64 of any two dimensions, to units, rounded up: int16 of
    /// the same shape.
    fn units<'py>(
        &self,
        py: Python<'py>,
        heights_m: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<i16>>> {
        let resolution = self.inner.resolution();
        let shape = heights_m.as_array().dim();
        let heights = values(&heights_m).into_iter();
        let units = heights.map(|height_m| resolution.units_above(height_m));
        array(py, shape.into(), units.collect())
    }

    /// Converts heights in units, int16 of any two dimensions, to metres: float64 of the same
    /// shape.
    fn metres<'py>(
        &self,
        py: Python<'py>,
        heights: PyReadonlyArray2<'py, i16>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let unit_m = self.inner.resolution().height_unit_m();
        let shape = heights.as_array().dim();
        let heights = values(&heights).into_iter();
        let metres = heights.map(|height| f64::from(height) * unit_m);
        array(py, shape.into(), metres.collect())
    }

    /// Gives the arguments that make an equal one, so that it can be copied and sent to other
    /// processes.
    fn __getnewargs__(&self) -> ((f64, f64, f64), f64, f64, Vec<f64>, f64, f64) {
        let yaws_rad = self.inner.resolution().yaws().radians().to_vec();
        let (cell_m, height_unit_m) = (self.cell_m(), self.height_unit_m());
        let (draft_rad, corner_radius_m) = (self.draft_rad(), self.corner_radius_m());
        let size = self.container_m();
        (
            size,
            cell_m,
            height_unit_m,
            yaws_rad,
            draft_rad,
            corner_radius_m,
        )
    }

    fn __repr__(&self) -> String {
        let container = self.inner.container();
        let (yaws, nx, ny) = self.shape();
        format!(
            "<ppnpack.Grid {container}: {nx} x {ny} cells, {} units, {yaws} yaws>",
            self.inner.rim()
        )
    }
}
