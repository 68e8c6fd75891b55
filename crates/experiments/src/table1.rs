//! `ppnpack experiment table1`: packing heuristics compared over test sequences.

use std::path::PathBuf;

use clap::Args;
use ppnpack_chart::{PlotPoint, PointSeries, Scatter};
use ppnpack_cli::failure::Outcome;
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::GridOptions;
use ppnpack_packing::objective::{Heuristic, Order};
use serde::Serialize;

use crate::comparison::{Comparison, ComparisonOptions, Contender, Means, Run, Setting, point};
use crate::document;
use crate::statistics::Mean;

/// Packs the first test sequences with each packing heuristic and compares them.
#[derive(Debug, Args)]
pub(crate) struct Table1Arguments {
    /// A .npy file of sequences, int64 [sequences, length], of object indices
    #[arg(long, value_name = "FILE")]
    sequences: PathBuf,

    /// How many sequences, from the first
    #[arg(long, value_name = "COUNT", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..))]
    cases: u32,

    #[command(flatten)]
    grid: GridOptions,

    #[command(flatten)]
    comparison: ComparisonOptions,

    /// Where table1.md, table1.json and table1.svg are written
    #[arg(long, value_name = "DIR", default_value = "out/table1")]
    out: PathBuf,

    /// Where finished sequences are kept, so that a killed run goes on [default: runs in --out]
    #[arg(long, value_name = "DIR")]
    runs: Option<PathBuf>,

    /// Print the results as JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// A published result.
#[derive(Debug, Clone, Copy, Serialize)]
struct Published {
    decision_s: Option<f64>,
    voxels_cm3: f64,
    compactness_percent: f64,
    items: f64,
}

/// A row of the table.
struct Row {
    name: &'static str,
    heuristic: Heuristic,
    order: Order,
    /// Whether placements are proposed by the network.
    is_network: bool,
    /// Table I of the paper: 2,000 sequences.
    paper: Published,
    /// The published methods run independently on these meshes in another simulator, first 20 sequences.
    yardstick: Option<Published>,
}

const fn published(
    decision_s: Option<f64>,
    voxels_cm3: f64,
    compactness_percent: f64,
    items: f64,
) -> Published {
    Published {
        decision_s,
        voxels_cm3,
        compactness_percent,
        items,
    }
}

/// Sequences that the yardstick was run on.
const YARDSTICK_CASES: usize = 20;

const ROWS: [Row; 7] = [
    Row {
        name: "Random",
        heuristic: Heuristic::Random,
        order: Order::Shuffled,
        is_network: false,
        paper: published(Some(0.05), 10_905.0, 39.9, 27.54),
        yardstick: Some(published(None, 10_998.0, 38.8, 28.9)),
    },
    Row {
        name: "DBL (BBox)",
        heuristic: Heuristic::Dbl,
        order: Order::BboxVolume,
        is_network: false,
        paper: published(Some(0.82), 15_073.0, 50.2, 37.17),
        yardstick: Some(published(None, 14_425.0, 47.2, 38.2)),
    },
    Row {
        name: "HM (BBox)",
        heuristic: Heuristic::Hm,
        order: Order::BboxVolume,
        is_network: false,
        paper: published(Some(0.83), 15_496.0, 51.7, 38.60),
        yardstick: Some(published(None, 14_276.0, 47.7, 38.5)),
    },
    Row {
        name: "DBL (Balance)",
        heuristic: Heuristic::Dbl,
        order: Order::Balance,
        is_network: false,
        paper: published(Some(1.90), 15_117.0, 50.3, 36.21),
        yardstick: None,
    },
    Row {
        name: "HM (Balance)",
        heuristic: Heuristic::Hm,
        order: Order::Balance,
        is_network: false,
        paper: published(Some(1.64), 14_094.0, 49.2, 38.43),
        yardstick: None,
    },
    Row {
        name: "PPN-Pack",
        heuristic: Heuristic::Sdfm,
        order: Order::Balance,
        is_network: true,
        paper: published(Some(0.43), 16_525.0, 55.9, 39.88),
        yardstick: None,
    },
    Row {
        name: "SDFM",
        heuristic: Heuristic::Sdfm,
        order: Order::Balance,
        is_network: false,
        paper: published(Some(1.86), 16_897.0, 56.8, 40.77),
        yardstick: Some(published(None, 16_298.0, 55.0, 42.7)),
    },
];

/// A row of the results.
#[derive(Debug, Serialize)]
struct Line {
    method: String,
    #[serde(flatten)]
    means: Means,
    paper: Published,
    #[serde(skip_serializing_if = "Option::is_none")]
    yardstick: Option<Yardstick>,
}

/// The first sequences alone, beside another simulator's results on them.
#[derive(Debug, Serialize)]
struct Yardstick {
    cases: usize,
    compactness_percent: Mean,
    items: Mean,
    voxels_cm3: Mean,
    published: Published,
}

#[derive(Debug, Serialize)]
struct Results<'a> {
    machine: String,
    workers: usize,
    settings: &'a Setting,
    /// Why the network's rows are missing, where they are.
    #[serde(skip_serializing_if = "Option::is_none")]
    without_network: Option<String>,
    lines: Vec<Line>,
}

pub(crate) fn run(arguments: &Table1Arguments, backend: &dyn Backend) -> Outcome {
    let options = &arguments.comparison;
    let comparison = Comparison::new(options, backend, arguments.grid.grid()?)?;
    let sequences = comparison.sequences(&arguments.sequences, arguments.cases)?;
    let contender =
        |row: &Row| comparison.contender(row.name, row.heuristic, row.order, row.is_network);
    let (rows, contenders): (Vec<&Row>, Vec<Contender>) = ROWS
        .iter()
        .filter_map(|row| Some((row, contender(row)?)))
        .unzip();
    let kept = arguments.runs.clone();
    let kept = kept.unwrap_or_else(|| arguments.out.join("runs"));
    let packed = comparison.pack(&contenders, &sequences, &kept)?;
    let lines = rows.iter().zip(&contenders).zip(&packed);
    let results = Results {
        machine: document::machine(),
        workers: options.workers(),
        settings: &comparison.setting,
        without_network: comparison.without_network(),
        lines: lines
            .map(|((row, contender), runs)| line(row, contender, runs))
            .collect(),
    };
    publish(arguments, &results)
}

fn line(row: &Row, contender: &Contender, runs: &[Run]) -> Line {
    let first = runs.get(..YARDSTICK_CASES);
    let mean = |value: fn(&Run) -> f64| Mean::of(first.unwrap_or(&[]).iter().map(value));
    let yardstick = row.yardstick.filter(|_| first.is_some());
    Line {
        method: contender.name.clone(),
        means: Means::of(runs),
        paper: row.paper,
        yardstick: yardstick.map(|published| Yardstick {
            cases: YARDSTICK_CASES,
            compactness_percent: mean(|run| run.compactness * 100.0),
            items: mean(|run| run.items as f64),
            voxels_cm3: mean(|run| run.voxels_m3 * 1e6),
            published,
        }),
    }
}

fn publish(arguments: &Table1Arguments, results: &Results<'_>) -> Outcome {
    let folder = &arguments.out;
    let chart = scatter(results);
    document::figure(folder, "table1", chart.to_svg([900, 600]))?;
    let markdown = markdown(results);
    document::publish(folder, "table1", results, &markdown, arguments.json)
}

fn markdown(results: &Results<'_>) -> String {
    let settings = results.settings;
    let container = settings.grid.container();
    let cases = results.lines.first().map_or(0, |line| line.means.cases);
    let mut text = format!(
        "# Table 1: packing heuristics\n\n\
         {cases} sequences, container {:.0} x {:.0} x {:.0} cm, {}, {}. The paper's figures (2,000 sequences, its own \
         meshes and machine) are in brackets.\n\n\
         | method | decision per item | items packed | voxel volume (cm³) | compactness (%) | mesh volume (cm³) | \
         mesh compactness (%) | fell out |\n|---|---|---|---|---|---|---|---|\n",
        container.x_m * 100.0,
        container.y_m * 100.0,
        container.z_m * 100.0,
        settings.cells_in_words(),
        settings.in_words(results.workers),
    );
    for line in &results.lines {
        let Line { paper, means, .. } = line;
        text.push_str(&format!(
            "| {} | {} ms [{} s] | {} [{:.1}] | {} [{:.0}] | {} [{:.1}] | {} | {} | {:.2} |\n",
            line.method,
            means.decision_s.scaled(1e3).shown(3),
            paper.decision_s.unwrap_or_default(),
            means.items.shown(1),
            paper.items,
            means.voxels_cm3.shown(0),
            paper.voxels_cm3,
            means.compactness_percent.shown(1),
            paper.compactness_percent,
            means.meshes_cm3.shown(0),
            means.mesh_compactness_percent.shown(1),
            means.fallen_out.mean
        ));
    }
    if let Some(reason) = &results.without_network {
        text.push_str(&format!("\nPPN-Pack is missing: {reason}.\n"));
    }
    text.push_str("\n![Compactness against decision time](table1.svg)\n");
    let compared: Vec<_> = results
        .lines
        .iter()
        .filter_map(|line| Some((line, line.yardstick.as_ref()?)))
        .collect();
    if !compared.is_empty() {
        text.push_str(&format!("\n## The first {YARDSTICK_CASES} sequences\n\nIn brackets an independent run of the published methods on \
             the same meshes and sequences in PyBullet.\n\n\
             | method | compactness (%) | items packed | voxel volume (cm³) |\n|---|---|---|---|\n"));
        for (line, comparison) in compared {
            let other = comparison.published;
            text.push_str(&format!(
                "| {} | {} [{:.1}] | {} [{:.1}] | {} [{:.0}] |\n",
                line.method,
                comparison.compactness_percent.shown(1),
                other.compactness_percent,
                comparison.items.shown(1),
                other.items,
                comparison.voxels_cm3.shown(0),
                other.voxels_cm3
            ));
        }
    }
    text
}

fn scatter(results: &Results<'_>) -> Scatter {
    let ours = results.lines.iter().map(|line| {
        let decision_ms = line.means.decision_s.scaled(1e3);
        point(&line.method, &decision_ms, &line.means.compactness_percent)
    });
    let paper = results.lines.iter().map(|line| PlotPoint {
        label: line.method.clone(),
        x: line.paper.decision_s.unwrap_or_default() * 1e3,
        y: line.paper.compactness_percent,
        ..PlotPoint::default()
    });
    Scatter {
        title: "Compactness against decision time".to_owned(),
        x_label: "Decision time per item (ms)".to_owned(),
        y_label: "Compactness (%)".to_owned(),
        series: vec![
            PointSeries {
                name: "ppnpack".to_owned(),
                reference: false,
                points: ours.collect(),
            },
            PointSeries {
                name: "paper".to_owned(),
                reference: true,
                points: paper.collect(),
            },
        ],
    }
}
