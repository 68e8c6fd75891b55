//! Scenes.

use numpy::{PyArray2, PyReadonlyArray2};
use ppnpack_packing::kernel::grid;
use ppnpack_packing::kernel::heightmap::{Heightmap, Surface};
use ppnpack_packing::scene;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use crate::arrays::{array, frozen, values};
use crate::error::OrRaise;
use crate::grid::Grid;

/// The scene that a placement is planned on: the container's heightmap, its surface in metres, and
/// the solids that lie in it, as far as these are known.
///
/// A simulated cell's scan knows all of it. Scene(grid, heightmap, surface_m) knows no solids, and
/// no surface where none is given: float32 [nx * s, ny * s] in metres, s samples per cell along
/// each side. Where a scene is asked for, a heightmap alone does, too.
#[pyclass(frozen, module = "ppnpack")]
pub(crate) struct Scene {
    pub(crate) inner: scene::Scene,
    heightmap: PyOnceLock<Py<PyArray2<i16>>>,
}

impl Scene {
    pub(crate) fn of(inner: scene::Scene) -> Self {
        Self {
            inner,
            heightmap: PyOnceLock::new(),
        }
    }
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (grid, heightmap, surface_m = None))]
    fn new(
        grid: &Grid,
        heightmap: PyReadonlyArray2<'_, i16>,
        surface_m: Option<PyReadonlyArray2<'_, f32>>,
    ) -> PyResult<Self> {
        let surface = surface_m.map(|surface_m| {
            let (nx, ny) = surface_m.as_array().dim();
            let pitch_m = grid.inner.resolution().surface_pitch_m();
            Surface::from_metres(nx, ny, pitch_m, values(&surface_m)).or_value_error()
        });
        let surface = surface.transpose()?;
        let heightmap = read(&heightmap)?;
        let inner = scene::Scene::new(&grid.inner, heightmap, surface).or_value_error()?;
        Ok(Self::of(inner))
    }

    /// The heightmap, in units: int16 [nx, ny], not to be written to.
    #[getter]
    fn heightmap(&self, py: Python<'_>) -> PyResult<Py<PyArray2<i16>>> {
        let made = self.heightmap.get_or_try_init(py, || {
            let heightmap = self.inner.heightmap();
            let shape = [heightmap.nx(), heightmap.ny()];
            array(py, shape, heightmap.heights().to_vec()).map(frozen)
        });
        Ok(made?.clone_ref(py))
    }

    /// The surface in metres, float32 [nx * s, ny * s], as a copy; None where it is not known.
    #[getter]
    fn surface_m<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f32>>>> {
        let surface = self.inner.surface().map(|surface| {
            let shape = [surface.nx(), surface.ny()];
            array(py, shape, surface.heights_m().to_vec())
        });
        surface.transpose()
    }

    /// The number of solids that are known to lie there; None where nothing is known of them.
    #[getter]
    fn solids(&self) -> Option<usize> {
        let content = self.inner.content();
        content.map(|content| content.solids().len())
    }

    fn __repr__(&self) -> String {
        let heightmap = self.inner.heightmap();
        let (nx, ny, highest) = (heightmap.nx(), heightmap.ny(), heightmap.max());
        format!("<ppnpack.Scene of {nx} x {ny} cells, {highest} units high>")
    }
}

/// The scene that an argument is, or whose heightmap it is.
pub(crate) enum SceneArgument {
    Given(Py<Scene>),
    Made(Box<scene::Scene>),
}

impl SceneArgument {
    /// Reads a scene, or an int16 heightmap of the grid.
    pub(crate) fn read(grid: &grid::Grid, argument: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(scene) = argument.cast::<Scene>() {
            let heightmap = scene.get().inner.heightmap();
            let (found, needed) = ([heightmap.nx(), heightmap.ny()], [grid.nx(), grid.ny()]);
            if found != needed {
                return Err(PyValueError::new_err(format!(
                    "the scene has cells {found:?}, and the grid {needed:?}: scan it on this grid"
                )));
            }
            return Ok(Self::Given(scene.clone().unbind()));
        }
        let heightmap: PyReadonlyArray2<'_, i16> = argument.extract().map_err(|_| {
            let needed = "an int16 array [nx, ny] in units, which grid.units(heights_m) makes";
            PyTypeError::new_err(format!("the scene is neither a Scene nor {needed}"))
        })?;
        let heightmap = read(&heightmap)?;
        let scene = scene::Scene::new(grid, heightmap, None).or_value_error()?;
        Ok(Self::Made(Box::new(scene)))
    }

    pub(crate) fn get(&self) -> &scene::Scene {
        match self {
            Self::Given(scene) => &scene.get().inner,
            Self::Made(scene) => scene,
        }
    }
}

/// Copies a heightmap from its array, as the engine keeps it.
pub(crate) fn read(heightmap: &PyReadonlyArray2<'_, i16>) -> PyResult<Heightmap> {
    let (nx, ny) = heightmap.as_array().dim();
    Heightmap::from_units(nx, ny, values(heightmap)).or_value_error()
}
