//! `ppnpack experiment figure5`: what the methods make of the same objects, side by side.

use std::path::PathBuf;

use clap::Args;
use ppnpack_cli::drawing;
use ppnpack_cli::failure::{Failure, OrRun, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::Network;
use ppnpack_cli::report::Content;
use ppnpack_cli::sequence::{Sequence, SequenceFile};
use ppnpack_files::write_whole;
use ppnpack_packing::episode::Episode;
use ppnpack_packing::grid::Grid;
use ppnpack_picture::{Column, Image, PictureError, Size, gallery};
use serde::Serialize;

use crate::comparison::{Comparison, Contender, Results};
use crate::document::{self, Answer, Document};
use crate::table::TableOptions;
use crate::{table1, workers};

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

    /// Where report.html, figure5.png, figure5.md and figure5.json are written
    #[arg(long, value_name = "DIR", default_value = "out/figure5")]
    out: PathBuf,

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

pub(crate) fn run(arguments: &Figure5Arguments, backend: &dyn Backend) -> Outcome {
    let comparison = arguments.table.comparison(backend)?;
    let sequence = sequence(arguments, &comparison)?;
    let (_, contenders) = comparison.contenders(&table1::ROWS);
    let items = comparison.catalogue.items();
    let network = comparison.network(&items);
    let case = arguments.sequence as usize;
    let pack = |contender: &_| packed(&comparison, contender, &sequence, case, network);
    let workers = arguments.table.comparison.workers();
    let packed = workers::map("Packing", &contenders, workers, pack)?;

    let folder = &arguments.out;
    let title = title(arguments);
    let columns: Vec<Column> = packed.iter().map(column).collect();
    let sheet = gallery(&title, &columns).or_run()?.to_png().or_run()?;
    write_whole(&folder.join("figure5.png"), &sheet)?;
    let lines = packed.into_iter().map(|packed| packed.line);
    let results = comparison.results(None, lines.collect());
    let document = Document {
        name: "figure5",
        answer: Answer {
            question: "What do the methods make of the same objects?",
            text: answer(&results),
            picture: "figure5.png".to_owned(),
        },
        results: &results,
        asked: arguments,
        measured: &["lines"],
        markdown: markdown(&results, &title),
    };
    document.publish(folder, arguments.table.json)
}

/// Which method packs them most compactly, and which least.
fn answer(results: &Results<'_, Line>) -> String {
    let mut lines: Vec<&Line> = results.lines.iter().collect();
    let compactness = |line: &Line| line.floor_compactness_percent;
    lines.sort_by(|one, other| compactness(other).total_cmp(&compactness(one)));
    let told = |line: &Line| {
        format!(
            "{} packs {} items to a compactness of {:.1} % by the floor, {:.1} cm high",
            line.method, line.items, line.floor_compactness_percent, line.height_cm
        )
    };
    match lines.as_slice() {
        [] => "Nothing was packed.".to_owned(),
        [one] => format!("{}.", told(one)),
        [best, .., least] => format!(
            "Most compact: {}. Least: {}. It is one sequence alone; table 1 says which is better.",
            told(best),
            told(least)
        ),
    }
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

fn packed(
    comparison: &Comparison<'_>,
    contender: &Contender,
    sequence: &Sequence,
    case: usize,
    network: Option<Network<'_>>,
) -> Outcome<Packed> {
    let (episode, cell) = comparison.simulate(contender, sequence, case, network)?;
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

fn markdown(results: &Results<'_, Line>, title: &str) -> String {
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
    text + &results.missing()
}
