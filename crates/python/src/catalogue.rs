//! Catalogues.

use std::sync::Arc;

use ppnpack_catalogue::build::Pose;
use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::catalogue::{self, Settings};
use ppnpack_catalogue::mass::DEFAULT_DENSITY_KG_M3;
use ppnpack_catalogue::object::CatalogueObject;
use ppnpack_catalogue::unit::LengthUnit;
use ppnpack_packing::kernel::grid::Resolution;
use pyo3::exceptions::{PyIndexError, PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value;

use crate::error::OrRaise;
use crate::grid::Grid;
use crate::item::Item;

/// Objects ready to be packed on a grid.
///
/// Catalogue(grid) has the 96 built-in household objects. With source the folder of mesh files
/// (.ply, .obj, .stl; closed, z up) that it names: in the order of its objects.csv where it has
/// one, else by file name. unit: that of the files, "m", "cm", "mm" or "in". poses: in how many
/// resting poses an object may be packed at most. pose: "as-given", or "most-probable". Meshes are
/// decomposed once and kept in ~/.cache/ppnpack; with cache=False nowhere.
///
/// catalogue["mug"] and catalogue[3] are items in their first pose. Where it is pickled, its source
/// and its settings are: another process loads it anew.
#[pyclass(frozen, module = "ppnpack")]
pub(crate) struct Catalogue {
    inner: catalogue::Catalogue,
    /// The poses of each object.
    poses: Vec<Vec<Py<Item>>>,
    grid: Grid,
    source: String,
    settings: Settings,
}

/// An object by its name or its index.
#[derive(FromPyObject)]
pub(crate) enum Which {
    Index(isize),
    Name(String),
}

#[pymethods]
impl Catalogue {
    #[new]
    #[pyo3(signature = (
        grid, source = "builtin", *, unit = "m", poses = 1, pose = "as-given", density_kg_m3 = DEFAULT_DENSITY_KG_M3, cache = true
    ))]
    #[expect(
        clippy::too_many_arguments,
        reason = "they have names where it is called"
    )]
    fn new(
        py: Python<'_>,
        grid: &Grid,
        source: &str,
        unit: &str,
        poses: usize,
        pose: &str,
        density_kg_m3: f64,
        cache: bool,
    ) -> PyResult<Self> {
        let unit: LengthUnit = unit.parse().or_value_error()?;
        let pose: Pose = serde_json::from_value(Value::from(pose)).or_value_error()?;
        let cache = match cache {
            true => CacheDir::User,
            false => CacheDir::Nowhere,
        };
        let settings = Settings {
            unit,
            density_kg_m3,
            pose,
            poses,
            skip_unusable: false,
            cache,
        };
        let resolution = grid.inner.resolution();
        let inner = py.detach(|| {
            // A fork leaves rayon's own threads behind, so that a child would wait for ever.
            let threads = rayon::ThreadPoolBuilder::new().build().or_runtime_error()?;
            let source = ppnpack_household::source(source);
            let load = || catalogue::Catalogue::load(&source, &settings, resolution, &|_, _| ());
            threads.install(load).or_value_error()
        })?;
        let items = inner.objects.iter();
        let poses = items.map(|object| in_all_poses(py, object, resolution));
        let poses = poses.collect::<PyResult<_>>()?;
        Ok(Self {
            inner,
            poses,
            grid: grid.clone(),
            source: source.to_owned(),
            settings,
        })
    }

    /// Gives the arguments that make an equal one, so that it can be sent to other processes.
    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((Grid, &str), Bound<'py, PyDict>)> {
        let settings = &self.settings;
        let pose = serde_json::to_value(settings.pose).or_runtime_error()?;
        let named = PyDict::new(py);
        named.set_item("unit", settings.unit.to_string())?;
        named.set_item("poses", settings.poses)?;
        named.set_item("pose", pose.as_str())?;
        named.set_item("density_kg_m3", settings.density_kg_m3)?;
        named.set_item("cache", settings.cache != CacheDir::Nowhere)?;
        Ok(((self.grid.clone(), self.source.as_str()), named))
    }

    /// The names of the objects, by index.
    #[getter]
    fn names(&self) -> Vec<&str> {
        let objects = self.inner.objects.iter();
        objects.map(|object| object.model.name.as_str()).collect()
    }

    /// A digest of all objects, their poses, their order and the resolution: results compare only
    /// where it is the same.
    fn content_hash(&self, py: Python<'_>) -> String {
        py.detach(|| self.inner.content_hash())
    }

    /// Gives an object in each pose in which it may be packed: first as it stands in the catalogue,
    /// the others by falling probability.
    fn poses(&self, py: Python<'_>, object: Which) -> PyResult<Vec<Py<Item>>> {
        let poses = self.poses.get(self.index(&object)?).into_iter().flatten();
        Ok(poses.map(|item| item.clone_ref(py)).collect())
    }

    fn __len__(&self) -> usize {
        self.poses.len()
    }

    fn __getitem__(&self, py: Python<'_>, object: Which) -> PyResult<Py<Item>> {
        let first = self.poses(py, object)?.into_iter().next();
        first.ok_or_else(|| PyIndexError::new_err("the catalogue has no such object"))
    }

    /// Itself: it never changes.
    fn __deepcopy__<'py>(slf: PyRef<'py, Self>, _memo: &Bound<'py, PyAny>) -> PyRef<'py, Self> {
        slf
    }

    fn __repr__(&self) -> String {
        format!("<ppnpack.Catalogue of {} objects>", self.poses.len())
    }
}

impl Catalogue {
    /// Gives the objects, in their order.
    pub(crate) fn objects(&self) -> &[CatalogueObject] {
        &self.inner.objects
    }

    /// Checks that its items are made for a grid.
    pub(crate) fn check(&self, grid: &ppnpack_packing::kernel::grid::Grid) -> PyResult<()> {
        if self.inner.resolution == *grid.resolution() {
            return Ok(());
        }
        Err(PyValueError::new_err(
            "the catalogue's items are made for another cell, height unit or yaws than the grid's",
        ))
    }

    /// Gives the index of an object; negative ones count from the end.
    fn index(&self, object: &Which) -> PyResult<usize> {
        let objects = self.poses.len();
        match object {
            Which::Name(name) => {
                let none = || format!("the catalogue has no object '{name}'");
                let found = self.inner.find(name).map(|(index, _)| index);
                found.ok_or_else(|| PyKeyError::new_err(none()))
            }
            Which::Index(index) => {
                let from_start = index + if *index < 0 { objects as isize } else { 0 };
                let inside = usize::try_from(from_start).ok().filter(|at| *at < objects);
                inside.ok_or_else(|| {
                    PyIndexError::new_err(format!(
                        "the catalogue has objects 0 to {}, not {index}",
                        objects.saturating_sub(1)
                    ))
                })
            }
        }
    }
}

fn in_all_poses(
    py: Python<'_>,
    object: &CatalogueObject,
    made_for: &Resolution,
) -> PyResult<Vec<Py<Item>>> {
    let candidates = object.candidates(0).into_iter();
    let item = |candidate| {
        let own = Some(Arc::clone(&object.model));
        Py::new(py, Item::of(candidate, own, Some(made_for)))
    };
    candidates.map(item).collect()
}
