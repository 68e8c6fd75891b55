//! `ppnpack experiment table1`, `table2` and `table4`: heuristics and the network compared.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use ppnpack_catalogue::shape_class::{REGULAR_SHARE, ShapeClass};
use ppnpack_cli::failure::{Failure, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::{Conditions, GridOptions};
use ppnpack_packing::kernel::objective::{Heuristic, Order};
use ppnpack_packing::planning::method::ProposalSource;
use serde_json::{Value, json};

use crate::cases::{self, Case, SequenceOptions};
use crate::comparison::{Comparison, ComparisonOptions, GridOption};
use crate::results::with;
use crate::way::Way;

/// Common options of the tables.
#[derive(Debug, Args)]
struct TableOptions {
    /// The methods that pack, beside the search of all placements by SDFM, with which they are
    /// compared [default: all of the table]
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

    /// The grids over the reference container on which the bounded search packs the sequences, too
    #[arg(long, value_enum, value_name = "LIST", value_delimiter = ',')]
    grids: Vec<GridOption>,

    #[command(flatten)]
    table: TableOptions,
}

/// Packs random sequences of the catalogue's regular objects, and of its irregular ones, with the
/// network's proposals and searching all placements. The sets of objects that the paper compares
/// with hierarchical reinforcement learning on are not published: regular is here what fills at
/// least half of its bounding box.
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

/// Packs random sequences of unseen objects: at random, with the network's proposals, searching all
/// placements. Give a --catalogue that the network was not trained on.
#[derive(Debug, Args)]
pub(crate) struct Table4Arguments {
    #[command(flatten)]
    drawn: DrawnOptions<400, 80>,

    #[command(flatten)]
    table: TableOptions,
}

struct Row {
    /// Name in options.
    key: &'static str,
    name: &'static str,
    heuristic: Heuristic,
    order: Order,
    proposals: RowProposals,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum RowProposals {
    All,
    Network,
    Tries,
}

impl Row {
    const fn by(key: &'static str, name: &'static str, heuristic: Heuristic, order: Order) -> Self {
        Self {
            key,
            name,
            heuristic,
            order,
            proposals: RowProposals::All,
        }
    }

    const fn proposed(self, proposals: RowProposals) -> Self {
        Self { proposals, ..self }
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

/// Method that the others of a table are compared with.
const SEARCH: &str = "sdfm";

/// The methods of Table I of the paper. `random` is by the rule of its text, `random-published` by
/// that of its code as it is read here.
static ROWS: [Row; 8] = {
    use Heuristic::{Dbl, Hm, Random, Sdfm};
    use Order::{Balance, BboxVolume, Shuffled};
    [
        Row::by("random-published", "Random, as published", Random, Shuffled)
            .proposed(RowProposals::Tries),
        Row::by("random", "Random", Random, Shuffled),
        Row::by("dbl-bbox", "DBL (BBox)", Dbl, BboxVolume),
        Row::by("hm-bbox", "HM (BBox)", Hm, BboxVolume),
        Row::by("dbl-balance", "DBL (Balance)", Dbl, Balance),
        Row::by("hm-balance", "HM (Balance)", Hm, Balance),
        Row::by("ppn", "PPN-Pack", Sdfm, Balance).proposed(RowProposals::Network),
        Row::by(SEARCH, "SDFM", Sdfm, Balance),
    ]
};

const OF_TABLE_2: [&str; 2] = ["ppn", SEARCH];
const OF_TABLE_4: [&str; 4] = ["random-published", "random", "ppn", SEARCH];

fn methods() -> PossibleValuesParser {
    PossibleValuesParser::new(
        ROWS.iter()
            .map(|row| PossibleValue::new(row.key).help(row.name)),
    )
}

impl TableOptions {
    fn comparison<'a>(&'a self, backend: &'a dyn Backend) -> Outcome<Comparison<'a>> {
        let grid = self.grid.settings(Conditions::Reference);
        Comparison::new(&self.comparison, backend, grid)
    }

    /// Packs sequences by the chosen methods of a table whose network can be used; a line for each.
    fn lines(
        &self,
        name: &str,
        of_table: &[&str],
        comparison: &Comparison<'_>,
        cases: &[Case],
    ) -> Outcome<Vec<Value>> {
        let is_asked_for = |row: &&Row| {
            let methods = &self.methods;
            let is_chosen = methods.is_empty() || methods.iter().any(|key| key == row.key);
            of_table.contains(&row.key) && (is_chosen || row.key == SEARCH)
        };
        let rows = ROWS.iter().filter(is_asked_for);
        let ways = rows.filter_map(|row| Some((row.key, row.way(comparison)?)));
        let line = |(key, way): (&str, Way)| {
            let folder = comparison.pack(name, &way, cases)?;
            Ok(json!({ "key": key, "method": way.name, "folder": folder }))
        };
        ways.map(line).collect()
    }
}

pub(crate) fn table1(arguments: &Table1Arguments, backend: &dyn Backend) -> Outcome {
    let (table, sequences) = (&arguments.table, &arguments.sequences);
    let comparison = table.comparison(backend)?;
    let cases = sequences.read(&comparison.catalogue)?;
    let all: Vec<&str> = ROWS.iter().map(|row| row.key).collect();
    let lines = table.lines("table1", &all, &comparison, &cases)?;
    let bounded = |option: &GridOption| {
        let comparison = Comparison::new(&table.comparison, backend, option.settings())?;
        let cases = sequences.read(&comparison.catalogue)?;
        let [_, name] = option.names();
        let way = comparison.way(name.to_owned(), ProposalSource::Bounded);
        let folder = comparison.pack("table1", &way, &cases)?;
        Ok(json!({ "grid": name, "folder": folder }))
    };
    let bounded = arguments.grids.iter().map(bounded);
    let bounded: Vec<Value> = bounded.collect::<Outcome<_>>()?;
    let results = json!({ "lines": lines, "bounded": bounded });
    comparison.publish("table1", with(results, sequences.said()))
}

pub(crate) fn table2(arguments: &Table2Arguments, backend: &dyn Backend) -> Outcome {
    let (table, drawn) = (&arguments.table, &arguments.drawn);
    let comparison = table.comparison(backend)?;
    // What is wrong with either class is said before anything is packed.
    let of_class = |class: ShapeClass| {
        let (name, model) = match class {
            ShapeClass::Regular => ("regular", &arguments.regular_model),
            ShapeClass::Irregular => ("irregular", &arguments.irregular_model),
        };
        let of_class = comparison.of_class(class, model.as_deref())?;
        if of_class.catalogue.is_empty() {
            return Err(Failure::input(format_args!(
                "no object of the catalogue is {name}: choose another --catalogue"
            )));
        }
        Ok((name, of_class))
    };
    let of_classes = ShapeClass::ALL.into_iter().map(of_class);
    let of_classes: Vec<(&str, Comparison<'_>)> = of_classes.collect::<Outcome<_>>()?;
    let (mut lines, mut classes) = (Vec::new(), Vec::new());
    for (name, comparison) in &of_classes {
        let of_class = table.lines("table2", &OF_TABLE_2, comparison, &drawn.draw(comparison))?;
        lines.extend(
            of_class
                .into_iter()
                .map(|line| with(line, json!({ "class": name }))),
        );
        let objects = comparison.catalogue.objects.iter();
        let objects: Vec<&str> = objects.map(|it| it.model.name.as_str()).collect();
        classes.push(json!({ "name": name, "objects": objects }));
    }
    comparison.publish(
        "table2",
        json!({
            "first_case": drawn.first,
            "cases": drawn.cases,
            "regular_share": REGULAR_SHARE,
            "classes": classes,
            "lines": lines,
        }),
    )
}

pub(crate) fn table4(arguments: &Table4Arguments, backend: &dyn Backend) -> Outcome {
    let (table, drawn) = (&arguments.table, &arguments.drawn);
    let comparison = table.comparison(backend)?;
    let lines = table.lines("table4", &OF_TABLE_4, &comparison, &drawn.draw(&comparison))?;
    let results = json!({ "first_case": drawn.first, "cases": drawn.cases, "lines": lines });
    comparison.publish("table4", results)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_table_ends_with_the_search_and_its_methods_can_be_asked_for() {
        assert_eq!(ROWS.last().map(|row| row.key), Some(SEARCH));
        for key in OF_TABLE_2.iter().chain(&OF_TABLE_4) {
            assert!(ROWS.iter().any(|row| row.key == *key), "{key}");
        }
    }
}
