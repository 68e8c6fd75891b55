//! `ppnpack experiment figure5`: what the methods make of the same objects, side by side.

use std::path::PathBuf;

use clap::Args;
use ppnpack_cli::drawing;
use ppnpack_cli::failure::{Failure, OrRun, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::Network;
use ppnpack_cli::report::Content;
use ppnpack_cli::sequence::SequenceFile;
use ppnpack_files::write_whole;
use ppnpack_packing::episode::Episode;
use ppnpack_packing::grid::Grid;
use ppnpack_picture::{Column, Image, PictureError, Size, gallery};
use serde::Serialize;

use crate::cases::Case;
use crate::comparison::{Comparison, Contender, Setting};
use crate::document;
use crate::tables::{TABLE_1, TableOptions};

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

/// What a method made of the objects.
#[derive(Debug, Clone, Serialize)]
struct Line {
    method: String,
    /// Items that lie in the container.
    items: usize,
    floor_compactness_percent: f64,
    meshes_cm3: f64,
    height_cm: f64,
}

/// A method's result, and how it looks: the container from above its rim, and its heightmap.
struct Packed {
    line: Line,
    pictures: [Image; 2],
}

#[derive(Debug, Serialize)]
struct Results<'a> {
    settings: &'a Setting,
    lines: Vec<Line>,
}

pub(crate) fn run(arguments: &Figure5Arguments, backend: &dyn Backend) -> Outcome {
    let table = &arguments.table;
    let comparison = table.comparison(backend)?;
    let case = case(arguments, &comparison)?;
    let (_, contenders) = table.contenders(&TABLE_1, &comparison);
    let items = comparison.catalogue.items();
    let network = comparison.network(&items);
    let pack = |contender: &Contender| packed(&comparison, contender, &case, network);
    let packed = table.comparison.runs.make(&contenders, pack)?;

    let title = title(arguments);
    let columns: Vec<Column> = packed.iter().map(column).collect();
    let sheet = gallery(&title, &columns).or_run()?.to_png().or_run()?;
    write_whole(&table.out.folder("figure5").join("figure5.png"), &sheet)?;
    let lines = packed.into_iter().map(|packed| packed.line);
    let results = Results {
        settings: &comparison.setting,
        lines: lines.collect(),
    };
    let text = markdown(&results, &title) + &comparison.missing();
    table.out.publish("figure5", &results, &text)
}

/// Which objects are packed.
fn title(arguments: &Figure5Arguments) -> String {
    let file = arguments.sequences.file_name().unwrap_or_default();
    format!(
        "The first {} objects of sequence {} of {}",
        arguments.length,
        arguments.sequence,
        file.display()
    )
}

/// The first objects of the sequence that was asked for.
fn case(arguments: &Figure5Arguments, comparison: &Comparison<'_>) -> Outcome<Case> {
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
    Ok(Case {
        number: arguments.sequence,
        sequence,
    })
}

fn packed(
    comparison: &Comparison<'_>,
    contender: &Contender,
    case: &Case,
    network: Option<Network<'_>>,
) -> Outcome<Packed> {
    let (episode, cell) = comparison.simulate(contender, case, network)?;
    let contents = cell.contents().into_iter();
    let contents: Vec<_> = contents
        .map(|(arrival, body)| (arrival, Content::from(body)))
        .collect();
    let grid = &comparison.setting.grid;
    Ok(Packed {
        line: line(&contender.name, &episode, grid),
        pictures: pictures(grid, &contents, &episode).or_run()?,
    })
}

fn line(method: &str, episode: &Episode, grid: &Grid) -> Line {
    let unit_m = grid.resolution().height_unit_m();
    Line {
        method: method.to_owned(),
        items: episode.metrics.packed.items,
        floor_compactness_percent: 100.0 * episode.metrics.floor_compactness,
        meshes_cm3: 1e6 * episode.metrics.packed.meshes_m3,
        height_cm: 100.0 * unit_m * f64::from(episode.scene.heightmap().max()),
    }
}

fn pictures(
    grid: &Grid,
    contents: &[(usize, Content)],
    episode: &Episode,
) -> Result<[Image; 2], PictureError> {
    let size = Size::new(WIDTH_PX, WIDTH_PX)?;
    let container = drawing::packed(grid, contents.iter(), size)?;
    let heights = drawing::bare_heights(grid, episode.scene.heightmap(), WIDTH_PX)?;
    Ok([container, heights])
}

fn column(packed: &Packed) -> Column {
    let line = &packed.line;
    Column {
        name: line.method.clone(),
        detail: format!(
            "{} items, {:.1} %, {:.1} cm high",
            line.items, line.floor_compactness_percent, line.height_cm
        ),
        pictures: packed.pictures.to_vec(),
    }
}

fn markdown(results: &Results<'_>, title: &str) -> String {
    let settings = results.settings;
    let mut text = format!(
        "# Figure 5: the same objects, packed by each method\n\n{title}; {}, buffer {}, {} stability test. One sequence says little of the methods: see table 1.\n\n\
         ![The containers, and their heightmaps from above](figure5.png)\n\n\
         | method | items packed | compactness by floor (%) | mesh volume (cm³) | height (cm) |\n|---|---|---|---|---|\n",
        settings.cells_in_words(),
        settings.buffer,
        document::name_of(&settings.stability),
    );
    for line in &results.lines {
        text += &format!(
            "| {} | {} | {:.1} | {:.0} | {:.1} |\n",
            line.method,
            line.items,
            line.floor_compactness_percent,
            line.meshes_cm3,
            line.height_cm
        );
    }
    text
}
