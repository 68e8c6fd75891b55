//! `ppnpack experiment table1`, `table2` and `table4`: packing heuristics and the network compared over sequences.

use std::path::PathBuf;

use clap::Args;
use ppnpack_catalogue::shape_class::{REGULAR_SHARE, ShapeClass};
use ppnpack_chart::{PlotPoint, PointSeries, Scatter};
use ppnpack_cli::failure::{Failure, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::{Choice, Conditions, GridOptions, one_of};
use ppnpack_packing::method::ProposalSource;
use ppnpack_packing::objective::{Heuristic, Order};
use serde::Serialize;

use crate::cases::{self, Case, SequenceOptions};
use crate::comparison::{
    COMPACTNESS, Comparison, ComparisonOptions, Contender, Means, Row, RowProposals, Run, SHARE,
    Setting, WIDENED, point, ratio_percent,
};
use crate::document::{self, OutOptions};
use crate::pareto::GridOption;
use crate::statistics::Mean;

/// What the tables are told alike.
#[derive(Debug, Args)]
pub(crate) struct TableOptions {
    /// The methods that pack, beside the search of all placements by SDFM, with which they are compared [default: all of the table]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = one_of(&METHODS))]
    methods: Vec<&'static str>,

    #[command(flatten)]
    grid: GridOptions,

    #[command(flatten)]
    pub(crate) comparison: ComparisonOptions,

    #[command(flatten)]
    pub(crate) out: OutOptions,
}

/// Random sequences of the catalogue's objects.
#[derive(Debug, Args)]
pub(crate) struct DrawnOptions<const CASES: u32, const LENGTH: u32> {
    /// The first sequence
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    first: u32,

    /// How many sequences, of each class of objects where there are several
    #[arg(long, value_name = "COUNT", default_value_t = CASES, value_parser = clap::value_parser!(u32).range(1..))]
    cases: u32,

    /// Objects in a sequence
    #[arg(long, value_name = "COUNT", default_value_t = LENGTH, value_parser = clap::value_parser!(u32).range(1..))]
    length: u32,
}

impl<const CASES: u32, const LENGTH: u32> DrawnOptions<CASES, LENGTH> {
    fn draw(&self, comparison: &Comparison<'_>) -> Vec<Case> {
        let numbers = self.first..self.first.saturating_add(self.cases);
        let objects = comparison.catalogue.len();
        cases::draw(comparison.setting.seed, numbers, self.length, objects)
    }
}

/// Packs test sequences with each packing heuristic and compares them.
#[derive(Debug, Args)]
pub(crate) struct Table1Arguments {
    #[command(flatten)]
    sequences: SequenceOptions<0, 100>,

    /// The grids over the reference container on which the bounded search packs the same sequences, too
    #[arg(long, value_enum, value_name = "LIST", value_delimiter = ',')]
    grids: Vec<GridOption>,

    #[command(flatten)]
    table: TableOptions,
}

/// Packs random sequences of the catalogue's regular objects, and of its irregular ones, with the network's proposals and
/// searching all placements. The sets of objects that the paper compares with hierarchical reinforcement learning on are not
/// published: regular is here what fills at least half of its bounding box.
#[derive(Debug, Args)]
pub(crate) struct Table2Arguments {
    #[command(flatten)]
    drawn: DrawnOptions<100, 50>,

    /// The weights of a network trained on the regular objects alone [default: those of --model]
    #[arg(long, value_name = "FILE")]
    regular_model: Option<PathBuf>,

    /// The weights of a network trained on the irregular objects alone [default: those of --model]
    #[arg(long, value_name = "FILE")]
    irregular_model: Option<PathBuf>,

    #[command(flatten)]
    table: TableOptions,
}

/// Packs random sequences of unseen objects: at random, with the network's proposals, searching all placements. Give a
/// --catalogue that the network was not trained on.
#[derive(Debug, Args)]
pub(crate) struct Table4Arguments {
    #[command(flatten)]
    drawn: DrawnOptions<400, 80>,

    #[command(flatten)]
    table: TableOptions,
}

/// The methods as they are asked for.
const METHODS: [Choice<&'static str>; 8] = [
    (
        "random-published",
        "random-published",
        "The first of a few placements, as the published code is read here",
    ),
    ("random", "random", "Any placement, as in the paper's text"),
    (
        "dbl-bbox",
        "dbl-bbox",
        "Deepest bottom left, items by decreasing bounding box",
    ),
    (
        "hm-bbox",
        "hm-bbox",
        "Heightmap minimisation, items by decreasing bounding box",
    ),
    (
        "dbl-balance",
        "dbl-balance",
        "Deepest bottom left, all items together, large ones early",
    ),
    (
        "hm-balance",
        "hm-balance",
        "Heightmap minimisation, all items together, large ones early",
    ),
    (
        "ppn",
        "ppn",
        "SDF minimisation among what the network proposes",
    ),
    (
        "sdfm",
        "sdfm",
        "SDF minimisation over all placements: always there",
    ),
];

/// A row that searches all placements.
const fn all(
    key: &'static str,
    name: &'static str,
    (heuristic, order): (Heuristic, Order),
    paper: Option<[f64; 4]>,
) -> Row {
    Row {
        key,
        name,
        heuristic,
        order,
        proposals: RowProposals::All,
        paper,
    }
}

const fn network(paper: Option<[f64; 4]>) -> Row {
    Row {
        proposals: RowProposals::Network,
        ..all("ppn", "PPN-Pack", SDFM, paper)
    }
}

/// The paper's baseline, by the rule of its code as it is read here, and by the rule of its text.
const fn random(paper: [f64; 4]) -> [Row; 2] {
    const RANDOM: (Heuristic, Order) = (Heuristic::Random, Order::Shuffled);
    let tries = Row {
        proposals: RowProposals::Tries,
        ..all(
            "random-published",
            "Random, as published",
            RANDOM,
            Some(paper),
        )
    };
    [tries, all("random", "Random", RANDOM, Some(paper))]
}

const SDFM: (Heuristic, Order) = (Heuristic::Sdfm, Order::Balance);

/// Table I of the paper: 2,000 sequences.
pub(crate) static TABLE_1: [Row; 8] = {
    use Heuristic::{Dbl, Hm};
    use Order::{Balance, BboxVolume};
    let [tries, random] = random([0.05, 10_905.0, 39.9, 27.54]);
    [
        tries,
        random,
        all(
            "dbl-bbox",
            "DBL (BBox)",
            (Dbl, BboxVolume),
            Some([0.82, 15_073.0, 50.2, 37.17]),
        ),
        all(
            "hm-bbox",
            "HM (BBox)",
            (Hm, BboxVolume),
            Some([0.83, 15_496.0, 51.7, 38.60]),
        ),
        all(
            "dbl-balance",
            "DBL (Balance)",
            (Dbl, Balance),
            Some([1.90, 15_117.0, 50.3, 36.21]),
        ),
        all(
            "hm-balance",
            "HM (Balance)",
            (Hm, Balance),
            Some([1.64, 14_094.0, 49.2, 38.43]),
        ),
        network(Some([0.43, 16_525.0, 55.9, 39.88])),
        all("sdfm", "SDFM", SDFM, Some([1.86, 16_897.0, 56.8, 40.77])),
    ]
};

/// Table II of the paper is of other objects, and told apart: [`published`].
static TABLE_2: [Row; 2] = [network(None), all("sdfm", "Search all", SDFM, None)];

/// Table IV of the paper: 400 cases of its 28 unseen objects.
static TABLE_4: [Row; 4] = {
    let [tries, random] = random([0.37, 19_029.0, 39.5, 27.54]);
    [
        tries,
        random,
        network(Some([0.45, 22_993.0, 47.3, 33.69])),
        all(
            "sdfm",
            "Search all",
            SDFM,
            Some([1.58, 25_001.0, 49.8, 34.26]),
        ),
    ]
};

#[derive(Debug, Serialize)]
struct Line {
    /// Of the objects, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    class: Option<&'static str>,
    method: String,
    #[serde(flatten)]
    means: Means,
    /// Seconds, cm³, percent, items.
    #[serde(skip_serializing_if = "Option::is_none")]
    paper: Option<[f64; 4]>,
    /// To the search of all placements, on the same sequences.
    difference: Difference,
    /// Of that search's.
    floor_compactness_ratio_percent: Mean,
    mesh_volume_ratio_percent: Mean,
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

/// The objects of one class.
#[derive(Debug, Serialize)]
struct Class {
    name: &'static str,
    objects: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Results<'a> {
    settings: &'a Setting,
    workers: usize,
    objects: usize,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    classes: Vec<Class>,
    #[serde(skip_serializing_if = "Option::is_none")]
    without_network: Option<String>,
    lines: Vec<Line>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    bounded: Vec<Bounded>,
}

impl TableOptions {
    /// The comparison in the paper's conditions.
    pub(crate) fn comparison<'a>(&'a self, backend: &'a dyn Backend) -> Outcome<Comparison<'a>> {
        let grid = self.grid.grid(Conditions::Reference)?;
        Comparison::new(&self.comparison, backend, grid)
    }

    /// Those rows of a table that are asked for, and their methods.
    pub(crate) fn contenders(
        &self,
        rows: &'static [Row],
        comparison: &Comparison<'_>,
    ) -> (Vec<&'static Row>, Vec<Contender>) {
        let is_asked_for = |row: &&Row| {
            self.methods.is_empty() || self.methods.contains(&row.key) || row.key == "sdfm"
        };
        comparison.contenders(rows.iter().filter(is_asked_for))
    }

    /// What a table's rows come to on these sequences, and the runs of the last: the search of all placements.
    fn lines(
        &self,
        name: &str,
        rows: &'static [Row],
        comparison: &Comparison<'_>,
        class: Option<ShapeClass>,
        cases: &[Case],
    ) -> Outcome<(Vec<Line>, Vec<Run>)> {
        let (rows, contenders) = self.contenders(rows, comparison);
        let kept = self.comparison.runs.folder(&self.out, name);
        let packed = comparison.pack(&contenders, cases, &kept)?;
        let search = packed.last().cloned().unwrap_or_default();
        let methods = rows.into_iter().zip(contenders).zip(packed);
        let lines = methods.map(|((row, contender), runs)| Line {
            class: class.map(name_of),
            method: contender.name,
            means: Means::of(&runs),
            paper: row.paper,
            difference: Difference::of(&runs, &search),
            floor_compactness_ratio_percent: ratio_percent(&runs, &search, |run| {
                run.floor_compactness
            }),
            mesh_volume_ratio_percent: ratio_percent(&runs, &search, |run| run.meshes_m3),
        });
        Ok((lines.collect(), search))
    }

    fn results<'a>(&self, comparison: &'a Comparison<'_>, lines: Vec<Line>) -> Results<'a> {
        Results {
            settings: &comparison.setting,
            workers: self.comparison.runs.workers(),
            objects: comparison.catalogue.len(),
            classes: Vec::new(),
            without_network: comparison.without_network(),
            lines,
            bounded: Vec::new(),
        }
    }

    /// The bounded search on other grids.
    fn bounded(
        &self,
        arguments: &Table1Arguments,
        backend: &dyn Backend,
        search: &[Run],
    ) -> Outcome<Vec<Bounded>> {
        let kept = self.comparison.runs.folder(&self.out, "table1");
        let on_grid = |option: &GridOption| {
            let (_, grid, ..) = option.parts();
            let comparison = Comparison::new(&self.comparison, backend, option.grid()?)?;
            let cases = arguments.sequences.read(&comparison.catalogue)?;
            let contender = Contender {
                name: "SDFM, bounded".to_owned(),
                heuristic: Heuristic::Sdfm,
                order: Order::Balance,
                proposals: ProposalSource::Bounded,
            };
            let runs = comparison.pack(&[contender], &cases, &kept)?.concat();
            Ok(Bounded {
                grid,
                means: Means::of(&runs),
                difference: Difference::of(&runs, search),
            })
        };
        arguments.grids.iter().map(on_grid).collect()
    }

    /// Writes a table, its chart and its figures.
    fn publish(&self, name: &str, head: &str, results: &Results<'_>, missing: &str) -> Outcome {
        let settings = results.settings;
        let container = settings.grid.container();
        let [x_cm, y_cm, z_cm] =
            [container.x_m, container.y_m, container.z_m].map(|side_m| side_m * 100.0);
        let cells = settings.cells_in_words();
        let how = settings.in_words(results.workers);
        let mut text = format!(
            "{head} Container {x_cm:.0} x {y_cm:.0} x {z_cm:.0} cm, {cells}, {how}. {COMPACTNESS} {SHARE} {WIDENED} The network, where it is a \
             row, is this project's.{}\n",
            random_rows(&results.lines)
        );
        if results.classes.is_empty() {
            text += &methods_part(&results.lines);
        }
        for class in &results.classes {
            let of_class = results.lines.iter();
            let of_class = of_class.filter(|line| line.class == Some(class.name));
            text += &format!("\n## {} {} objects\n", class.objects.len(), class.name);
            text += &methods_part(of_class);
            text += &published(class.name);
        }
        text += missing;
        text += &bounded_part(&results.bounded);
        text += &format!("\n![Compactness against decision time]({name}.svg)\n");
        let chart = scatter(&results.lines).to_svg([900, 600]);
        document::figure(&self.out.folder(name), name, chart)?;
        self.out.publish(name, results, &text)
    }
}

pub(crate) fn table1(arguments: &Table1Arguments, backend: &dyn Backend) -> Outcome {
    let table = &arguments.table;
    let comparison = table.comparison(backend)?;
    let cases = arguments.sequences.read(&comparison.catalogue)?;
    let (lines, search) = table.lines("table1", &TABLE_1, &comparison, None, &cases)?;
    let results = Results {
        bounded: table.bounded(arguments, backend, &search)?,
        ..table.results(&comparison, lines)
    };
    let head = format!(
        "# Table 1: packing heuristics\n\nSequences {} to {}. The paper's figures (2,000 sequences, its own meshes and machine) are in brackets.",
        arguments.sequences.first,
        arguments.sequences.last()
    );
    table.publish("table1", &head, &results, &comparison.missing())
}

pub(crate) fn table2(arguments: &Table2Arguments, backend: &dyn Backend) -> Outcome {
    let table = &arguments.table;
    let comparison = table.comparison(backend)?;
    // What is wrong with either class is said before anything is packed.
    let of_class = |class: ShapeClass| {
        let model = match class {
            ShapeClass::Regular => &arguments.regular_model,
            ShapeClass::Irregular => &arguments.irregular_model,
        };
        let of_class = comparison.of_class(class, model.as_deref())?;
        if of_class.catalogue.is_empty() {
            return Err(Failure::input(format_args!(
                "no object of the catalogue is {}: choose another --catalogue",
                name_of(class)
            )));
        }
        Ok((class, of_class))
    };
    let of_classes = ShapeClass::ALL.into_iter().map(of_class);
    let of_classes: Vec<(ShapeClass, Comparison<'_>)> = of_classes.collect::<Outcome<_>>()?;
    let (mut lines, mut classes) = (Vec::new(), Vec::new());
    for (class, comparison) in &of_classes {
        let cases = arguments.drawn.draw(comparison);
        let (of_class, _) = table.lines("table2", &TABLE_2, comparison, Some(*class), &cases)?;
        lines.extend(of_class);
        let objects = comparison.catalogue.objects.iter();
        classes.push(Class {
            name: name_of(*class),
            objects: objects.map(|object| object.model.name.clone()).collect(),
        });
    }
    let results = Results {
        classes,
        ..table.results(&comparison, lines)
    };
    let head = format!(
        "# Table 2: easy and hard shapes\n\n{} random sequences of each class. Regular is what fills at least {:.0} % of its bounding box; \
         all other objects are irregular. The paper's objects are not published: its rows are of other objects, marked so, and say nothing \
         about ours.",
        arguments.drawn.cases,
        100.0 * REGULAR_SHARE
    );
    table.publish("table2", &head, &results, &comparison.missing())
}

pub(crate) fn table4(arguments: &Table4Arguments, backend: &dyn Backend) -> Outcome {
    let table = &arguments.table;
    let comparison = table.comparison(backend)?;
    let cases = arguments.drawn.draw(&comparison);
    let (lines, _) = table.lines("table4", &TABLE_4, &comparison, None, &cases)?;
    let results = table.results(&comparison, lines);
    let head = format!(
        "# Table 4: objects that the network was not trained on\n\n{} random sequences of {} objects, seed {}. In brackets the paper's \
         figures (400 sequences of its 28 objects): its volumes need a container of some 48 litres, so that of these only shares compare.",
        arguments.drawn.cases, results.objects, results.settings.seed
    );
    table.publish("table4", &head, &results, &comparison.missing())
}

fn name_of(class: ShapeClass) -> &'static str {
    match class {
        ShapeClass::Regular => "regular",
        ShapeClass::Irregular => "irregular",
    }
}

/// Table II of the paper, 50 easy and 50 hard objects a sequence, as rows: seconds, percent, items.
fn published(class: &str) -> String {
    let rows = match class {
        "regular" => [[0.97, 45.6, 40.38], [0.87, 47.9, 44.16]],
        _ => [[0.97, 42.3, 37.28], [0.93, 42.4, 45.61]],
    };
    let methods = ["hierarchical reinforcement learning", "PPN-Pack"];
    let mut text = "\n| the paper, on its own objects | decision per item (s) | compactness (%) | items packed |\n|---|---|---|---|\n".to_owned();
    for (method, [decision_s, compactness, items]) in methods.iter().zip(rows) {
        text += &format!("| *{method}* | {decision_s} | {compactness:.1} | {items:.2} |\n");
    }
    text
}

/// What the rows of random placements do, of those that there are.
fn random_rows(lines: &[Line]) -> String {
    let is_there = |name| lines.iter().any(|line| line.method == name);
    let mut text = String::new();
    if is_there("Random") {
        text += " `Random` places at any feasible placement, as the paper's text has it, and ends where there is none.";
    }
    if is_there("Random, as published") {
        text += " `Random, as published` tries three yaws with three by three positions each and ends where none of these is valid for any \
                 item of the buffer; the published code tries four yaws, and takes the first item that has a valid one, at its least yaw and x.";
    }
    text
}

/// A table of the methods, and one of the differences to the last.
fn methods_part<'a>(lines: impl IntoIterator<Item = &'a Line>) -> String {
    let lines: Vec<&Line> = lines.into_iter().collect();
    let mut text = "\n| method | decision per item | items packed | voxel volume (cm³) | compactness by floor (%) | compactness by box (%) \
         | mesh volume (cm³) | mesh compactness by floor (%) | share of the search's compactness (%) | of its mesh volume (%) | fell out \
         | steps widened |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n"
        .to_owned();
    for line in &lines {
        let means = &line.means;
        let [decision, voxels, compactness, items] = match line.paper {
            None => [const { String::new() }; 4],
            Some([seconds, voxels, compactness, items]) => [
                format!(" [{seconds} s]"),
                format!(" [{voxels:.0}]"),
                format!(" [{compactness:.1}]"),
                format!(" [{items:.1}]"),
            ],
        };
        text += &format!(
            "| {} | {} ms{decision} | {}{items} | {}{voxels} | {}{compactness} | {} | {} | {} | {} | {} | {:.2} | {} |\n",
            line.method,
            means.decision_s.scaled(1e3).shown(3),
            means.items.shown(1),
            means.voxels_cm3.shown(0),
            means.floor_compactness_percent.shown(1),
            means.box_compactness_percent.shown(1),
            means.meshes_cm3.shown(0),
            means.mesh_floor_compactness_percent.shown(1),
            line.floor_compactness_ratio_percent.shown(1),
            line.mesh_volume_ratio_percent.shown(1),
            means.fallen_out.mean,
            means.widened(),
        );
    }
    text += "\nMeans of the differences to the search of all placements, on the same sequences:\n\n\
         | method | items packed | voxel volume (cm³) | compactness by floor (points) |\n|---|---|---|---|\n";
    for line in lines.iter().rev().skip(1).rev() {
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

fn scatter(lines: &[Line]) -> Scatter {
    let label = |line: &Line| match line.class {
        Some(class) => format!("{}, {class}", line.method),
        None => line.method.clone(),
    };
    let ours = lines.iter().map(|line| {
        let decision_ms = line.means.decision_s.scaled(1e3);
        let compactness = &line.means.floor_compactness_percent;
        point(&label(line), &decision_ms, compactness)
    });
    let paper = lines.iter().filter_map(|line| {
        let [seconds, _, compactness, _] = line.paper?;
        Some(PlotPoint {
            label: line.method.clone(),
            x: seconds * 1e3,
            y: compactness,
            ..PlotPoint::default()
        })
    });
    let series = |name: &str, reference, points: Vec<PlotPoint>| PointSeries {
        name: name.to_owned(),
        reference,
        points,
    };
    let all = [
        series("ppnpack", false, ours.collect()),
        series("paper", true, paper.collect()),
    ];
    Scatter {
        title: "Compactness against decision time".to_owned(),
        x_label: "Decision time per item (ms)".to_owned(),
        y_label: "Compactness by the floor (%)".to_owned(),
        series: all
            .into_iter()
            .filter(|series| !series.points.is_empty())
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_method_that_can_be_asked_for_is_a_row() {
        let rows: Vec<&str> = TABLE_1.iter().map(|row| row.key).collect();
        assert_eq!(METHODS.map(|(key, ..)| key).as_slice(), rows);
        for table in [&TABLE_1[..], &TABLE_2, &TABLE_4] {
            assert_eq!(table.last().map(|row| row.key), Some("sdfm"));
            assert!(table.iter().all(|row| rows.contains(&row.key)));
        }
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
