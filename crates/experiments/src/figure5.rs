//! `ppnpack experiment figure5`: what the methods make of the same objects, side by side.

use std::path::PathBuf;

use clap::Args;
use ppnpack_cli::drawing;
use ppnpack_cli::failure::{Failure, OrRun, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_cli::report::Content;
use ppnpack_cli::sequence::{Sequence, SequenceFile};
use ppnpack_files::write_whole;
use ppnpack_packing::episode::Episode;
use ppnpack_packing::grid::Grid;
use ppnpack_physics::packing_cell::SimulatedPackingCell;
use ppnpack_picture::{Column as Pictures, Image, PictureError, Size, gallery};

use crate::comparison::Comparison;
use crate::packer::Run;
use crate::sheet::{Cell, Column, Lines};
use crate::tables::{TABLE_1, TableOptions};
use crate::way::Way;
use crate::workers;

/// A column of this experiment's tables.
type Measured = Column<'static, Run>;

/// The width of a picture, in pixels.
const WIDTH_PX: u32 = 360;

/// Packs the first objects of one sequence with each packing heuristic, and draws what becomes of them.
#[derive(Debug, Args)]
pub(crate) struct Figure5Arguments {
    /// A .npy file of sequences, int64 [sequences, length], of object indices
    #[arg(long, value_name = "FILE")]
    sequences: PathBuf,

    /// Which of them, numbered from 0
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    sequence: u32,

    /// How many of its objects, from the first; the paper shows packings of 25
    #[arg(long, value_name = "COUNT", default_value_t = 25, value_parser = clap::value_parser!(u32).range(1..))]
    length: u32,

    #[command(flatten)]
    table: TableOptions,
}

pub(crate) fn run(arguments: &Figure5Arguments, backend: &dyn Backend) -> Outcome {
    let table = &arguments.table;
    let options = &table.comparison;
    let comparison = table.comparison(backend)?;
    let sequence = sequence(arguments, &comparison)?;
    let (_, ways) = table.ways(&TABLE_1, &comparison);
    let seed = options.seed.wrapping_add(u64::from(arguments.sequence));
    let (grid, workers) = (&comparison.grid, options.runs.workers());
    let packed = workers::map("Packing", &ways, workers, |way: &Way| {
        let (episode, cell) = comparison.packer(way).play(&sequence, seed, &mut ())?;
        let run = Run::of(&sequence, grid, &episode, &cell);
        let column = Pictures {
            name: way.name.clone(),
            detail: format!(
                "{} items, {:.1} %, {:.1} cm high",
                run.items,
                100.0 * run.floor_compactness,
                100.0 * run.height_m
            ),
            pictures: pictures(grid, &cell, &episode).or_run()?.into(),
        };
        Ok((column, run))
    })?;
    let (columns, runs): (Vec<Pictures>, Vec<Run>) = packed.into_iter().unzip();
    let file = arguments.sequences.file_name().unwrap_or_default();
    let title = format!(
        "The first {} objects of sequence {} of {}",
        arguments.length,
        arguments.sequence,
        file.display()
    );
    let sheet = gallery(&title, &columns).or_run()?.to_png().or_run()?;
    let folder = options.out.folder("figure5");
    write_whole(&folder.join("figure5.png"), &sheet)?;
    let names = ways.into_iter().map(|way| way.name);
    let runs = names.zip(runs.into_iter().map(|run| vec![run]));
    let mut lines = Lines::new("method", runs.collect());
    let head = format!(
        "# Figure 5: the same objects, packed by each method\n\n{title}. One sequence says little of the methods: see table 1."
    );
    let mut page = comparison.page("figure5", &head);
    page.say(&format!(
        "\n![The containers, and their heightmaps from above](figure5.png)\n\n{}",
        lines.table("method", &figures())
    ));
    page.keep("lines", lines);
    page.publish(&options.out)
}

/// What is said of the only run of each method.
fn figures() -> Vec<Measured> {
    let of = |key, head, decimals, value: fn(&Run) -> f64| {
        Measured::new(key, head, move |runs: &[Run]| {
            Cell::number(runs.first().map_or(f64::NAN, value), decimals)
        })
    };
    vec![
        Measured::sum("items", "items packed", |run: &Run| run.items),
        of(
            "floor_compactness_percent",
            "compactness by floor (%)",
            1,
            |run| 100.0 * run.floor_compactness,
        ),
        of("meshes_cm3", "mesh volume (cm³)", 0, Run::meshes_cm3),
        of("height_cm", "height (cm)", 1, |run| 100.0 * run.height_m),
    ]
}

/// The first objects of the sequence that was asked for.
fn sequence(arguments: &Figure5Arguments, comparison: &Comparison<'_>) -> Outcome<Sequence> {
    let file = &arguments.sequences;
    let sequences = SequenceFile::read(file, &comparison.catalogue)?;
    let (number, length) = (arguments.sequence as usize, arguments.length as usize);
    if number >= sequences.count() {
        return Err(Failure::input(format_args!(
            "--sequence {number}: {} has {} sequences, numbered from 0",
            file.display(),
            sequences.count()
        )));
    }
    let mut sequence = sequences.get(number)?;
    if length > sequence.objects.len() {
        return Err(Failure::input(format_args!(
            "--length {length}: the sequences of {} have {} objects",
            file.display(),
            sequence.objects.len()
        )));
    }
    sequence.objects.truncate(length);
    Ok(sequence)
}

/// The container from above its rim, and its heightmap.
fn pictures(
    grid: &Grid,
    cell: &SimulatedPackingCell,
    episode: &Episode,
) -> Result<[Image; 2], PictureError> {
    let contents = cell.contents().into_iter();
    let contents: Vec<_> = contents
        .map(|(arrival, body)| (arrival, Content::from(body)))
        .collect();
    let size = Size::new(WIDTH_PX, WIDTH_PX)?;
    let container = drawing::packed(grid, contents.iter(), size)?;
    let heights = drawing::bare_heights(grid, episode.scene.heightmap(), WIDTH_PX)?;
    Ok([container, heights])
}
