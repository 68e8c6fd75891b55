//! Items.

use std::sync::Arc;

use nalgebra::Point3;
use numpy::{Element, PyArray2, PyReadonlyArray2};
use ppnpack_catalogue::build::{ModelSettings, model};
use ppnpack_catalogue::mass::DEFAULT_DENSITY_KG_M3;
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_catalogue::views;
use ppnpack_packing::kernel::grid::{self, Resolution};
use ppnpack_packing::kernel::item::{self, ItemView, ViewSurfaces};
use ppnpack_packing::ranking::step::Candidate;
use ppnpack_packing::scene::model::Model;
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use crate::arrays::{array, frozen, values};
use crate::error::OrRaise;
use crate::grid::Grid;

/// An item that can be packed, in one pose: for each yaw of a grid, its upper and lower surface
/// over its footprint.
///
/// Made by a Catalogue, or of surfaces that are given. Item(name, tops, bottoms): for each yaw an
/// int16 array [w, d] of the upper surface, and one of the lower, in units from the item's lowest
/// point; -1 below where a cell has no material. Of such an item no mass and no solid is known.
#[pyclass(frozen, module = "ppnpack")]
pub(crate) struct Item {
    /// All that is known of it; its place in a sequence is that of the step that it takes part in.
    pub(crate) candidate: Candidate,
    /// The object's own model, which lies in a cell.
    pub(crate) own: Option<Arc<Model>>,
    /// What its surfaces are made for; not known of those that were given.
    made_for: Option<Resolution>,
    /// The upper and lower surfaces per yaw, made when they are first asked for.
    surfaces: PyOnceLock<Vec<[Py<PyArray2<i16>>; 2]>>,
}

impl Item {
    /// Makes it of a candidate of a step, whose own model, in the pose in which the catalogue has
    /// it, is known or not.
    pub(crate) fn of(
        candidate: Candidate,
        own: Option<Arc<Model>>,
        made_for: Option<&Resolution>,
    ) -> Self {
        Self {
            candidate,
            own,
            made_for: made_for.cloned(),
            surfaces: PyOnceLock::new(),
        }
    }

    /// Gives its heightmaps.
    pub(crate) fn item(&self) -> &Arc<item::Item> {
        &self.candidate.item
    }

    /// Refuses an item that is made for another grid.
    pub(crate) fn check(&self, grid: &grid::Grid) -> PyResult<()> {
        if let Some(made_for) = &self.made_for
            && made_for != grid.resolution()
        {
            return Err(PyValueError::new_err(format!(
                "item {} is made for another cell, height unit or yaws than the grid's: make it for this grid",
                self.item().name()
            )));
        }
        self.item().check_yaws(grid).or_value_error()
    }

    fn view(&self, yaw: usize) -> PyResult<&ItemView> {
        let views = self.item().views();
        views.get(yaw).ok_or_else(|| {
            let (name, yaws) = (self.item().name(), views.len());
            PyIndexError::new_err(format!("item {name} has yaws 0 to {}, not {yaw}", yaws - 1))
        })
    }

    /// Gives one of the two surfaces at a yaw, as the same array each time.
    fn surface(&self, py: Python<'_>, yaw: usize, which: usize) -> PyResult<Py<PyArray2<i16>>> {
        self.view(yaw)?;
        let all = self.surfaces.get_or_try_init(py, || {
            let surface = |view: &ItemView, values: &[i16]| {
                array(py, [view.nx(), view.ny()], values.to_vec()).map(frozen)
            };
            let pair = |view: &ItemView| {
                PyResult::Ok([surface(view, view.top())?, surface(view, view.bottom())?])
            };
            self.item().views().iter().map(pair).collect()
        })?;
        let surface = all.get(yaw).and_then(|pair| pair.get(which));
        let surface = surface.map(|surface| surface.clone_ref(py));
        surface.ok_or_else(|| PyIndexError::new_err("there is no such surface"))
    }
}

#[pymethods]
impl Item {
    #[new]
    #[pyo3(signature = (name, tops, bottoms, *, mesh_volume_m3 = 0.0, mass_kg = None))]
    fn new(
        name: &str,
        tops: Vec<PyReadonlyArray2<'_, i16>>,
        bottoms: Vec<PyReadonlyArray2<'_, i16>>,
        mesh_volume_m3: f64,
        mass_kg: Option<f64>,
    ) -> PyResult<Self> {
        if tops.len() != bottoms.len() {
            let (tops, bottoms) = (tops.len(), bottoms.len());
            return Err(PyValueError::new_err(format!(
                "item {name} has {tops} upper and {bottoms} lower surfaces: give one of each per yaw"
            )));
        }
        let views = tops.iter().zip(&bottoms).map(|(top, bottom)| {
            let (nx, ny) = top.as_array().dim();
            ViewSurfaces::of_cells(nx, ny, values(top), values(bottom))
        });
        let item = item::Item::new(name, views.collect(), mesh_volume_m3).or_value_error()?;
        let candidate = Candidate {
            mass_kg,
            ..Candidate::new(0, Arc::new(item))
        };
        Ok(Self::of(candidate, None, None))
    }

    /// Makes an item of a closed triangle mesh, in the pose in which it is given, z up.
    ///
    /// vertices: float64 [n, 3], in metres. triangles: uint32 [m, 3], indices of vertices,
    /// counter-clockwise seen from outside. Its mass is mass_kg, else that of its volume at
    /// density_kg_m3.
    #[staticmethod]
    #[pyo3(signature = (grid, name, vertices, triangles, *, mass_kg = None, density_kg_m3 = DEFAULT_DENSITY_KG_M3))]
    fn from_mesh(
        py: Python<'_>,
        grid: &Grid,
        name: String,
        vertices: PyReadonlyArray2<'_, f64>,
        triangles: PyReadonlyArray2<'_, u32>,
        mass_kg: Option<f64>,
        density_kg_m3: f64,
    ) -> PyResult<Self> {
        let vertices = triples(&vertices, "vertices")?.into_iter();
        let mesh = Mesh {
            vertices: vertices.map(Point3::from).collect(),
            triangles: triples(&triangles, "triangles")?,
        };
        let settings = ModelSettings {
            mass_kg,
            density_kg_m3,
            ..ModelSettings::default()
        };
        let resolution = grid.inner.resolution();
        py.detach(|| {
            let (model, _) = model(&name, mesh, &settings).or_value_error()?;
            let item = views::item(&model, resolution).or_value_error()?;
            let model = Arc::new(model);
            let candidate = Candidate::new(0, Arc::new(item)).with_model(Arc::clone(&model));
            Ok(Self::of(candidate, Some(model), Some(resolution)))
        })
    }

    /// Its name.
    #[getter]
    fn name(&self) -> String {
        self.item().name().to_string()
    }

    /// The number of the object's pose: 0 is that of the catalogue.
    #[getter]
    fn pose(&self) -> usize {
        self.candidate.pose
    }

    /// The number of yaws at which it may be placed.
    #[getter]
    fn yaws(&self) -> usize {
        self.item().views().len()
    }

    /// The volume of its mesh, in cubic metres.
    #[getter]
    fn mesh_volume_m3(&self) -> f64 {
        self.item().mesh_volume_m3()
    }

    /// Its mass, in kilograms; None where it is not known.
    #[getter]
    fn mass_kg(&self) -> Option<f64> {
        self.candidate.weighs_kg()
    }

    /// Whether its solid is known, which a simulated cell needs.
    #[getter]
    fn has_solid(&self) -> bool {
        self.own.is_some()
    }

    /// Gives its upper surface at a yaw, in units from its lowest point; 0 where a cell has no
    /// material: int16 [w, d], not to be written to.
    #[pyo3(signature = (yaw = 0))]
    fn top(&self, py: Python<'_>, yaw: usize) -> PyResult<Py<PyArray2<i16>>> {
        self.surface(py, yaw, 0)
    }

    /// Gives its lower surface at a yaw, in units from its lowest point; -1 where a cell has no
    /// material: int16 [w, d], not to be written to.
    #[pyo3(signature = (yaw = 0))]
    fn bottom(&self, py: Python<'_>, yaw: usize) -> PyResult<Py<PyArray2<i16>>> {
        self.surface(py, yaw, 1)
    }

    /// Gives its height from the lowest to the highest point at a yaw, in units.
    #[pyo3(signature = (yaw = 0))]
    fn height(&self, yaw: usize) -> PyResult<i16> {
        Ok(self.view(yaw)?.height())
    }

    /// Counts the voxels (cell times unit) that it fills at a yaw.
    #[pyo3(signature = (yaw = 0))]
    fn voxel_count(&self, yaw: usize) -> PyResult<u64> {
        Ok(self.view(yaw)?.voxel_count())
    }

    /// Itself: it never changes.
    fn __deepcopy__<'py>(slf: PyRef<'py, Self>, _memo: &Bound<'py, PyAny>) -> PyRef<'py, Self> {
        slf
    }

    fn __repr__(&self) -> String {
        let (name, pose, yaws) = (self.item().name(), self.candidate.pose, self.yaws());
        format!("<ppnpack.Item {name}, pose {pose}, {yaws} yaws>")
    }
}

/// Gives the rows of an array of three columns.
fn triples<T: Element + Copy>(
    array: &PyReadonlyArray2<'_, T>,
    what: &str,
) -> PyResult<Vec<[T; 3]>> {
    match array.as_array().ncols() {
        3 => Ok(values(array).as_chunks::<3>().0.to_vec()),
        columns => Err(PyValueError::new_err(format!(
            "{what} need 3 columns, not {columns}"
        ))),
    }
}
