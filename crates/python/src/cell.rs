//! The simulated cell.

use std::sync::{Arc, Mutex, MutexGuard};

use nalgebra::Isometry3;
use numpy::PyArray2;
use ppnpack_packing::kernel::grid;
use ppnpack_packing::scene::content::{Content, LyingSolid};
use ppnpack_packing::scene::model::Model;
use ppnpack_physics::cell;
use ppnpack_physics::error::PhysicsError;
use ppnpack_physics::outcome;
use ppnpack_physics::settings::CellSettings;
use ppnpack_physics::twin::TwinSettings;
use ppnpack_physics::view::{CameraSettings, CameraView};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::array;
use crate::error::{OrRaise, unused};
use crate::grid::Grid;
use crate::item::Item;
use crate::placement::Placement;
use crate::scene::Scene;
use crate::settings::json;

/// A simulated container: items are released above their places, fall and settle; what lies there
/// is scanned from above.
///
/// base: the settings that the others change: "robot" (lays items down from 1 cm, up to 2 s to come
/// to rest), "twin" (the same as placements are tried before they are made, with half the steps:
/// 1/240 s, 1 s at most) or "reference" (the paper's: released 12 cm above, 0.375 s). Others, as
/// dictionaries, are those of `ppnpack_physics`' CellSettings: walls, contact, release,
/// settle_time_s, outcome, solver, seed. The container is that of the grid.
///
/// camera: has depth cameras see the container in place of an exact scan: {} is one 0.9 m above the
/// floor with 1 mm of noise and 5 % dropouts; cameras (1 or 2), height_m, width_px, height_px,
/// noise (sigma_m, dropout, step_m) and seed change that.
///
/// The same settings and the same calls give the same results, bit for bit. A cell does one thing
/// at a time: have one for each thread.
#[pyclass(frozen, module = "ppnpack")]
pub(crate) struct SimulatedCell {
    grid: grid::Grid,
    view: Option<Mutex<CameraView>>,
    cell: Mutex<cell::SimulatedCell>,
}

/// The outcome of a placement by the end of its settling phase.
///
/// body: the number of the new body. container_from_item: its pose at the end, float64 [4, 4].
/// slide_m, height_change_m: the distance of its centre of mass from where it was planned,
/// horizontally and upwards. tilt_rad: its tilt. toppled, inside, lost: whether it tilted too far,
/// its centre of mass is inside the container, it left the container. disturbance_m: how far the
/// other body that moved most moved. others_lost: earlier bodies that left the container. still:
/// whether all is at rest. simulated_s: how long the phase took in the simulation.
#[pyclass(frozen, get_all, module = "ppnpack")]
pub(crate) struct PlacedReport {
    body: usize,
    container_from_item: Py<PyArray2<f64>>,
    slide_m: f64,
    height_change_m: f64,
    tilt_rad: f64,
    toppled: bool,
    inside: bool,
    lost: bool,
    disturbance_m: f64,
    others_lost: Vec<usize>,
    still: bool,
    simulated_s: f64,
}

/// A body that lies in or on the container.
///
/// body: its number, in the order of placing. name: of its object. container_from_item: where the
/// object's own frame is, float64 [4, 4]. inside: whether its centre of mass is inside the
/// container. mass_kg, volume_m3: of the object.
#[pyclass(frozen, get_all, module = "ppnpack")]
pub(crate) struct Body {
    body: usize,
    name: String,
    container_from_item: Py<PyArray2<f64>>,
    inside: bool,
    mass_kg: f64,
    volume_m3: f64,
}

#[pymethods]
impl PlacedReport {
    fn __repr__(&self) -> String {
        let (slide_mm, tilt) = (1000.0 * self.slide_m, self.tilt_rad.to_degrees());
        let place = if self.inside { "inside" } else { "not inside" };
        let body = self.body;
        format!(
            "<ppnpack.PlacedReport body {body} {place}, slid {slide_mm:.1} mm, tilted {tilt:.1} degrees>"
        )
    }
}

#[pymethods]
impl SimulatedCell {
    #[new]
    #[pyo3(signature = (grid, base = "robot", *, camera = None, **settings))]
    fn new(
        grid: &Grid,
        base: &str,
        camera: Option<&Bound<'_, PyDict>>,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let settings = cell_settings(&grid.inner, base, settings)?;
        let camera = camera_settings(camera)?;
        let view = camera.map(|camera| CameraView::new(&camera, &grid.inner));
        let view = view.transpose();
        Ok(Self {
            view: view.or_value_error()?.map(Mutex::new),
            grid: grid.inner.clone(),
            cell: Mutex::new(cell::SimulatedCell::new(settings).or_value_error()?),
        })
    }

    /// Empties the container.
    fn reset(&self, py: Python<'_>) -> PyResult<()> {
        py.detach(|| {
            self.lock()?.reset();
            Ok(())
        })
    }

    /// Releases an item above where it shall lie, and lets everything settle. On an error nothing
    /// has changed.
    fn place(&self, py: Python<'_>, item: &Item, placement: &Placement) -> PyResult<PlacedReport> {
        self.release(py, item, placement, cell::SimulatedCell::place)
    }

    /// Reports what place would; the cell stays as it is.
    fn try_place(
        &self,
        py: Python<'_>,
        item: &Item,
        placement: &Placement,
    ) -> PyResult<PlacedReport> {
        self.release(py, item, placement, cell::SimulatedCell::try_place)
    }

    /// Lets everything settle for one more phase; gives the simulated time that it took, in
    /// seconds.
    fn settle(&self, py: Python<'_>) -> PyResult<f64> {
        py.detach(|| Ok(self.lock()?.settle()))
    }

    /// Scans the scene that the next placement is planned on: the heightmap, the surface and all
    /// solids.
    fn scan(&self, py: Python<'_>) -> PyResult<Scene> {
        py.detach(|| {
            let mut cell = self.lock()?;
            let view = self.view.as_ref().map(Mutex::lock).transpose();
            let mut view = view.map_err(|_| PyRuntimeError::new_err("the camera failed before"))?;
            let scene = scanned(&mut cell, view.as_deref_mut(), &self.grid).or_runtime_error()?;
            Ok(Scene::of(scene))
        })
    }

    /// Gives the bodies in or on the container, in the order of placing; those that left it are no
    /// longer there.
    fn contents(&self, py: Python<'_>) -> PyResult<Vec<Body>> {
        let bodies = py.detach(|| PyResult::Ok(self.lock()?.contents()))?;
        bodies.iter().map(|state| Body::of(py, state)).collect()
    }

    /// Whether every body is at rest.
    #[getter]
    fn is_still(&self) -> PyResult<bool> {
        Ok(self.lock()?.is_still())
    }

    fn __repr__(&self) -> String {
        let bodies = self.lock().map(|cell| cell.contents().len());
        bodies.map_or_else(
            |_| "<ppnpack.SimulatedCell at work>".to_owned(),
            |bodies| format!("<ppnpack.SimulatedCell with {bodies} bodies>"),
        )
    }
}

/// A way of releasing a model at a pose.
type Release = fn(
    &mut cell::SimulatedCell,
    &Arc<Model>,
    &Isometry3<f64>,
) -> Result<outcome::PlacedReport, PhysicsError>;

impl SimulatedCell {
    fn release(
        &self,
        py: Python<'_>,
        item: &Item,
        placement: &Placement,
        release: Release,
    ) -> PyResult<PlacedReport> {
        let report = py.detach(|| {
            let (model, pose) = planned(&self.grid, item, placement)?;
            let mut cell = self.lock()?;
            release(&mut cell, model, &pose).or_value_error()
        });
        PlacedReport::of(py, report?)
    }

    fn lock(&self) -> PyResult<MutexGuard<'_, cell::SimulatedCell>> {
        let busy = "the cell is busy with something else: have one for each thread";
        unused(&self.cell, busy)
    }
}

impl PlacedReport {
    fn of(py: Python<'_>, report: outcome::PlacedReport) -> PyResult<Self> {
        Ok(Self {
            body: report.id.index(),
            container_from_item: matrix(py, &report.container_from_item)?,
            slide_m: report.slide_m,
            height_change_m: report.height_change_m,
            tilt_rad: report.tilt_rad,
            toppled: report.toppled,
            inside: report.inside,
            lost: report.lost,
            disturbance_m: report.disturbance_m,
            others_lost: report.others_lost.iter().map(|id| id.index()).collect(),
            still: report.still,
            simulated_s: report.simulated_s,
        })
    }
}

impl Body {
    fn of(py: Python<'_>, state: &outcome::BodyState) -> PyResult<Self> {
        Ok(Self {
            body: state.id.index(),
            name: state.model.name.clone(),
            container_from_item: matrix(py, &state.container_from_item)?,
            inside: state.inside,
            mass_kg: state.model.mass.mass_kg,
            volume_m3: state.model.volume_m3,
        })
    }
}

/// Reads the settings of a cell whose container is that of a grid.
pub(crate) fn cell_settings(
    grid: &grid::Grid,
    base: &str,
    over: Option<&Bound<'_, PyDict>>,
) -> PyResult<CellSettings> {
    let mut settings = match base {
        "robot" => CellSettings::robot(),
        "twin" => TwinSettings::default().cell,
        "reference" => CellSettings::default(),
        other => {
            return Err(PyValueError::new_err(format!(
                "a cell's base is 'robot', 'twin' or 'reference', not '{other}'"
            )));
        }
    };
    if let Some(over) = over {
        settings = settings.overlaid(json(over.as_any())?).or_value_error()?;
    }
    settings.container = grid.container();
    settings.validate().or_value_error()?;
    Ok(settings)
}

/// Reads the settings of cameras, where there are any.
pub(crate) fn camera_settings(
    settings: Option<&Bound<'_, PyDict>>,
) -> PyResult<Option<CameraSettings>> {
    let read = |settings: &Bound<'_, PyDict>| {
        serde_json::from_value(json(settings.as_any())?).or_value_error()
    };
    settings.map(read).transpose()
}

/// Gives the heightmap, the surface and the solids of a cell, scanned exactly or seen by cameras.
pub(crate) fn scanned(
    cell: &mut cell::SimulatedCell,
    view: Option<&mut CameraView>,
    grid: &grid::Grid,
) -> Result<ppnpack_packing::scene::Scene, PhysicsError> {
    let bodies = cell.contents().into_iter();
    let solids = bodies.map(|body| LyingSolid::new(body.model, body.container_from_item));
    let known: Content = solids.collect();
    match view {
        Some(view) => view.scene(cell, known),
        None => Ok(cell.scan(grid)?.with_content(known)),
    }
}

/// Gives the model for a cell, and the pose of its frame.
fn planned<'a>(
    grid: &grid::Grid,
    item: &'a Item,
    placement: &Placement,
) -> PyResult<(&'a Arc<Model>, Isometry3<f64>)> {
    item.check(grid)?;
    let name = item.item().name();
    let model = item.own.as_ref().ok_or_else(|| {
        PyValueError::new_err(format!(
            "the solid of item {name} is not known: take it from a catalogue, or make it of a mesh"
        ))
    })?;
    let none = || PyValueError::new_err(format!("item {name} has no such yaw"));
    let frame = item.item().container_from_item(grid, &placement.resting());
    let mut frame = frame.ok_or_else(none)?;
    frame.translation.z -= placement.lowered_m;
    Ok((model, item.candidate.lying.own_frame(&frame)))
}

fn matrix(py: Python<'_>, pose: &Isometry3<f64>) -> PyResult<Py<PyArray2<f64>>> {
    // nalgebra's matrices are column-major.
    let rows = pose.to_homogeneous().transpose();
    Ok(array(py, [4, 4], rows.as_slice().to_vec())?.unbind())
}
