//! `ppnpack experiment stream`: items that arrive without an end, packed into several containers that are open at the same time.

mod results;

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_cli::failure::{Failure, OrInput, OrRun, Outcome};
use ppnpack_cli::options::CatalogueOptions;
use ppnpack_cli::sequence::{Sequence, SequenceFile};
use ppnpack_packing::containers::ContainerChoice;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::plan::{Planner, StageError};
use ppnpack_packing::stream::{ContainerSupply, Filled, StreamPlay, play_stream};
use ppnpack_physics::outcome::is_unsteady;
use ppnpack_physics::packing_cell::SimulatedPackingCell;
use serde::{Deserialize, Serialize};

use crate::cases::{Case, cases};
use crate::document;
use crate::filling::apart::{Apart, Physics};
use crate::filling::{self, Bench, Way};
use crate::runs::{Runs, RunsOption};
use crate::workers;
use results::Results;

/// The most containers that are open at the same time.
const MOST_OPEN: u8 = 16;

/// Packs streams into one container after another and into several at the same time, and compares how full they are closed.
#[derive(Debug, Args)]
pub(crate) struct StreamArguments {
    #[command(flatten)]
    catalogue: CatalogueOptions,

    /// A .npy file of sequences, int64 [sequences, length], of object indices; a stream is as many of them as it takes, in their order
    #[arg(long, value_name = "FILE")]
    sequences: PathBuf,

    /// The first stream
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    first: u32,

    /// How many streams
    #[arg(long, value_name = "COUNT", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..))]
    streams: u32,

    /// The items of a stream
    #[arg(long, value_name = "COUNT", default_value_t = 400, value_parser = clap::value_parser!(u32).range(1..))]
    items: u32,

    /// How many containers are open at the same time; the others are compared with the first
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "1,2,3,4",
        value_parser = clap::value_parser!(u8).range(1..=i64::from(MOST_OPEN))
    )]
    open: Vec<u8>,

    /// Which of the open containers an item goes into
    #[arg(long, value_enum, default_value_t = Choice::Fullest)]
    choice: Choice,

    /// A JSON file with the method, in place of placements that are tried on 5 mm and 8 yaws
    #[arg(long, value_name = "FILE")]
    method: Option<PathBuf>,

    /// The physics of the cells that are packed in
    #[arg(long, value_enum, default_value_t = Physics::Own)]
    physics: Physics,

    /// Streams packed at once [default: one per core]
    #[arg(long, value_name = "COUNT", default_value_t = workers::default_count())]
    workers: usize,

    /// Where the document (stream.md) and its figures are written
    #[arg(long, value_name = "DIR", default_value = "out/stream")]
    out: PathBuf,

    #[command(flatten)]
    runs: RunsOption,

    /// Print the results as JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// Which of the open containers an item goes into.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
enum Choice {
    /// The fullest in which an item of the buffer has a valid placement
    Fullest,
    /// That of the valid placement with the best value of all
    Best,
}

impl Choice {
    fn of_containers(self) -> ContainerChoice {
        match self {
            Self::Fullest => ContainerChoice::Fullest,
            Self::Best => ContainerChoice::Best,
        }
    }
}

/// A packed stream.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Run {
    objects: Vec<usize>,
    /// Of each container that was closed, in order.
    closed: Vec<Container>,
    /// Of each that was open at the end.
    open: Vec<Container>,
    /// Items that fit into no empty container.
    unplaceable: usize,
    /// Of each step.
    decision_s: Vec<f64>,
}

/// What a container came to.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Container {
    items: usize,
    placed: usize,
    meshes_m3: f64,
    unsteady: usize,
}

pub(crate) fn run(arguments: &StreamArguments) -> Outcome {
    let way = match &arguments.method {
        Some(path) => Way::read_one(path)?,
        None => Way::usual(),
    };
    let catalogue = filling::catalogue(&arguments.catalogue, &way)?;
    let streams = streams(arguments, &catalogue)?;
    let apart = arguments.physics.apart();
    let folder = arguments.runs.folder(&arguments.out);
    let mut results = Results::new(arguments, &way);
    for open in &arguments.open {
        let packing = Packing {
            way: &way,
            catalogue: &catalogue,
            apart: &apart,
            how: StreamPlay {
                open: usize::from(*open),
                buffer: way.method.buffer,
                choice: arguments.choice.of_containers(),
            },
        };
        let settings = (
            catalogue.content_hash(),
            &way,
            &apart,
            open,
            arguments.choice,
        );
        let kept = Runs::new(&folder, &settings)?;
        let pack = |stream: &Case| {
            let is_right = |run: &Run| run.objects == stream.sequence.objects;
            let name = format!("{:05}", stream.number);
            kept.finish(&name, is_right, || packing.pack(stream))
        };
        let runs = workers::map("Packing", &streams, arguments.workers, pack)?;
        results.add(packing.how.open, &runs);
    }
    let out = &arguments.out;
    document::publish(out, "stream", &results, &results.markdown(), arguments.json)
}

/// The streams, each made of as many sequences of the file as it takes.
fn streams(arguments: &StreamArguments, catalogue: &Catalogue) -> Outcome<Vec<Case>> {
    let file = SequenceFile::read(&arguments.sequences, catalogue)?;
    let items = arguments.items as usize;
    let length = file.get(0)?.objects.len().max(1);
    let sequences = u32::try_from(items.div_ceil(length)).unwrap_or(u32::MAX);
    let available = file.count() / (sequences as usize).max(1);
    let wanted = u64::from(arguments.first) + u64::from(arguments.streams);
    if wanted > available as u64 {
        return Err(Failure::input(format_args!(
            "--first {} --streams {}: the file has enough for {available} streams of {items} items, numbered from 0",
            arguments.first, arguments.streams
        )));
    }
    let stream = |number: u32| {
        let parts = cases(&file, number.saturating_mul(sequences), sequences)?;
        let objects = parts.into_iter().flat_map(|part| part.sequence.objects);
        Ok(Case {
            number,
            sequence: Sequence {
                from: format!("stream {number} of {}", arguments.sequences.display()),
                objects: objects.take(items).collect(),
            },
        })
    };
    let numbers = arguments.first..arguments.first.saturating_add(arguments.streams);
    numbers.map(stream).collect()
}

/// What streams are packed with.
struct Packing<'a> {
    way: &'a Way,
    catalogue: &'a Catalogue,
    apart: &'a Apart,
    how: StreamPlay,
}

impl Packing<'_> {
    fn pack(&self, stream: &Case) -> Outcome<Run> {
        let grid = self.way.grid.build().or_input()?;
        let mut supply = Supply {
            packing: self,
            stream: stream.number,
        };
        let items = stream.sequence.candidates(self.catalogue);
        let packed = play_stream(&grid, &mut supply, items, self.how).or_run()?;
        let of = |filled: &Filled<SimulatedPackingCell>| Container::of(&grid, filled);
        let all = packed.closed.iter().chain(&packed.open);
        let steps = all.flat_map(|filled| &filled.steps);
        let mut decision_s: Vec<(u64, f64)> = steps
            .map(|step| (step.step, step.timings.total().as_secs_f64()))
            .collect();
        decision_s.sort_by_key(|(step, _)| *step);
        Ok(Run {
            objects: stream.sequence.objects.clone(),
            closed: packed.closed.iter().map(of).collect(),
            open: packed.open.iter().map(of).collect(),
            unplaceable: packed.unplaceable.len(),
            decision_s: decision_s.into_iter().map(|(_, took_s)| took_s).collect(),
        })
    }
}

/// Brings the containers of a stream.
struct Supply<'a> {
    packing: &'a Packing<'a>,
    stream: u32,
}

impl ContainerSupply for Supply<'_> {
    type Cell = SimulatedPackingCell;

    fn next(&mut self, number: usize) -> Result<(Planner, SimulatedPackingCell), StageError> {
        let Packing {
            way,
            catalogue,
            apart,
            ..
        } = self.packing;
        // Each container is another draw of what is random.
        let seed = (u64::from(self.stream) << 32) | number as u64;
        let bench = Bench::new(way, catalogue, seed, apart);
        let bench = bench.map_err(|failure| failure.to_string())?;
        Ok((bench.planner, bench.cell))
    }
}

impl Container {
    fn of(grid: &Grid, filled: &Filled<SimulatedPackingCell>) -> Self {
        let packed = filled.packed(grid);
        let reports = || filled.cell.placed().iter().map(|placed| &placed.report);
        Self {
            items: packed.items,
            placed: reports().count(),
            meshes_m3: packed.meshes_m3,
            unsteady: reports()
                .filter(|report| is_unsteady(report.toppled, report.slide_m, report.inside))
                .count(),
        }
    }
}
