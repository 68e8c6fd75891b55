//! A small packing task: boxes, slabs and corner pieces in a container of 12 x 10 cells.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::Path;
use std::sync::Arc;

use nalgebra::Vector3;
use ppnpack_dataset::{
    Dataset, DatasetWriter, Expert, ExpertSettings, FORMAT_VERSION, Recorder, SequenceRecord,
    Settings, draw,
};
use ppnpack_packing::checks::check::BoxedCheck;
use ppnpack_packing::checks::stability::PublishedStability;
use ppnpack_packing::kernel::grid::{ABSENT, ContainerSize, Grid, Resolution, Units, Yaws};
use ppnpack_packing::kernel::item::{Item, ViewSurfaces};
use ppnpack_packing::kernel::objective::{Heuristic, Order, Weights};
use ppnpack_packing::planning::plan::Planner;
use ppnpack_packing::ranking::proposals::ProposeAll;
use ppnpack_packing::ranking::search::{Search, SearchSettings};
use ppnpack_packing::ranking::step::{Candidate, Evaluated, StepInput};
use ppnpack_packing::streams::episode::{IdealCell, Observer, Play, Step, play};

pub(crate) fn grid() -> Grid {
    let resolution = Resolution::new(0.01, 0.002, Yaws::half_turn(2).unwrap()).unwrap();
    let container = ContainerSize::cuboid(0.12, 0.10, 0.08);
    Grid::new(container, resolution).unwrap()
}

/// A block of `nx` x `ny` cells; `has_corner` keeps the cell with the greatest indices.
fn view(nx: usize, ny: usize, height: Units, has_corner: bool) -> ViewSurfaces {
    let mut bottom = vec![0; nx * ny];
    if !has_corner {
        *bottom.last_mut().unwrap() = ABSENT;
    }
    ViewSurfaces {
        nx,
        ny,
        top: vec![height; nx * ny],
        bottom,
        underside: None,
        origin_from_corner_m: Vector3::new(0.01, 0.02, 0.03),
        centre_of_mass_m: None,
    }
}

/// The last is too small to count as stable anywhere.
pub(crate) fn items() -> Vec<Arc<Item>> {
    let shapes = [
        (4, 3, 10, true),
        (5, 5, 4, false),
        (3, 6, 12, false),
        (7, 4, 6, true),
        (2, 2, 5, true),
    ];
    let shapes = shapes.into_iter().enumerate();
    shapes
        .map(|(index, (nx, ny, height, has_corner))| {
            let views = [(nx, ny), (ny, nx)].map(|(nx, ny)| view(nx, ny, height, has_corner));
            Arc::new(Item::new(&format!("item {index}"), views.into(), 1e-4).unwrap())
        })
        .collect()
}

pub(crate) fn settings(has_values: bool) -> Settings {
    Settings {
        format_version: FORMAT_VERSION,
        package_version: "1.2.3".to_owned(),
        catalogue_hash: "c0ffee".to_owned(),
        objects: 5,
        grid: grid(),
        expert: ExpertSettings {
            heuristic: Heuristic::Sdfm,
            order: Order::Balance,
            weights: Weights::default(),
            stability: "published".to_owned(),
            buffer: 3,
        },
        cell: serde_json::json!({"ideal": true, "drop_m": 0.1}),
        seed: 3,
        length: 6,
        has_values,
        sequences: 3,
    }
}

fn checks() -> Vec<BoxedCheck> {
    vec![Box::new(PublishedStability::default())]
}

/// Records an episode and the planner's choices.
struct Watch {
    recorder: Recorder,
    choices: Vec<Evaluated>,
}

impl Observer for Watch {
    fn on_step(&mut self, step: &Step, input: &StepInput<'_>) {
        self.recorder.on_step(step, input);
        self.choices.push(step.choice);
    }
}

/// Plays a sequence; gives its record and what the planner chose at each step.
pub(crate) fn played(settings: &Settings, sequence: u32) -> (SequenceRecord, Vec<Evaluated>) {
    let drawn = draw(settings.seed, sequence, settings.length, settings.objects);
    let items = items();
    let arrivals = drawn.objects.iter();
    let arrivals = arrivals.map(|object| items[*object as usize].clone());
    let arrivals = Candidate::sequence(arrivals);
    let search = SearchSettings {
        heuristic: settings.expert.heuristic,
        order: settings.expert.order,
        weights: settings.expert.weights,
        seed: drawn.seed,
        ..SearchSettings::default()
    };
    let grid = &settings.grid;
    let evaluator = Box::new(Search::new(grid, &search).unwrap());
    let order = settings.expert.order;
    let mut planner = Planner::new(Box::new(ProposeAll), evaluator, checks(), order, drawn.seed);
    let expert = Expert::new(grid, &search, checks(), settings.has_values).unwrap();
    let mut watch = Watch {
        recorder: Recorder::new(expert, sequence, drawn.objects),
        choices: vec![],
    };
    let how = Play::with_buffer(settings.expert.buffer as usize);
    let mut cell = IdealCell::new(grid);
    play(grid, &mut planner, &mut cell, arrivals, how, &mut watch).unwrap();
    (watch.recorder.finish().unwrap(), watch.choices)
}

pub(crate) fn record(settings: &Settings, sequence: u32) -> SequenceRecord {
    played(settings, sequence).0
}

pub(crate) fn writer(folder: &Path, settings: &Settings) -> DatasetWriter {
    DatasetWriter::open(folder, settings.clone(), items()).unwrap()
}

/// Writes a whole dataset.
pub(crate) fn write(folder: &Path, settings: &Settings) -> Dataset {
    let writer = writer(folder, settings);
    for sequence in writer.missing() {
        writer.add(&record(settings, sequence)).unwrap();
    }
    writer.finish().unwrap()
}

/// Every file of a folder with its content.
pub(crate) fn content(folder: &Path) -> BTreeMap<OsString, Vec<u8>> {
    let entries = folder.read_dir().unwrap().map(|entry| entry.unwrap());
    entries
        .map(|entry| (entry.file_name(), std::fs::read(entry.path()).unwrap()))
        .collect()
}
