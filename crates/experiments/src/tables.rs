//! `ppnpack experiment table1`, `table2` and `table4`: packing heuristics and the network compared over sequences.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use ppnpack_catalogue::shape_class::{REGULAR_SHARE, ShapeClass};
use ppnpack_cli::failure::{Failure, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::{Conditions, GridOptions};
use ppnpack_packing::method::ProposalSource;
use ppnpack_packing::objective::{Heuristic, Order};
use serde_json::json;

use crate::cases::{self, Case, SequenceOptions};
use crate::comparison::{Comparison, ComparisonOptions, GridOption, columns};
use crate::document::Page;
use crate::packer::Run;
use crate::sheet::{Column, Lines};
use crate::way::Way;

/// A column of this experiment's tables.
type Measured = Column<Run>;

/// What the tables are told alike.
#[derive(Debug, Args)]
struct TableOptions {
    /// The methods that pack, beside the search of all placements by SDFM, with which they are compared [default: all of the table]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = methods())]
    methods: Vec<String>,

    #[command(flatten)]
    grid: GridOptions,

    #[command(flatten)]
    comparison: ComparisonOptions,
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
        cases::draw(comparison.options.seed, numbers, self.length, objects)
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

/// A row of one of the paper's tables.
struct Row {
    /// What it is asked for by.
    key: &'static str,
    name: &'static str,
    heuristic: Heuristic,
    order: Order,
    proposals: RowProposals,
    /// What the paper reports: seconds, cm³, percent, items.
    paper: Option<[f64; 4]>,
}

/// Where the proposals of a row come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum RowProposals {
    /// All placements are searched.
    All,
    /// The network proposes.
    Network,
    /// A few are tried.
    Tries,
}

const SDFM: Row = Row {
    key: "sdfm",
    name: "SDFM",
    heuristic: Heuristic::Sdfm,
    order: Order::Balance,
    proposals: RowProposals::All,
    paper: None,
};

/// By the rule of the paper's text.
const RANDOM: Row = Row {
    key: "random",
    name: "Random",
    heuristic: Heuristic::Random,
    order: Order::Shuffled,
    ..SDFM
};

/// The paper's baseline, by the rule of its code as it is read here.
const TRIES: Row = Row {
    key: "random-published",
    name: "Random, as published",
    proposals: RowProposals::Tries,
    ..RANDOM
};

const NETWORK: Row = Row {
    key: "ppn",
    name: "PPN-Pack",
    proposals: RowProposals::Network,
    ..SDFM
};

const SEARCH_ALL: Row = Row {
    name: "Search all",
    ..SDFM
};

impl Row {
    const fn by(key: &'static str, name: &'static str, heuristic: Heuristic, order: Order) -> Self {
        Self {
            key,
            name,
            heuristic,
            order,
            ..SDFM
        }
    }

    const fn paper(self, figures: [f64; 4]) -> Self {
        Self {
            paper: Some(figures),
            ..self
        }
    }

    fn way(&self, comparison: &Comparison<'_>) -> Option<Way> {
        let name = self.name.to_owned();
        let (name, proposals) = match self.proposals {
            RowProposals::All => (name, ProposalSource::All),
            RowProposals::Tries => (name, ProposalSource::PUBLISHED_TRIES),
            RowProposals::Network => {
                let percent = comparison.options.network.percent();
                let proposals = comparison.proposals(percent)?;
                (format!("{name} (K = {percent} %)"), proposals)
            }
        };
        let mut way = comparison.way(name, proposals);
        (way.method.heuristic, way.method.order) = (self.heuristic, self.order);
        Some(way)
    }
}

/// Table I of the paper: 2,000 sequences.
static TABLE_1: [Row; 8] = {
    use Heuristic::{Dbl, Hm};
    use Order::{Balance, BboxVolume};
    const RANDOMS: [f64; 4] = [0.05, 10_905.0, 39.9, 27.54];
    [
        TRIES.paper(RANDOMS),
        RANDOM.paper(RANDOMS),
        Row::by("dbl-bbox", "DBL (BBox)", Dbl, BboxVolume).paper([0.82, 15_073.0, 50.2, 37.17]),
        Row::by("hm-bbox", "HM (BBox)", Hm, BboxVolume).paper([0.83, 15_496.0, 51.7, 38.60]),
        Row::by("dbl-balance", "DBL (Balance)", Dbl, Balance).paper([1.90, 15_117.0, 50.3, 36.21]),
        Row::by("hm-balance", "HM (Balance)", Hm, Balance).paper([1.64, 14_094.0, 49.2, 38.43]),
        NETWORK.paper([0.43, 16_525.0, 55.9, 39.88]),
        SDFM.paper([1.86, 16_897.0, 56.8, 40.77]),
    ]
};

/// Table II of the paper is of other objects, and told apart: [`paper_of_table_2`].
static TABLE_2: [Row; 2] = [NETWORK, SEARCH_ALL];

/// Table IV of the paper: 400 cases of its 28 unseen objects.
static TABLE_4: [Row; 4] = {
    const RANDOMS: [f64; 4] = [0.37, 19_029.0, 39.5, 27.54];
    [
        TRIES.paper(RANDOMS),
        RANDOM.paper(RANDOMS),
        NETWORK.paper([0.45, 22_993.0, 47.3, 33.69]),
        SEARCH_ALL.paper([1.58, 25_001.0, 49.8, 34.26]),
    ]
};

/// The methods as they are asked for.
fn methods() -> PossibleValuesParser {
    let rows = TABLE_1.iter();
    PossibleValuesParser::new(rows.map(|row| PossibleValue::new(row.key).help(row.name)))
}

impl TableOptions {
    /// The comparison in the paper's conditions.
    fn comparison<'a>(&'a self, backend: &'a dyn Backend) -> Outcome<Comparison<'a>> {
        let grid = self.grid.settings(Conditions::Reference);
        Comparison::new(&self.comparison, backend, grid)
    }

    /// Those rows of a table that are asked for and whose network can be used, and their methods.
    fn ways(
        &self,
        rows: &'static [Row],
        comparison: &Comparison<'_>,
    ) -> (Vec<&'static Row>, Vec<Way>) {
        let is_asked_for = |row: &&Row| {
            let methods = &self.methods;
            methods.is_empty() || methods.iter().any(|key| key == row.key) || row.key == SDFM.key
        };
        let rows = rows.iter().filter(is_asked_for);
        rows.filter_map(|row| Some((row, row.way(comparison)?)))
            .unzip()
    }

    /// A table's rows on these sequences, and their part of the document.
    fn lines(
        &self,
        name: &str,
        rows: &'static [Row],
        comparison: &Comparison<'_>,
        cases: &[Case],
    ) -> Outcome<(Lines<Run>, String)> {
        let (rows, ways) = self.ways(rows, comparison);
        let packed = comparison.pack(name, &ways, cases)?;
        let search = packed.last().map(|(_, runs)| runs.clone());
        let mut lines = Lines::compared_with(search.unwrap_or_default(), "method", packed);
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
}

pub(crate) fn table1(arguments: &Table1Arguments, backend: &dyn Backend) -> Outcome {
    let (table, sequences) = (&arguments.table, &arguments.sequences);
    let comparison = table.comparison(backend)?;
    let cases = sequences.read(&comparison.catalogue)?;
    let (lines, text) = table.lines("table1", &TABLE_1, &comparison, &cases)?;
    let head = format!(
        "# Table 1: packing heuristics\n\nSequences {} to {}. In italics the paper's figures, of 2,000 sequences, its own meshes and \
         machine. {RANDOM_ROWS}",
        sequences.first,
        sequences.last()
    );
    let mut page = comparison.page("table1", &head);
    page.say(&text);
    if !arguments.grids.is_empty() {
        bounded(arguments, backend, lines.compared(), &mut page)?;
    }
    page.keep("lines", lines);
    page.publish(&table.comparison.runs.out)
}

/// Adds the bounded search on other grids, against the search of all placements on the table's.
fn bounded(
    arguments: &Table1Arguments,
    backend: &dyn Backend,
    search: &[Run],
    page: &mut Page,
) -> Outcome {
    let on_grid = |option: &GridOption| {
        let options = &arguments.table.comparison;
        let comparison = Comparison::new(options, backend, option.settings())?;
        let cases = arguments.sequences.read(&comparison.catalogue)?;
        let [_, name] = option.names();
        let way = comparison.way(name.to_owned(), ProposalSource::Bounded);
        comparison.pack("table1", &[way], &cases)
    };
    let runs = arguments.grids.iter().map(on_grid);
    let runs: Vec<_> = runs.collect::<Outcome<_>>()?;
    let mut lines = Lines::compared_with(search.to_vec(), "grid", runs.concat());
    page.say(&format!(
        "\n## The bounded search on other grids\n\nSDFM (Balance) on the same sequences; it chooses what the search of all \
         placements chooses. Voxels inflate items, less on finer grids: only items and the volume of the meshes compare across grids. Shares and \
         differences are to that search on the grid above.\n\n{}\n{}",
        lines.table("grid", &columns(false)),
        lines.table("grid", &differences()),
    ));
    page.keep("bounded", lines);
    Ok(())
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
    let head = format!(
        "# Table 2: easy and hard shapes\n\n{} random sequences of each class. Regular is what fills at least {:.0} % of its bounding box; \
         all other objects are irregular. The paper's objects are not published: its rows are of other objects, and say nothing about ours.",
        arguments.drawn.cases,
        100.0 * REGULAR_SHARE
    );
    let mut page = comparison.page("table2", &head);
    let mut lines = Lines::new("method", Vec::new());
    let mut classes = Vec::new();
    for (class, comparison) in &of_classes {
        let (name, cases) = (name_of(*class), arguments.drawn.draw(comparison));
        let (mut of_class, part) = table.lines("table2", &TABLE_2, comparison, &cases)?;
        of_class.keep("class", std::iter::repeat(name));
        lines.append(of_class);
        let objects = &comparison.catalogue.objects;
        let names: Vec<&str> = objects.iter().map(|it| it.model.name.as_str()).collect();
        page.say(&format!(
            "\n## {} {name} objects\n{part}\n| the paper, on its own objects | decision per item | items packed | voxel volume (cm³) | \
             compactness (%) |\n|---|---|---|---|---|\n",
            names.len()
        ));
        for (method, figures) in paper_of_table_2(*class) {
            page.say(&published(method, figures));
        }
        classes.push(json!({ "name": name, "objects": names }));
    }
    page.keep("classes", classes);
    page.keep("lines", lines);
    page.publish(&table.comparison.runs.out)
}

pub(crate) fn table4(arguments: &Table4Arguments, backend: &dyn Backend) -> Outcome {
    let table = &arguments.table;
    let comparison = table.comparison(backend)?;
    let cases = arguments.drawn.draw(&comparison);
    let (lines, text) = table.lines("table4", &TABLE_4, &comparison, &cases)?;
    let head = format!(
        "# Table 4: objects that the network was not trained on\n\n{} random sequences of {} objects, seed {}. In italics the paper's \
         figures, of 400 sequences of its 28 objects: its volumes need a container of some 48 litres, so that of these only shares compare. \
         {RANDOM_ROWS}",
        arguments.drawn.cases,
        comparison.catalogue.len(),
        table.comparison.seed
    );
    let mut page = comparison.page("table4", &head);
    page.say(&text);
    page.keep("lines", lines);
    page.publish(&table.comparison.runs.out)
}

fn name_of(class: ShapeClass) -> &'static str {
    match class {
        ShapeClass::Regular => "regular",
        ShapeClass::Irregular => "irregular",
    }
}

/// Table II of the paper, 50 easy and 50 hard objects a sequence: seconds, no volume, percent, items.
fn paper_of_table_2(class: ShapeClass) -> [(&'static str, [f64; 4]); 2] {
    let [
        [learned_s, learned, learned_items],
        [ours_s, ours, our_items],
    ] = match class {
        ShapeClass::Regular => [[0.97, 45.6, 40.38], [0.87, 47.9, 44.16]],
        ShapeClass::Irregular => [[0.97, 42.3, 37.28], [0.93, 42.4, 45.61]],
    };
    [
        (
            "hierarchical reinforcement learning",
            [learned_s, f64::NAN, learned, learned_items],
        ),
        ("PPN-Pack", [ours_s, f64::NAN, ours, our_items]),
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
    buffer; the published code tries four yaws, and takes the first item that has a valid one, at its least yaw and x. The network is this \
    project's.";

/// By how much a method packs more than the search of all placements.
fn differences() -> Vec<Measured> {
    vec![
        Measured::difference("difference/items", "items packed", 1, |run: &Run| {
            run.items as f64
        }),
        Measured::difference("difference/voxels_cm3", "voxel volume (cm³)", 0, |run| {
            run.voxels_m3 * 1e6
        }),
        Measured::difference(
            "difference/meshes_cm3",
            "mesh volume (cm³)",
            0,
            Run::meshes_cm3,
        ),
        Measured::difference(
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
    fn each_table_ends_with_the_search_and_its_methods_can_be_asked_for() {
        for table in [&TABLE_1[..], &TABLE_2, &TABLE_4] {
            assert_eq!(table.last().map(|row| row.key), Some(SDFM.key));
            for row in table {
                assert!(TABLE_1.iter().any(|known| known.key == row.key));
            }
        }
    }
}
