//! `ppnpack experiment table2`: easy and hard shapes.

use std::path::PathBuf;

use clap::Args;
use ppnpack_catalogue::shape_class::{REGULAR_SHARE, ShapeClass};
use ppnpack_cli::failure::{Failure, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_packing::objective::{Heuristic, Order};
use serde::Serialize;

use crate::cases;
use crate::comparison::{
    COMPACTNESS, Comparison, Means, Results, Row, RowProposals, Run, SHARE, WIDENED, ratio_percent,
};
use crate::document::{self, Answer, Document};
use crate::runs::{Part, ShardOptions};
use crate::statistics::Mean;
use crate::table::{Published, TableOptions};

/// Packs random sequences of the catalogue's regular objects, and of its irregular ones, with the network's proposals and
/// searching all placements. The sets of objects that the paper compares with hierarchical reinforcement learning on are not
/// published: regular is here what fills at least half of its bounding box.
#[derive(Debug, Args)]
pub(crate) struct Table2Arguments {
    /// How many sequences of each class; the paper packs 2,000
    #[arg(long, value_name = "COUNT", default_value_t = 100, value_parser = clap::value_parser!(u32).range(2..))]
    cases: u32,

    /// Objects in a sequence
    #[arg(long, value_name = "COUNT", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..))]
    length: u32,

    /// The weights of a network trained on the regular objects alone [default: those of --model]
    #[arg(long, value_name = "FILE")]
    regular_model: Option<PathBuf>,

    /// The weights of a network trained on the irregular objects alone [default: those of --model]
    #[arg(long, value_name = "FILE")]
    irregular_model: Option<PathBuf>,

    /// Where report.html, table2.md and table2.json are written
    #[arg(long, value_name = "DIR", default_value = "out/table2")]
    out: PathBuf,

    #[command(flatten)]
    runs: ShardOptions,

    #[command(flatten)]
    table: TableOptions,
}

/// The two methods of the paper's Table II on one of its sets, which are of other objects.
#[derive(Debug, Clone, Copy, Serialize)]
struct PaperRows {
    hierarchical_learning: Published,
    ppn_pack: Published,
}

/// What the paper reports is of other objects, and is told apart: [`published`].
const ROWS: [Row<()>; 2] = {
    use Heuristic::Sdfm;
    use Order::Balance;
    [
        Row {
            proposals: RowProposals::Network,
            ..Row::all("PPN-Pack", Sdfm, Balance, ())
        },
        Row::all("Search all", Sdfm, Balance, ()),
    ]
};

/// One class of objects.
#[derive(Debug, Serialize)]
struct Class {
    name: &'static str,
    objects: Vec<String>,
    lines: Vec<Line>,
    paper: PaperRows,
}

#[derive(Debug, Serialize)]
struct Line {
    method: String,
    #[serde(flatten)]
    means: Means,
    /// Of the exhaustive search's, on the same sequences.
    floor_compactness_ratio_percent: Mean,
}

pub(crate) fn run(arguments: &Table2Arguments, backend: &dyn Backend) -> Outcome {
    let comparison = arguments.table.comparison(backend)?;
    let part = arguments.runs.part(&arguments.out);
    // What is wrong with either class is said before anything is packed.
    let mut of_classes = Vec::new();
    for class in ShapeClass::ALL {
        of_classes.push((class, of_class(class, arguments, &comparison)?));
    }
    let mut classes = Vec::new();
    for (class, comparison) in &of_classes {
        classes.extend(pack(*class, arguments, &part, comparison)?);
    }
    if classes.is_empty() {
        return part.tell(arguments.table.json);
    }
    let results = comparison.results(None, classes);
    draw(arguments, &results)?;
    let document = Document {
        name: "table2",
        answer: Answer {
            question: "Are regular or irregular objects packed better?",
            text: answer(&results),
            picture: "table2.svg".to_owned(),
        },
        results: &results,
        asked: arguments,
        measured: &["lines"],
        markdown: markdown(&results),
    };
    document.publish(&arguments.out, arguments.table.json)
}

fn draw(arguments: &Table2Arguments, results: &Results<'_, Class>) -> Outcome {
    let lines = results.lines.iter().flat_map(|class| {
        class.lines.iter().map(move |line| {
            let label = format!("{}, {}", class.name, line.method);
            (label, line.means.floor_compactness_percent.mean)
        })
    });
    let titles = [
        "Regular and irregular objects",
        "Compactness by the floor (%)",
    ];
    document::bars(&arguments.out, "table2", titles, lines)
}

/// How compactly each class is packed by the search of all placements, and what the network makes of that.
fn answer(results: &Results<'_, Class>) -> String {
    let of_class = |class: &Class| {
        let (search, others) = class.lines.split_last()?;
        let network = others.first().map_or_else(String::new, |line| {
            let ratio = line.floor_compactness_ratio_percent.shown(1);
            format!("; {} reaches {ratio} % of that", line.method)
        });
        Some(format!(
            "On {} objects the search of all placements reaches a compactness of {} % by the floor{network}.",
            class.name,
            search.means.floor_compactness_percent.shown(1)
        ))
    };
    let classes = results.lines.iter().filter_map(of_class);
    classes.collect::<Vec<String>>().join(" ")
}

/// The comparison on the objects of one class, with its network.
fn of_class<'a>(
    class: ShapeClass,
    arguments: &Table2Arguments,
    comparison: &Comparison<'a>,
) -> Outcome<Comparison<'a>> {
    let model = match class {
        ShapeClass::Regular => &arguments.regular_model,
        ShapeClass::Irregular => &arguments.irregular_model,
    };
    let comparison = comparison.of_class(class, model.as_deref())?;
    if comparison.catalogue.is_empty() {
        return Err(Failure::input(format_args!(
            "no object of the catalogue is {}: choose another --catalogue",
            name(class)
        )));
    }
    Ok(comparison)
}

fn name(class: ShapeClass) -> &'static str {
    match class {
        ShapeClass::Regular => "regular",
        ShapeClass::Irregular => "irregular",
    }
}

/// Packs the sequences of one class; `None` where only a shard of them is made here.
fn pack(
    class: ShapeClass,
    arguments: &Table2Arguments,
    part: &Part,
    comparison: &Comparison<'_>,
) -> Outcome<Option<Class>> {
    let objects = comparison.catalogue.objects.iter();
    let objects: Vec<String> = objects.map(|object| object.model.name.clone()).collect();
    let seed = comparison.setting.seed;
    let sequences = cases::draw(seed, arguments.cases, arguments.length, objects.len());
    let (_, contenders) = comparison.contenders(&ROWS);
    let Some(packed) = comparison.pack(&contenders, &sequences, part)? else {
        return Ok(None);
    };
    let all = packed.last().map_or(&[][..], |runs| runs);
    let methods = contenders.into_iter().zip(&packed);
    Ok(Some(Class {
        name: name(class),
        objects,
        lines: methods
            .map(|(contender, runs)| line(contender.name, runs, all))
            .collect(),
        paper: published(class),
    }))
}

fn line(method: String, runs: &[Run], all: &[Run]) -> Line {
    Line {
        method,
        means: Means::of(runs),
        floor_compactness_ratio_percent: ratio_percent(runs, all, |run| run.floor_compactness),
    }
}

/// Table II of the paper: 50 easy, and 50 hard objects a sequence.
fn published(class: ShapeClass) -> PaperRows {
    let row = |decision_s, compactness_percent, items| Published {
        decision_s: Some(decision_s),
        voxels_cm3: None,
        compactness_percent,
        items,
    };
    match class {
        ShapeClass::Regular => PaperRows {
            hierarchical_learning: row(0.97, 45.6, 40.38),
            ppn_pack: row(0.87, 47.9, 44.16),
        },
        ShapeClass::Irregular => PaperRows {
            hierarchical_learning: row(0.97, 42.3, 37.28),
            ppn_pack: row(0.93, 42.4, 45.61),
        },
    }
}

fn markdown(results: &Results<'_, Class>) -> String {
    let settings = results.settings;
    let mut text = format!(
        "# Table 2: easy and hard shapes\n\n\
         {}, {}. Regular is what fills at least {:.0} % of its bounding box; all other objects are irregular. The paper's objects are \
         not published: its rows are of other objects, marked so, and say nothing about ours. {COMPACTNESS} {SHARE} {WIDENED}\n",
        settings.cells_in_words(),
        settings.in_words(results.workers),
        100.0 * REGULAR_SHARE,
    );
    for class in &results.lines {
        text += &section(class);
    }
    text + &results.missing()
}

fn section(class: &Class) -> String {
    let Class { name, paper, .. } = class;
    let cases = class.lines.first().map_or(0, |line| line.means.cases);
    let mut text = format!(
        "\n## {} {name} objects, {cases} sequences\n\n\
         | method | decision per item | compactness by floor (%) | compactness by box (%) | share of the search's by floor (%) | items packed | steps widened |\n|---|---|---|---|---|---|---|\n",
        class.objects.len(),
    );
    for line in &class.lines {
        text += &format!(
            "| {} | {} ms | {} | {} | {} | {} | {} |\n",
            line.method,
            line.means.decision_s.scaled(1e3).shown(3),
            line.means.floor_compactness_percent.shown(1),
            line.means.box_compactness_percent.shown(1),
            line.floor_compactness_ratio_percent.shown(1),
            line.means.items.shown(1),
            line.means.widened(),
        );
    }
    let theirs = [
        (
            "hierarchical reinforcement learning",
            paper.hierarchical_learning,
        ),
        ("PPN-Pack", paper.ppn_pack),
    ];
    for (method, published) in theirs {
        text += &format!(
            "| *{method}, the paper on its own objects* | {} s | {:.1} | | | {:.2} | |\n",
            published.decision_s.unwrap_or_default(),
            published.compactness_percent,
            published.items
        );
    }
    text
}
