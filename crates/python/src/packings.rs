//! Many packings that are stepped together, each on one of the machine's cores at a time.

use std::sync::{Arc, Mutex, MutexGuard};

use numpy::ndarray::Dim;
use numpy::{PyArray, PyArray1, PyArray3, PyReadonlyArray1};
use ppnpack_catalogue::object::CatalogueObject;
use ppnpack_packing::kernel::grid::{Grid, Units};
use ppnpack_physics::error::PhysicsError;
use ppnpack_picture::Size;
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;

use crate::arrays::{array, array1, values};
use crate::catalogue::Catalogue;
use crate::cell::{camera_settings, cell_settings};
use crate::error::{OrRaise, not_forked, unused};
use crate::packing::{Observed, ObservedIn, Packing, PaddedMaps, Setup, Stepped as One};

/// Maximum of packings that are stepped together.
const MAX_COUNT: usize = 65_536;

/// Maximum of items that a step may choose from.
const MAX_BUFFER: usize = 256;

/// Maximum of items that arrive.
const MAX_ITEMS: usize = 1_000_000;

/// Packings that are stepped together: what ppnpack.envs is made of.
///
/// Each has an empty container, in which items of a catalogue are packed: `items` arrive in random
/// order, `buffer` of which may be chosen from. Action ((slot * yaws + yaw) * nx + x) * ny + y
/// places the item of a slot. The next item that arrives takes that slot. A placement is possible
/// where the item fits below the rim; with stability="published", where the paper's test accepts it
/// too. physics: whether items are released in a simulated cell, whose settings are those of `cell`
/// over those of "twin" (see SimulatedCell); else they stay where they come to rest. threads: how
/// many step at the same time; as many as the machine has cores where it is not given.
#[pyclass(frozen, module = "ppnpack")]
pub(crate) struct Packings {
    setup: Arc<Setup>,
    packings: Mutex<Vec<Packing>>,
    /// None where one thread is enough: the caller's.
    pool: Option<rayon::ThreadPool>,
    /// The process that has its threads.
    made_in: u32,
}

/// The observation of n packings, in arrays that are the caller's own.
///
/// heightmap: int16 [n, nx, ny], in units. item_top, item_bottom: int16 [n, slot, yaw, nx, ny], the
/// surfaces of the buffer's items from their lowest points, from the footprint's corner on; 0 and
/// -1 where there is no material. action_mask: int8 [n, actions], 1 where an action is possible.
/// objects: int64 [n, slot], indices in the catalogue, -1 in an empty slot.
#[pyclass(frozen, get_all, module = "ppnpack")]
pub(crate) struct Observation {
    heightmap: Py<PyArray<i16, Dim<[usize; 3]>>>,
    item_top: Py<PyArray<i16, Dim<[usize; 5]>>>,
    item_bottom: Py<PyArray<i16, Dim<[usize; 5]>>>,
    resting_height: Py<PyArray<i16, Dim<[usize; 5]>>>,
    action_mask: Py<PyArray<i8, Dim<[usize; 2]>>>,
    objects: Py<PyArray<i64, Dim<[usize; 2]>>>,
}

/// The outcome of a step of n packings.
///
/// reward: float64 [n], by how much the packed share of the container's volume changed. is_over:
/// bool [n], whether nothing can be placed any more or the action was not possible. is_valid: bool
/// [n], whether it was. volume_share: float64 [n]. packed: int64 [n], items in the container.
/// was_reset: bool [n], whether the packing was over before, and began anew in place of a step.
#[pyclass(frozen, get_all, module = "ppnpack")]
pub(crate) struct Stepped {
    reward: Py<PyArray1<f64>>,
    is_over: Py<PyArray1<bool>>,
    is_valid: Py<PyArray1<bool>>,
    was_reset: Py<PyArray1<bool>>,
    volume_share: Py<PyArray1<f64>>,
    packed: Py<PyArray1<i64>>,
}

/// The arrays of an observation before they are moved.
type Buffers = Observed<Vec<Units>, Vec<i8>>;

#[pymethods]
impl Packings {
    #[new]
    #[pyo3(signature = (
        grid, catalogue, count = 1, *, buffer = 5, items = 80, physics = false, stability = "none", cell = None, camera = None,
        threads = None, seed = 0
    ))]
    #[expect(
        clippy::too_many_arguments,
        reason = "they have names where it is called"
    )]
    fn new(
        py: Python<'_>,
        grid: &crate::grid::Grid,
        catalogue: &Catalogue,
        count: usize,
        buffer: usize,
        items: usize,
        physics: bool,
        stability: &str,
        cell: Option<&Bound<'_, PyDict>>,
        camera: Option<&Bound<'_, PyDict>>,
        threads: Option<usize>,
        seed: u64,
    ) -> PyResult<Self> {
        let grid = &grid.inner;
        within("count", count, MAX_COUNT)?;
        within("buffer", buffer, MAX_BUFFER)?;
        within("items", items, MAX_ITEMS)?;
        catalogue.check(grid)?;
        let is_tested = match stability {
            "none" => false,
            "published" => true,
            other => {
                return Err(PyValueError::new_err(format!(
                    "stability is 'none' or 'published', not '{other}'"
                )));
            }
        };
        let settings = cell_settings(grid, "twin", cell)?;
        let settings = physics.then_some(settings);
        let camera = camera_settings(camera)?;
        let objects = catalogue.objects();
        py.detach(|| {
            let maps = objects.iter().map(|it| PaddedMaps::of(grid, &it.item));
            let setup = Arc::new(Setup {
                greatest: greatest(grid, objects, physics),
                grid: grid.clone(),
                objects: objects.to_vec(),
                maps: maps.collect(),
                buffer,
                items,
                is_tested,
                cell: settings,
                camera,
            });
            let seeds = (0..count as u64).map(|number| seed.wrapping_add(number));
            let packings = seeds.map(|seed| Packing::new(Arc::clone(&setup), seed));
            let packings = packings.collect::<Result<_, _>>().or_value_error()?;
            Ok(Self {
                packings: Mutex::new(packings),
                pool: pool(threads, count)?,
                made_in: std::process::id(),
                setup,
            })
        })
    }

    /// Counts the packings.
    fn __len__(&self) -> PyResult<usize> {
        Ok(self.lock()?.len())
    }

    /// The number of actions.
    #[getter]
    fn actions(&self) -> usize {
        self.setup.actions()
    }

    /// The greatest height that is observed, in units: of what may stick out above the rim.
    #[getter]
    fn greatest_height(&self) -> i16 {
        self.setup.greatest
    }

    /// Draws a packing from above, with a colour for each item: uint8 [height, width, 3], RGB.
    #[pyo3(signature = (number = 0, *, width = 640, height = 480))]
    fn picture<'py>(
        &self,
        py: Python<'py>,
        number: usize,
        width: u32,
        height: u32,
    ) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let image = py.detach(|| {
            let size = Size::new(width, height).or_value_error()?;
            let packings = self.lock()?;
            let packing = packings.get(number);
            let none = || PyIndexError::new_err(format!("there is no packing {number}"));
            packing.ok_or_else(none)?.picture(size).or_runtime_error()
        })?;
        let pixels = image.pixels().iter();
        let channels = pixels.flat_map(|pixel| [pixel.red, pixel.green, pixel.blue]);
        array(py, [height as usize, width as usize, 3], channels.collect())
    }

    /// Begins all packings anew. seeds: of each packing a number, or None to go on with its random
    /// numbers. objects: of each packing the objects that arrive, by their indices in the
    /// catalogue, in place of random ones.
    #[pyo3(signature = (seeds = None, objects = None))]
    fn reset(
        &self,
        py: Python<'_>,
        seeds: Option<Vec<Option<u64>>>,
        objects: Option<Vec<Vec<usize>>>,
    ) -> PyResult<Observation> {
        let buffers = py.detach(|| {
            let mut packings = self.lock()?;
            let count = packings.len();
            let seeds = seeds.unwrap_or_else(|| vec![None; count]);
            same_count("seeds", seeds.len(), count)?;
            if let Some(objects) = &objects {
                same_count("sequences of objects", objects.len(), count)?;
                self.check(objects)?;
            }
            let (_, buffers) = self.all(&mut packings, |number, packing| {
                let objects = objects.as_ref().and_then(|all| all.get(number));
                let seed = seeds.get(number).copied().flatten();
                packing.reset(seed, objects.map(Vec::as_slice))
            })?;
            PyResult::Ok((buffers, objects_of(&packings)))
        });
        let (buffers, objects) = buffers?;
        self.observation(py, buffers, objects)
    }

    /// Takes one action in each packing: int64 [n]. With autoreset those that are over begin anew
    /// in place of a step.
    #[pyo3(signature = (actions, *, autoreset = false))]
    fn step(
        &self,
        py: Python<'_>,
        actions: PyReadonlyArray1<'_, i64>,
        autoreset: bool,
    ) -> PyResult<(Observation, Stepped)> {
        let actions = values(&actions);
        let stepped = py.detach(|| {
            let mut packings = self.lock()?;
            same_count("actions", actions.len(), packings.len())?;
            let over: Vec<bool> = packings.iter().map(Packing::is_over).collect();
            if !autoreset && over.contains(&true) {
                let why = "a packing is over: reset it before the next step";
                return Err(PyValueError::new_err(why));
            }
            let (steps, buffers) = self.all(&mut packings, |number, packing| {
                if packing.is_over() {
                    packing.reset(None, None)?;
                    return Ok(One {
                        is_valid: true,
                        ..One::default()
                    });
                }
                packing.step(actions.get(number).copied().unwrap_or(-1))
            })?;
            let outcome = |packing: &Packing| (packing.volume_share(), packing.packed() as i64);
            let outcomes: (Vec<f64>, Vec<i64>) = packings.iter().map(outcome).unzip();
            Ok((steps, buffers, objects_of(&packings), outcomes, over))
        });
        let (steps, buffers, objects, (volume_share, packed), was_reset) = stepped?;
        let of_all = |entry: fn(&One) -> bool| steps.iter().map(entry).collect();
        let result = Stepped {
            reward: array1(py, steps.iter().map(|step| step.reward).collect()).unbind(),
            is_over: array1(py, of_all(|step| step.is_over)).unbind(),
            is_valid: array1(py, of_all(|step| step.is_valid)).unbind(),
            was_reset: array1(py, was_reset).unbind(),
            volume_share: array1(py, volume_share).unbind(),
            packed: array1(py, packed).unbind(),
        };
        Ok((self.observation(py, buffers, objects)?, result))
    }
}

impl Packings {
    fn lock(&self) -> PyResult<MutexGuard<'_, Vec<Packing>>> {
        unused(
            &self.packings,
            "the packings are being stepped by another thread",
        )
    }

    /// Does something with each packing, spread over the threads, and observes it afterwards.
    fn all<T: Send>(
        &self,
        packings: &mut [Packing],
        act: impl Fn(usize, &mut Packing) -> Result<T, PhysicsError> + Sync,
    ) -> PyResult<(Vec<T>, Buffers)> {
        let (cells, actions) = (self.setup.cells(), self.setup.actions());
        let mut buffers = Buffers {
            heightmap: vec![0; packings.len() * cells],
            top: vec![0; packings.len() * actions],
            bottom: vec![0; packings.len() * actions],
            resting: vec![0; packings.len() * actions],
            mask: vec![0; packings.len() * actions],
        };
        let one = |(number, (packing, into)): (usize, (&mut Packing, ObservedIn<'_>))| {
            let result = act(number, packing)?;
            packing.observe(into);
            Ok(result)
        };
        let observed = buffers.per_packing(cells, actions);
        let all = packings.iter_mut().zip(observed).enumerate();
        let results: Result<Vec<T>, PhysicsError> = match &self.pool {
            None => all.map(one).collect(),
            Some(pool) => {
                not_forked(self.made_in)?;
                let all: Vec<_> = all.collect();
                pool.install(|| all.into_par_iter().map(one).collect())
            }
        };
        Ok((results.or_runtime_error()?, buffers))
    }

    fn check(&self, objects: &[Vec<usize>]) -> PyResult<()> {
        let known = self.setup.objects.len();
        let outside = objects.iter().flatten().find(|object| **object >= known);
        outside.map_or(Ok(()), |object| {
            Err(PyValueError::new_err(format!(
                "there is no object {object}: the catalogue has objects 0 to {}",
                known.saturating_sub(1)
            )))
        })
    }

    fn observation(
        &self,
        py: Python<'_>,
        buffers: Buffers,
        objects: Vec<i64>,
    ) -> PyResult<Observation> {
        let [yaws, nx, ny] = self.setup.shape();
        let slots = self.setup.buffer;
        let count = objects.len() / slots;
        let items = [count, slots, yaws, nx, ny];
        Ok(Observation {
            heightmap: array(py, [count, nx, ny], buffers.heightmap)?.unbind(),
            item_top: array(py, items, buffers.top)?.unbind(),
            item_bottom: array(py, items, buffers.bottom)?.unbind(),
            resting_height: array(py, items, buffers.resting)?.unbind(),
            action_mask: array(py, [count, self.setup.actions()], buffers.mask)?.unbind(),
            objects: array(py, [count, slots], objects)?.unbind(),
        })
    }
}

impl Buffers {
    fn per_packing(
        &mut self,
        cells: usize,
        actions: usize,
    ) -> impl Iterator<Item = ObservedIn<'_>> {
        let heightmaps = self.heightmap.chunks_exact_mut(cells);
        let tops = self.top.chunks_exact_mut(actions);
        let bottoms = self.bottom.chunks_exact_mut(actions);
        let resting = self.resting.chunks_exact_mut(actions);
        let masks = self.mask.chunks_exact_mut(actions);
        let items = tops.zip(bottoms).zip(resting);
        let all = heightmaps.zip(items).zip(masks);
        all.map(|((heightmap, ((top, bottom), resting)), mask)| ObservedIn {
            heightmap,
            top,
            bottom,
            resting,
            mask,
        })
    }
}

/// Gives the objects in the buffers of all packings.
fn objects_of(packings: &[Packing]) -> Vec<i64> {
    packings.iter().flat_map(Packing::objects).collect()
}

/// Starts threads to step `count` packings with; None where there is no use for more than the
/// caller's.
fn pool(threads: Option<usize>, count: usize) -> PyResult<Option<rayon::ThreadPool>> {
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    let threads = threads.unwrap_or_else(cores).min(count);
    if threads < 2 {
        return Ok(None);
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map(Some).or_runtime_error()
}

/// Gives the greatest height of what is observed of these objects, in units. With physics an item
/// may end on the rim, and stand on its end there.
fn greatest(grid: &Grid, objects: &[CatalogueObject], physics: bool) -> Units {
    let bounds = objects
        .iter()
        .filter_map(|object| object.model.mesh.bounds());
    let longest_m = bounds.map(|bounds| bounds.extents_m().norm());
    let longest_m = longest_m.fold(0.0, f64::max);
    let longest = grid.resolution().units_above(longest_m);
    match physics {
        true => grid.rim().saturating_add(longest),
        false => grid.rim().max(longest),
    }
}

fn within(name: &str, number: usize, most: usize) -> PyResult<()> {
    if (1..=most).contains(&number) {
        return Ok(());
    }
    Err(PyValueError::new_err(format!(
        "{name} must be between 1 and {most}, but is {number}"
    )))
}

fn same_count(what: &str, given: usize, packings: usize) -> PyResult<()> {
    if given == packings {
        return Ok(());
    }
    Err(PyValueError::new_err(format!(
        "{given} {what} were given for {packings} packings"
    )))
}
