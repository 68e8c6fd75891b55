//! `ppnpack experiment table1`, `table2` and `table4`: packing heuristics and the network compared over sequences.

use std::path::PathBuf;

use clap::Args;
use ppnpack_catalogue::shape_class::{REGULAR_SHARE, ShapeClass};
use ppnpack_cli::failure::{Failure, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::{Choice, Conditions, GridOptions, one_of};
use ppnpack_packing::method::ProposalSource;
use ppnpack_packing::objective::{Heuristic, Order};
use serde::Serialize;

use crate::cases::{self, Case, SequenceOptions};
use crate::comparison::{
    COMPACTNESS, Comparison, ComparisonOptions, Contender, Measured, Row, RowProposals, Run, SHARE,
    Setting, WIDENED, columns,
};
use crate::document::{self, OutOptions};
use crate::pareto::GridOption;
use crate::sheet::{Lines, scatter};

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

/// Table II of the paper is of other objects, and told apart: [`paper_of_table_2`].
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
    lines: Lines<Run>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bounded: Option<Lines<Run>>,
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

    /// A table's rows on these sequences, with what their names end with, and their part of the document.
    fn lines(
        &self,
        name: &str,
        rows: &'static [Row],
        comparison: &Comparison<'_>,
        class: &str,
        cases: &[Case],
    ) -> Outcome<(Lines<Run>, String)> {
        let (rows, contenders) = self.contenders(rows, comparison);
        let kept = self.comparison.runs.folder(&self.out, name);
        let packed = comparison.pack(&contenders, cases, &kept)?;
        let search = packed.last().cloned().unwrap_or_default();
        let names = contenders
            .into_iter()
            .map(|contender| contender.name + class);
        let mut lines = Lines::compared_with(search, "method", names.zip(packed).collect());
        lines.keep("paper", rows.iter().map(|row| row.paper));
        let mut text = format!("\n{}", lines.table("method", &columns(false)));
        for row in rows {
            if let Some(paper) = row.paper {
                text += &published(&format!("{}, the paper", row.name), paper);
            }
        }
        text += &format!(
            "\nMeans of the differences to the search of all placements, on the same sequences:\n\n{}",
            lines.table("method", &differences())
        );
        Ok((lines, text))
    }

    fn results<'a>(&self, comparison: &'a Comparison<'_>, lines: Lines<Run>) -> Results<'a> {
        Results {
            settings: &comparison.setting,
            workers: self.comparison.runs.workers(),
            objects: comparison.catalogue.len(),
            classes: Vec::new(),
            without_network: comparison.without_network(),
            lines,
            bounded: None,
        }
    }

    /// The bounded search on other grids, against the search of all placements on the table's, and its part of the document.
    fn bounded(
        &self,
        arguments: &Table1Arguments,
        backend: &dyn Backend,
        search: &[Run],
    ) -> Outcome<(Lines<Run>, String)> {
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
            Ok((grid.to_owned(), runs))
        };
        let runs = arguments
            .grids
            .iter()
            .map(on_grid)
            .collect::<Outcome<_>>()?;
        let mut lines = Lines::compared_with(search.to_vec(), "grid", runs);
        let tables = [
            lines.table("grid", &columns(false)),
            lines.table("grid", &differences()),
        ];
        let text = format!(
            "\n## The bounded search on other grids\n\nSDFM (Balance) on the same sequences; it chooses what the search of all \
             placements chooses. Voxels inflate items, less on finer grids: only items and the volume of the meshes compare across grids. Shares and \
             differences are to that search on the grid above.\n\n{}",
            tables.join("\n")
        );
        Ok((lines, text))
    }

    /// Writes a table, its chart and its figures.
    fn publish(&self, name: &str, head: &str, results: &Results<'_>, parts: &str) -> Outcome {
        let settings = results.settings;
        let container = settings.grid.container();
        let [x_cm, y_cm, z_cm] =
            [container.x_m, container.y_m, container.z_m].map(|side_m| side_m * 100.0);
        let cells = settings.cells_in_words();
        let how = settings.in_words(results.workers);
        let text = format!(
            "{head} Container {x_cm:.0} x {y_cm:.0} x {z_cm:.0} cm, {cells}, {how}. {COMPACTNESS} {SHARE} {WIDENED} {RANDOM_ROWS} The network \
             is this project's.\n{parts}\n![Compactness against decision time]({name}.svg)\n"
        );
        let labels = [
            "Decision time per item (ms)",
            "Compactness by the floor (%)",
        ];
        let keys = ["decision_s", "floor_compactness_percent"];
        let lines = [("ppnpack", &results.lines)];
        let chart = scatter(
            "Compactness against decision time",
            labels,
            (keys, 1e3),
            lines,
        );
        document::figure(&self.out.folder(name), name, chart.to_svg([900, 600]))?;
        self.out.publish(name, results, &text)
    }
}

pub(crate) fn table1(arguments: &Table1Arguments, backend: &dyn Backend) -> Outcome {
    let table = &arguments.table;
    let comparison = table.comparison(backend)?;
    let cases = arguments.sequences.read(&comparison.catalogue)?;
    let (lines, mut text) = table.lines("table1", &TABLE_1, &comparison, "", &cases)?;
    text += &comparison.missing();
    let mut results = table.results(&comparison, lines);
    if !arguments.grids.is_empty() {
        let (bounded, part) = table.bounded(arguments, backend, results.lines.compared())?;
        text += &part;
        results.bounded = Some(bounded);
    }
    let head = format!(
        "# Table 1: packing heuristics\n\nSequences {} to {}. In italics the paper's figures, of 2,000 sequences, its own meshes and machine.",
        arguments.sequences.first,
        arguments.sequences.last()
    );
    table.publish("table1", &head, &results, &text)
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
    let mut lines = Lines::new("method", Vec::new());
    let (mut classes, mut text) = (Vec::new(), String::new());
    for (class, comparison) in &of_classes {
        let cases = arguments.drawn.draw(comparison);
        let name = name_of(*class);
        let suffix = format!(", {name}");
        let (mut of_class, part) = table.lines("table2", &TABLE_2, comparison, &suffix, &cases)?;
        of_class.keep("class", std::iter::repeat(name));
        lines.append(of_class);
        let objects = comparison.catalogue.objects.iter();
        let objects = objects.map(|object| object.model.name.clone()).collect();
        text += &format!("\n## {} {name} objects\n{part}", comparison.catalogue.len());
        text += "\n| the paper, on its own objects | decision per item | items packed | voxel volume (cm³) | compactness (%) |\n|---|---|---|---|---|\n";
        for (method, figures) in paper_of_table_2(*class) {
            text += &published(method, figures);
        }
        classes.push(Class { name, objects });
    }
    text += &comparison.missing();
    let results = Results {
        classes,
        ..table.results(&comparison, lines)
    };
    let head = format!(
        "# Table 2: easy and hard shapes\n\n{} random sequences of each class. Regular is what fills at least {:.0} % of its bounding box; \
         all other objects are irregular. The paper's objects are not published: its rows are of other objects, and say nothing about ours.",
        arguments.drawn.cases,
        100.0 * REGULAR_SHARE
    );
    table.publish("table2", &head, &results, &text)
}

pub(crate) fn table4(arguments: &Table4Arguments, backend: &dyn Backend) -> Outcome {
    let table = &arguments.table;
    let comparison = table.comparison(backend)?;
    let cases = arguments.drawn.draw(&comparison);
    let (lines, text) = table.lines("table4", &TABLE_4, &comparison, "", &cases)?;
    let results = table.results(&comparison, lines);
    let head = format!(
        "# Table 4: objects that the network was not trained on\n\n{} random sequences of {} objects, seed {}. In italics the paper's \
         figures, of 400 sequences of its 28 objects: its volumes need a container of some 48 litres, so that of these only shares compare.",
        arguments.drawn.cases, results.objects, results.settings.seed
    );
    table.publish("table4", &head, &results, &(text + &comparison.missing()))
}

fn name_of(class: ShapeClass) -> &'static str {
    match class {
        ShapeClass::Regular => "regular",
        ShapeClass::Irregular => "irregular",
    }
}

/// Table II of the paper, 50 easy and 50 hard objects a sequence: seconds, no volume, percent, items.
fn paper_of_table_2(class: ShapeClass) -> [(&'static str, [f64; 4]); 2] {
    let [learned, network] = match class {
        ShapeClass::Regular => [[0.97, 45.6, 40.38], [0.87, 47.9, 44.16]],
        ShapeClass::Irregular => [[0.97, 42.3, 37.28], [0.93, 42.4, 45.61]],
    };
    let without_volume = |[seconds, percent, items]: [f64; 3]| [seconds, f64::NAN, percent, items];
    [
        (
            "hierarchical reinforcement learning",
            without_volume(learned),
        ),
        ("PPN-Pack", without_volume(network)),
    ]
}

/// The first cells of a row of the paper's figures: seconds, cm³, percent, items.
fn published(name: &str, [seconds, volume, compactness, items]: [f64; 4]) -> String {
    let volume = match volume.is_nan() {
        true => String::new(),
        false => format!("{volume:.0}"),
    };
    format!("| *{name}* | {seconds} s | {items:.1} | {volume} | {compactness:.1} |\n")
}

/// What the rows of random placements do.
const RANDOM_ROWS: &str = "`Random` places at any feasible placement, as the paper's text has it, and ends where there is none. \
    `Random, as published` tries three yaws with three by three positions each and ends where none of these is valid for any item of the \
    buffer; the published code tries four yaws, and takes the first item that has a valid one, at its least yaw and x.";

/// By how much a method packs more than the search of all placements.
fn differences() -> [Measured<'static>; 4] {
    let of = |key, head, decimals, value: fn(&Run) -> f64| {
        Measured::difference(key, head, decimals, value)
    };
    [
        of("difference/items", "items packed", 1, |run| {
            run.items as f64
        }),
        of("difference/voxels_cm3", "voxel volume (cm³)", 0, |run| {
            run.voxels_m3 * 1e6
        }),
        of("difference/meshes_cm3", "mesh volume (cm³)", 0, |run| {
            run.meshes_m3 * 1e6
        }),
        of(
            "difference/floor_compactness_percent",
            "compactness by floor (points)",
            1,
            |run| run.floor_compactness * 100.0,
        ),
    ]
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
}
