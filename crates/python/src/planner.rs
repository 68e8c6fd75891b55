//! Algorithm 1 over a buffer.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use ppnpack_packing::checks::sequence::Sequence;
use ppnpack_packing::kernel::grid;
use ppnpack_packing::planning::method::Method;
use ppnpack_packing::planning::plan::{self, PlanError};
use ppnpack_packing::ranking::step::{Candidate, StepInput};
use ppnpack_physics::trial;
use ppnpack_physics::twin::TwinSettings;
use pyo3::exceptions::{PyRuntimeError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{OrRaise, not_forked, raised, unused};
use crate::evaluator::{Known, PythonEvaluator};
use crate::grid::Grid;
use crate::item::Item;
use crate::plan::Plan;
use crate::scene::SceneArgument;
use crate::settings::settings;

/// Plans steps by Algorithm 1: propose placements of the buffer's items, rank them by a heuristic,
/// take the best one that is valid.
///
/// How is said by a method, a dictionary as in the JSON of the experiments, and by keyword
/// arguments that win over it: heuristic, order, proposals, stability, trial, loads, weights,
/// scene_value, buffer, seed. What is left out is as in `ppnpack_packing`'s Method: every placement
/// is looked at, and the best are tried in a simulation where the scene knows what lies there.
///
/// evaluator: a heuristic of one's own in place of the method's: called as evaluator(heightmap,
/// item, resting_height, fits) with int16 [nx, ny], an Item, int16 [yaw, x, y] and bool [yaw, x,
/// y], it gives the value of each placement, float64 [yaw, x, y], lower is better; those that are
/// inf or nan are left out. threads: how many the tries of a step use.
///
/// A planner keeps what it knows of the buffer's items from step to step, and plans one step at a
/// time: have one for each thread.
#[pyclass(frozen, module = "ppnpack")]
pub(crate) struct Planner {
    grid: grid::Grid,
    method: Method,
    planner: Mutex<plan::Planner>,
    known: Known,
    /// The process that has its threads, where there are any.
    made_in: Option<u32>,
}

#[pymethods]
impl Planner {
    #[new]
    #[pyo3(signature = (grid, method = None, *, evaluator = None, threads = 1, **settings))]
    fn new(
        py: Python<'_>,
        grid: &Grid,
        method: Option<&Bound<'_, PyDict>>,
        evaluator: Option<Py<PyAny>>,
        threads: u32,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let method: Method = self::settings("method", method, settings, py)?;
        method.validate().or_value_error()?;
        if let Some(evaluator) = &evaluator
            && !evaluator.bind(py).is_callable()
        {
            return Err(PyTypeError::new_err("the evaluator is no function"));
        }
        let grid = grid.inner.clone();
        let known = Known::default();
        let planner = py.detach(|| {
            let evaluator =
                evaluator.map(|function| PythonEvaluator::new(function, &grid, Arc::clone(&known)));
            build(&grid, &method, evaluator, threads)
        })?;
        Ok(Self {
            grid,
            method,
            planner: Mutex::new(planner),
            known,
            made_in: (threads > 1).then(std::process::id),
        })
    }

    /// Its method, as a dictionary.
    #[getter]
    fn method<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let text = serde_json::to_string(&self.method).or_runtime_error()?;
        py.import("json")?.getattr("loads")?.call1((text,))
    }

    /// Plans one step.
    ///
    /// scene: a Scene, or an int16 heightmap [nx, ny]. buffer: the items to choose from; a list in
    /// place of one is an item in several poses. step: its number, which what is random depends on.
    /// alternatives: how many placements are wanted beside the best. deadline_s: seconds from now
    /// after which it takes what it has.
    #[pyo3(signature = (scene, buffer, *, step = 0, alternatives = 0, deadline_s = None))]
    fn plan(
        &self,
        py: Python<'_>,
        scene: &Bound<'_, PyAny>,
        buffer: &Bound<'_, PyAny>,
        step: u64,
        alternatives: usize,
        deadline_s: Option<f64>,
    ) -> PyResult<Plan> {
        self.made_in.map_or(Ok(()), not_forked)?;
        let scene = SceneArgument::read(&self.grid, scene)?;
        let poses = poses(buffer)?;
        for (_, _, item) in &poses {
            item.get().check(&self.grid)?;
        }
        let deadline = deadline_s.map(Duration::try_from_secs_f64).transpose();
        let deadline = deadline.or_value_error()?;
        let items = poses.iter();
        let known = items.map(|(_, _, it)| (it.get().item().shape(), it.clone_ref(py)));
        let known: Vec<_> = known.collect();
        let candidates: Vec<Candidate> = poses.iter().map(candidate).collect();
        let planned = py.detach(|| {
            let busy = "the planner is planning another step: have one for each thread";
            let mut planner = unused(&self.planner, busy)?;
            *self.known.lock().unwrap_or_else(PoisonError::into_inner) = known;
            let input = StepInput {
                step,
                alternatives,
                deadline: deadline.and_then(|after| Instant::now().checked_add(after)),
                ..StepInput::new(&self.grid, scene.get(), &candidates)
            };
            let plan = planner.plan(&input);
            PyResult::Ok(plan.map(|plan| Plan::of(plan, &candidates)))
        });
        planned?.map_err(|error| exception(py, &error))
    }

    fn __repr__(&self) -> String {
        let (heuristic, proposals) = (self.method.heuristic, &self.method.proposals);
        format!("<ppnpack.Planner {heuristic:?}, proposals: {proposals}>")
    }
}

fn build(
    grid: &grid::Grid,
    method: &Method,
    evaluator: Option<PythonEvaluator>,
    threads: u32,
) -> PyResult<plan::Planner> {
    let pool = trial::pool(threads as usize).or_runtime_error()?;
    let mut twin = TwinSettings::default();
    twin.cell.container = grid.container();
    let trial = trial::check(method.trial, &method.loads, twin, pool).or_value_error()?;
    let proposer = method.proposer(grid, None).or_value_error()?;
    let Some(evaluator) = evaluator else {
        let planner = method.build_with(grid, proposer, trial);
        return planner.or_value_error();
    };
    let mut checks = method.stability.checks();
    checks.extend(method.loads.checks());
    checks.push(Box::new(Sequence));
    checks.extend(trial);
    let (evaluator, order) = (Box::new(evaluator), method.order);
    Ok(plan::Planner::new(
        proposer,
        evaluator,
        checks,
        order,
        method.seed,
    ))
}

/// An item of the buffer: its slot, which of the poses that were given of it, and the item.
type Posed = (usize, usize, Py<Item>);

fn poses(buffer: &Bound<'_, PyAny>) -> PyResult<Vec<Posed>> {
    let mut all = Vec::new();
    for (slot, entry) in buffer.try_iter()?.enumerate() {
        let entry = entry?;
        if let Ok(item) = entry.cast::<Item>() {
            all.push((slot, 0, item.clone().unbind()));
            continue;
        }
        let items: Vec<Py<Item>> = entry.extract().map_err(|_| {
            PyTypeError::new_err(format!(
                "slot {slot} of the buffer is neither an item nor a list of items, its poses"
            ))
        })?;
        let items = items.into_iter().enumerate();
        all.extend(items.map(|(pose, item)| (slot, pose, item)));
    }
    Ok(all)
}

fn candidate((slot, pose, item): &Posed) -> Candidate {
    Candidate {
        arrival: *slot,
        pose: *pose,
        ..item.get().candidate.clone()
    }
}

fn exception(py: Python<'_>, error: &PlanError) -> PyErr {
    if let Some(exception) = raised(py, error) {
        return exception;
    }
    match error {
        PlanError::SceneSize { .. } | PlanError::Yaws(_) => {
            PyValueError::new_err(error.to_string())
        }
        _ => PyRuntimeError::new_err(error.to_string()),
    }
}
