//! `ppnpack experiment table1`: packing heuristics compared over test sequences.

use std::path::PathBuf;

use clap::Args;
use ppnpack_chart::{PlotPoint, PointSeries, Scatter};
use ppnpack_cli::failure::Outcome;
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::{Choice, one_of};
use ppnpack_packing::method::ProposalSource;
use ppnpack_packing::objective::{Heuristic, Order};
use serde::Serialize;

use crate::comparison::{
    COMPACTNESS, Comparison, Contender, Means, Results, Row, RowProposals, Run, SHARE, WIDENED,
    point,
};
use crate::document::{self, Answer, Document};
use crate::pareto::GridOption;
use crate::runs::{Part, ShardOptions};
use crate::statistics::Mean;
use crate::table::{Published, TableOptions};

/// Packs the first test sequences with each packing heuristic and compares them.
#[derive(Debug, Args)]
pub(crate) struct Table1Arguments {
    /// A .npy file of sequences, int64 [sequences, length], of object indices
    #[arg(long, value_name = "FILE")]
    sequences: PathBuf,

    /// How many sequences, from the first
    #[arg(long, value_name = "COUNT", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..))]
    cases: u32,

    /// The methods that pack, beside the search of all placements by SDFM, with which they are compared [default: all]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = one_of(&METHODS))]
    methods: Vec<&'static str>,

    /// The grids over the reference container on which the bounded search packs the same sequences, too
    #[arg(long, value_enum, value_name = "LIST", value_delimiter = ',')]
    grids: Vec<GridOption>,

    /// Where report.html, table1.md, table1.json and table1.svg are written
    #[arg(long, value_name = "DIR", default_value = "out/table1")]
    out: PathBuf,

    #[command(flatten)]
    runs: ShardOptions,

    #[command(flatten)]
    table: TableOptions,
}

/// Of seconds; of cm³, percent and items.
fn figures(
    decision_s: Option<f64>,
    [voxels_cm3, compactness_percent, items]: [f64; 3],
) -> Published {
    Published {
        decision_s,
        voxels_cm3: Some(voxels_cm3),
        compactness_percent,
        items,
    }
}

/// The paper's baseline by the rule of its text.
const RANDOM: &str = "Random";

/// The paper's baseline by the rule of its published code.
const PUBLISHED_RANDOM: &str = "Random, as published";

/// The search of all placements, with which the others are compared: the last row.
const SEARCH: &str = "SDFM";

/// Table I of the paper: 2,000 sequences.
pub(crate) static ROWS: [Row; 8] = {
    use Heuristic::{Dbl, Hm, Random, Sdfm};
    use Order::{Balance, BboxVolume, Shuffled};
    [
        Row {
            proposals: RowProposals::Tries,
            ..Row::all(
                PUBLISHED_RANDOM,
                Random,
                Shuffled,
                [0.05, 10_905.0, 39.9, 27.54],
            )
        },
        Row::all(RANDOM, Random, Shuffled, [0.05, 10_905.0, 39.9, 27.54]),
        Row::all("DBL (BBox)", Dbl, BboxVolume, [0.82, 15_073.0, 50.2, 37.17]),
        Row::all("HM (BBox)", Hm, BboxVolume, [0.83, 15_496.0, 51.7, 38.60]),
        Row::all("DBL (Balance)", Dbl, Balance, [1.90, 15_117.0, 50.3, 36.21]),
        Row::all("HM (Balance)", Hm, Balance, [1.64, 14_094.0, 49.2, 38.43]),
        Row {
            proposals: RowProposals::Network,
            ..Row::all("PPN-Pack", Sdfm, Balance, [0.43, 16_525.0, 55.9, 39.88])
        },
        Row::all(SEARCH, Sdfm, Balance, [1.86, 16_897.0, 56.8, 40.77]),
    ]
};

/// The methods as they are asked for: by the names of their rows.
const METHODS: [Choice<&'static str>; 8] = [
    (
        "random-published",
        PUBLISHED_RANDOM,
        "The first of a few placements, as in the published code",
    ),
    ("random", RANDOM, "Any placement, as in the paper's text"),
    (
        "dbl-bbox",
        "DBL (BBox)",
        "Deepest bottom left, items by decreasing bounding box",
    ),
    (
        "hm-bbox",
        "HM (BBox)",
        "Heightmap minimisation, items by decreasing bounding box",
    ),
    (
        "dbl-balance",
        "DBL (Balance)",
        "Deepest bottom left, all items together, large ones early",
    ),
    (
        "hm-balance",
        "HM (Balance)",
        "Heightmap minimisation, all items together, large ones early",
    ),
    (
        "ppn",
        "PPN-Pack",
        "SDF minimisation among what the network proposes",
    ),
    (
        "sdfm",
        SEARCH,
        "SDF minimisation over all placements: always there",
    ),
];

impl Table1Arguments {
    fn is_asked_for(&self, row: &Row) -> bool {
        self.methods.is_empty() || self.methods.contains(&row.name) || row.name == SEARCH
    }
}

/// Sequences that the yardstick was run on.
const YARDSTICK_CASES: usize = 20;

/// The published methods run independently on these meshes in another simulator, first 20 sequences: cm³, percent, items.
const YARDSTICKS: [(&str, [f64; 3]); 4] = [
    (PUBLISHED_RANDOM, [10_998.0, 38.8, 28.9]),
    ("DBL (BBox)", [14_425.0, 47.2, 38.2]),
    ("HM (BBox)", [14_276.0, 47.7, 38.5]),
    (SEARCH, [16_298.0, 55.0, 42.7]),
];

#[derive(Debug, Serialize)]
struct Line {
    method: String,
    #[serde(flatten)]
    means: Means,
    paper: Published,
    /// To the search of all placements by SDFM.
    difference: Difference,
    #[serde(skip_serializing_if = "Option::is_none")]
    yardstick: Option<Yardstick>,
}

/// By how much a method packs more than another one on the same sequences: means of the differences.
#[derive(Debug, Serialize)]
struct Difference {
    items: Mean,
    voxels_cm3: Mean,
    meshes_cm3: Mean,
    floor_compactness_percent: Mean,
}

impl Difference {
    fn of(runs: &[Run], others: &[Run]) -> Self {
        let pairs = || runs.iter().zip(others);
        let mean = |value: fn(&Run) -> f64| {
            Mean::of(pairs().map(|(run, other)| value(run) - value(other)))
        };
        Self {
            items: mean(|run| run.items as f64),
            voxels_cm3: mean(|run| run.voxels_m3 * 1e6),
            meshes_cm3: mean(|run| run.meshes_m3 * 1e6),
            floor_compactness_percent: mean(|run| run.floor_compactness * 100.0),
        }
    }
}

/// The bounded search on one grid.
#[derive(Debug, Serialize)]
struct Bounded {
    grid: &'static str,
    #[serde(flatten)]
    means: Means,
    /// To the search of all placements by SDFM on the table's grid: of items and meshes, as voxels inflate items less on finer grids.
    difference: Difference,
}

#[derive(Debug, Serialize)]
struct Table<'a> {
    #[serde(flatten)]
    methods: Results<'a, Line>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    bounded: Vec<Bounded>,
}

/// The first sequences alone, beside another simulator's results on them.
#[derive(Debug, Serialize)]
struct Yardstick {
    cases: usize,
    floor_compactness_percent: Mean,
    items: Mean,
    voxels_cm3: Mean,
    published: Published,
}

pub(crate) fn run(arguments: &Table1Arguments, backend: &dyn Backend) -> Outcome {
    let comparison = arguments.table.comparison(backend)?;
    let sequences = comparison.sequences(&arguments.sequences, arguments.cases)?;
    let part = arguments.runs.part(&arguments.out);
    let asked_for = ROWS.iter().filter(|row| arguments.is_asked_for(row));
    let (rows, contenders) = comparison.contenders(asked_for);
    let packed = comparison.pack(&contenders, &sequences, &part)?;
    let search = of_search(packed.as_deref().unwrap_or_default());
    let bounded = bounded(arguments, backend, &part, search)?;
    let (Some(packed), Some(bounded)) = (packed, bounded) else {
        return part.tell(arguments.table.json);
    };
    let search = of_search(&packed);
    let methods = rows.into_iter().zip(contenders).zip(&packed);
    let lines = methods.map(|((row, contender), runs)| {
        let [decision_s, packed @ ..] = row.paper;
        Line {
            method: contender.name,
            means: Means::of(runs),
            paper: figures(Some(decision_s), packed),
            difference: Difference::of(runs, search),
            yardstick: yardstick(row.name, runs),
        }
    });
    let table = Table {
        methods: comparison.results(None, lines.collect()),
        bounded,
    };
    let folder = &arguments.out;
    let chart = scatter(&table.methods);
    document::figure(folder, "table1", chart.to_svg([900, 600]))?;
    let document = Document {
        name: "table1",
        answer: Answer {
            question: "How do the packing heuristics and the network compare?",
            text: answer(&table.methods),
            picture: "table1.svg".to_owned(),
        },
        results: &table,
        asked: arguments,
        measured: &["lines", "bounded"],
        markdown: markdown(&table),
    };
    document.publish(folder, arguments.table.json)
}

/// How compactly the search of all placements by SDFM packs, and which other method comes nearest.
fn answer(results: &Results<'_, Line>) -> String {
    let Some((search, others)) = results.lines.split_last() else {
        return "Nothing was packed.".to_owned();
    };
    let compactness = |line: &&Line| line.means.floor_compactness_percent.mean;
    let nearest = others
        .iter()
        .max_by(|one, other| compactness(one).total_cmp(&compactness(other)));
    let nearest = nearest.map_or_else(String::new, |line| {
        let difference = line.difference.floor_compactness_percent.reversed();
        format!(
            " That is {} than {}, the next of {} methods on the same {} sequences.",
            difference.more_or_less(1, "points"),
            line.method,
            results.lines.len(),
            line.means.cases
        )
    });
    format!(
        "{} packs to a compactness of {} % by the floor, and decides in {} ms an item.{nearest}",
        search.method,
        search.means.floor_compactness_percent.shown(1),
        search.means.decision_s.scaled(1e3).shown(2)
    )
}

/// The runs of the search of all placements, which the rows end with; none where only a shard is packed here.
fn of_search(packed: &[Vec<Run>]) -> &[Run] {
    packed.last().map_or(&[], Vec::as_slice)
}

/// The bounded search on each grid; `None` where only a shard is packed here.
fn bounded(
    arguments: &Table1Arguments,
    backend: &dyn Backend,
    part: &Part,
    search: &[Run],
) -> Outcome<Option<Vec<Bounded>>> {
    let mut all = Some(Vec::new());
    for option in &arguments.grids {
        let (_, grid, ..) = option.parts();
        let comparison = Comparison::new(&arguments.table.comparison, backend, option.grid()?)?;
        let sequences = comparison.sequences(&arguments.sequences, arguments.cases)?;
        let contender = Contender {
            name: "SDFM, bounded".to_owned(),
            heuristic: Heuristic::Sdfm,
            order: Order::Balance,
            proposals: ProposalSource::Bounded,
        };
        let packed = comparison.pack(&[contender], &sequences, part)?;
        all = all.zip(packed).map(|(mut all, packed)| {
            all.extend(packed.iter().map(|runs| Bounded {
                grid,
                means: Means::of(runs),
                difference: Difference::of(runs, search),
            }));
            all
        });
    }
    Ok(all)
}

fn yardstick(name: &str, runs: &[Run]) -> Option<Yardstick> {
    let (_, published) = YARDSTICKS.iter().find(|(of, _)| *of == name)?;
    let means = Means::of(runs.get(..YARDSTICK_CASES)?);
    Some(Yardstick {
        cases: YARDSTICK_CASES,
        floor_compactness_percent: means.floor_compactness_percent,
        items: means.items,
        voxels_cm3: means.voxels_cm3,
        published: figures(None, *published),
    })
}

fn markdown(table: &Table<'_>) -> String {
    let results = &table.methods;
    methods_part(results)
        + &differences_part(results)
        + &bounded_part(&table.bounded)
        + &yardstick_part(results)
}

fn methods_part(results: &Results<'_, Line>) -> String {
    let settings = results.settings;
    let container = settings.grid.container();
    let cases = results.lines.first().map_or(0, |line| line.means.cases);
    let mut text = format!(
        "# Table 1: packing heuristics\n\n\
         {cases} sequences, container {:.0} x {:.0} x {:.0} cm, {}, {}. The paper's figures (2,000 sequences, its own \
         meshes and machine) are in brackets. {COMPACTNESS} {SHARE} {WIDENED}{}\n\n\
         | method | decision per item | items packed | voxel volume (cm³) | compactness by floor (%) | compactness by box (%) \
         | mesh volume (cm³) | mesh compactness by floor (%) | fell out | steps widened |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
        container.x_m * 100.0,
        container.y_m * 100.0,
        container.z_m * 100.0,
        settings.cells_in_words(),
        settings.in_words(results.workers),
        random_rows(results.lines.iter().map(|line| line.method.as_str())),
    );
    for line in &results.lines {
        let Line { paper, means, .. } = line;
        text += &format!(
            "| {} | {} ms [{} s] | {} [{:.1}] | {} [{:.0}] | {} [{:.1}] | {} | {} | {} | {:.2} | {} |\n",
            line.method,
            means.decision_s.scaled(1e3).shown(3),
            paper.decision_s.unwrap_or_default(),
            means.items.shown(1),
            paper.items,
            means.voxels_cm3.shown(0),
            paper.voxels_cm3.unwrap_or_default(),
            means.floor_compactness_percent.shown(1),
            paper.compactness_percent,
            means.box_compactness_percent.shown(1),
            means.meshes_cm3.shown(0),
            means.mesh_floor_compactness_percent.shown(1),
            means.fallen_out.mean,
            means.widened(),
        );
    }
    text + &results.missing() + "\n![Compactness against decision time](table1.svg)\n"
}

/// What the rows of random placements do, of those that there are.
pub(crate) fn random_rows<'a>(methods: impl Iterator<Item = &'a str>) -> String {
    let methods: Vec<&str> = methods.collect();
    let is_there = |name| methods.contains(&name);
    let mut text = String::new();
    if is_there(RANDOM) {
        text += &format!(
            " `{RANDOM}` places at any feasible placement, as the paper's text has it, and ends where there is none."
        );
    }
    if is_there(PUBLISHED_RANDOM) {
        text += &format!(
            " `{PUBLISHED_RANDOM}` tries three yaws with three by three positions each, as its published code is read here, and ends where \
             none of these is valid for any item of the buffer."
        );
    }
    text
}

fn differences_part(results: &Results<'_, Line>) -> String {
    let (_, others) = results.lines.split_last().unzip();
    let others = others.unwrap_or_default();
    if others.is_empty() {
        return String::new();
    }
    let mut text = "\n## Against the search of all placements by SDFM\n\nMeans of the differences on the same sequences.\n\n\
         | method | items packed | voxel volume (cm³) | compactness by floor (points) |\n|---|---|---|---|\n"
        .to_owned();
    for line in others {
        let difference = &line.difference;
        text += &format!(
            "| {} | {} | {} | {} |\n",
            line.method,
            difference.items.shown(1),
            difference.voxels_cm3.shown(0),
            difference.floor_compactness_percent.shown(1),
        );
    }
    text
}

fn bounded_part(bounded: &[Bounded]) -> String {
    if bounded.is_empty() {
        return String::new();
    }
    let mut text = "\n## The bounded search on other grids\n\nSDFM (Balance) on the same sequences; it chooses what the search of all \
         placements chooses. Voxels inflate items, less on finer grids: only the volume of the meshes compares across grids. Differences are \
         means to that search on the grid above, on the same sequences.\n\n\
         | grid | decision per item | items packed | difference | mesh volume (cm³) | difference | mesh compactness by floor (%) | fell out |\n\
         |---|---|---|---|---|---|---|---|\n"
        .to_owned();
    for line in bounded {
        let Bounded {
            grid,
            means,
            difference,
        } = line;
        text += &format!(
            "| {grid} | {} ms | {} | {} | {} | {} | {} | {:.2} |\n",
            means.decision_s.scaled(1e3).shown(3),
            means.items.shown(1),
            difference.items.shown(1),
            means.meshes_cm3.shown(0),
            difference.meshes_cm3.shown(0),
            means.mesh_floor_compactness_percent.shown(1),
            means.fallen_out.mean,
        );
    }
    text
}

fn yardstick_part(results: &Results<'_, Line>) -> String {
    let mut text = String::new();
    let lines = results.lines.iter();
    let mut compared = lines
        .filter_map(|line| Some((line, line.yardstick.as_ref()?)))
        .peekable();
    if compared.peek().is_some() {
        text += &format!(
            "\n## The first {YARDSTICK_CASES} sequences\n\nIn brackets an independent run of the published methods on \
             the same meshes and sequences in PyBullet.\n\n\
             | method | compactness by floor (%) | items packed | voxel volume (cm³) |\n|---|---|---|---|\n"
        );
    }
    for (line, comparison) in compared {
        let other = comparison.published;
        text += &format!(
            "| {} | {} [{:.1}] | {} [{:.1}] | {} [{:.0}] |\n",
            line.method,
            comparison.floor_compactness_percent.shown(1),
            other.compactness_percent,
            comparison.items.shown(1),
            other.items,
            comparison.voxels_cm3.shown(0),
            other.voxels_cm3.unwrap_or_default()
        );
    }
    text
}

fn scatter(results: &Results<'_, Line>) -> Scatter {
    let ours = results.lines.iter().map(|line| {
        let decision_ms = line.means.decision_s.scaled(1e3);
        let compactness = &line.means.floor_compactness_percent;
        point(&line.method, &decision_ms, compactness)
    });
    let paper = results.lines.iter().map(|line| PlotPoint {
        label: line.method.clone(),
        x: line.paper.decision_s.unwrap_or_default() * 1e3,
        y: line.paper.compactness_percent,
        ..PlotPoint::default()
    });
    let series = |name: &str, reference, points| PointSeries {
        name: name.to_owned(),
        reference,
        points,
    };
    Scatter {
        title: "Compactness against decision time".to_owned(),
        x_label: "Decision time per item (ms)".to_owned(),
        y_label: "Compactness by the floor (%)".to_owned(),
        series: vec![
            series("ppnpack", false, ours.collect()),
            series("paper", true, paper.collect()),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_method_that_can_be_asked_for_is_a_row() {
        let rows: Vec<&str> = ROWS.iter().map(|row| row.name).collect();
        assert_eq!(METHODS.map(|(_, name, _)| name).as_slice(), rows);
        assert_eq!(rows.last(), Some(&SEARCH));
    }

    #[test]
    fn differences_are_of_the_same_sequence() {
        let run = |items| Run {
            items,
            ..Run::default()
        };
        let (runs, others) = ([run(30), run(50)], [run(29), run(49)]);
        let difference = Difference::of(&runs, &others).items;
        assert_eq!((difference.mean, difference.half_width), (1.0, 0.0));
    }
}
