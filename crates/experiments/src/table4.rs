//! `ppnpack experiment table4`: objects that the network was not trained on.

use std::path::PathBuf;

use clap::Args;
use ppnpack_chart::{Bar, Bars};
use ppnpack_cli::failure::Outcome;
use ppnpack_cli::network::Backend;
use ppnpack_packing::objective::{Heuristic, Order};
use serde::Serialize;

use crate::cases;
use crate::comparison::{
    COMPACTNESS, Means, Results, Row, RowProposals, SHARE, WIDENED, ratio_percent,
};
use crate::document::{self, Answer, Document};
use crate::runs::ShardOptions;
use crate::statistics::Mean;
use crate::table::TableOptions;
use crate::table1;

/// Packs random sequences of unseen objects: at random, with the network's proposals, searching all placements. Give a
/// --catalogue that the network was not trained on.
#[derive(Debug, Args)]
pub(crate) struct Table4Arguments {
    /// How many sequences
    #[arg(long, value_name = "COUNT", default_value_t = 400, value_parser = clap::value_parser!(u32).range(2..))]
    cases: u32,

    /// Objects in a sequence
    #[arg(long, value_name = "COUNT", default_value_t = 80, value_parser = clap::value_parser!(u32).range(1..))]
    length: u32,

    /// Where report.html, table4.md, table4.json and table4.svg are written
    #[arg(long, value_name = "DIR", default_value = "out/table4")]
    out: PathBuf,

    #[command(flatten)]
    runs: ShardOptions,

    #[command(flatten)]
    table: TableOptions,
}

/// Results of the paper on its 28 unseen objects: 400 cases.
const ROWS: [Row; 4] = {
    use Heuristic::{Random, Sdfm};
    use Order::{Balance, Shuffled};
    [
        Row {
            proposals: RowProposals::Tries,
            ..Row::all(
                "Random, as published",
                Random,
                Shuffled,
                [0.37, 19_029.0, 39.5, 27.54],
            )
        },
        Row::all("Random", Random, Shuffled, [0.37, 19_029.0, 39.5, 27.54]),
        Row {
            proposals: RowProposals::Network,
            ..Row::all("PPN-Pack", Sdfm, Balance, [0.45, 22_993.0, 47.3, 33.69])
        },
        Row::all("Search all", Sdfm, Balance, [1.58, 25_001.0, 49.8, 34.26]),
    ]
};

#[derive(Debug, Serialize)]
struct Line {
    method: String,
    #[serde(flatten)]
    means: Means,
    /// Of the exhaustive search's, on the same sequences.
    floor_compactness_ratio_percent: Mean,
    mesh_volume_ratio_percent: Mean,
    /// Seconds, cm³, percent, items.
    paper: [f64; 4],
}

pub(crate) fn run(arguments: &Table4Arguments, backend: &dyn Backend) -> Outcome {
    let comparison = arguments.table.comparison(backend)?;
    let objects = comparison.catalogue.len();
    let seed = comparison.setting.seed;
    let sequences = cases::draw(seed, arguments.cases, arguments.length, objects);
    let (rows, contenders) = comparison.contenders(&ROWS);
    let part = arguments.runs.part(&arguments.out);
    let Some(packed) = comparison.pack(&contenders, &sequences, &part)? else {
        return part.tell(arguments.table.json);
    };
    let all = packed.last().map_or(&[][..], |runs| runs);
    let methods = rows.into_iter().zip(contenders).zip(&packed);
    let lines = methods.map(|((row, contender), runs)| Line {
        method: contender.name,
        means: Means::of(runs),
        floor_compactness_ratio_percent: ratio_percent(runs, all, |run| run.floor_compactness),
        mesh_volume_ratio_percent: ratio_percent(runs, all, |run| run.meshes_m3),
        paper: row.paper,
    });
    let results = comparison.results(Some(objects), lines.collect());
    let folder = &arguments.out;
    let bars = results.lines.iter().map(|line| Bar {
        label: line.method.clone(),
        value: line.means.floor_compactness_percent.mean,
    });
    let chart = Bars {
        title: "Compactness on unseen objects".to_owned(),
        value_label: "Compactness by the floor (%)".to_owned(),
        bars: bars.collect(),
    };
    document::figure(folder, "table4", chart.to_svg([700, 460]))?;
    let document = Document {
        name: "table4",
        answer: Answer {
            question: "How are objects packed that the network was not trained on?",
            text: answer(&results),
            picture: "table4.svg".to_owned(),
        },
        results: &results,
        asked: arguments,
        measured: &["lines"],
        markdown: markdown(&results),
    };
    document.publish(folder, arguments.table.json)
}

/// How compactly the search of all placements packs, and which other method comes nearest.
fn answer(results: &Results<'_, Line>) -> String {
    let Some((search, others)) = results.lines.split_last() else {
        return "Nothing was packed.".to_owned();
    };
    let ratio = |line: &&Line| line.floor_compactness_ratio_percent.mean;
    let nearest = others
        .iter()
        .max_by(|one, other| ratio(one).total_cmp(&ratio(other)));
    let nearest = nearest.map_or_else(String::new, |line| {
        format!(
            " {} reaches {} % of that in {} % of the time.",
            line.method,
            line.floor_compactness_ratio_percent.shown(1),
            share_of_time(line, search)
        )
    });
    format!(
        "The search of all placements reaches a compactness of {} % by the floor, over {} sequences.{nearest}",
        search.means.floor_compactness_percent.shown(1),
        search.means.cases
    )
}

/// How long a decision takes, of what it takes the search, in percent.
fn share_of_time(line: &Line, search: &Line) -> String {
    let [own_s, search_s] = [line, search].map(|line| line.means.decision_s.mean);
    format!("{:.0}", 100.0 * own_s / search_s)
}

fn markdown(results: &Results<'_, Line>) -> String {
    let settings = results.settings;
    let cases = results.lines.first().map_or(0, |line| line.means.cases);
    let objects = results.objects.unwrap_or_default();
    let mut text = format!(
        "# Table 4: objects that the network was not trained on\n\n\
         {cases} random sequences of {objects} objects, seed {}; {}, {}; shares are of what the exhaustive search packs on \
         the same sequences. The paper's figures (400 sequences of its 28 objects, its own meshes and machine) are in brackets. {COMPACTNESS} {SHARE} {WIDENED}{}\n\n\
         | method | decision per item | items packed | voxel volume (cm³) | compactness by floor (%) | compactness by box (%) \
         | share of compactness by floor (%) | share of mesh volume (%) | steps widened |\n|---|---|---|---|---|---|---|---|---|\n",
        settings.seed,
        settings.cells_in_words(),
        settings.in_words(results.workers),
        table1::random_rows(results.lines.iter().map(|line| line.method.as_str())),
    );
    for line in &results.lines {
        let Line { means, .. } = line;
        let [seconds, volume, compactness, items] = line.paper;
        text += &format!(
            "| {} | {} ms [{seconds} s] | {} [{items:.1}] | {} [{volume:.0}] | {} [{compactness:.1}] | {} | {} | {} | {} |\n",
            line.method,
            means.decision_s.scaled(1e3).shown(3),
            means.items.shown(1),
            means.voxels_cm3.shown(0),
            means.floor_compactness_percent.shown(1),
            means.box_compactness_percent.shown(1),
            line.floor_compactness_ratio_percent.shown(1),
            line.mesh_volume_ratio_percent.shown(1),
            means.widened(),
        );
    }
    text += &results.missing();
    text += "\n![Compactness](table4.svg)\n";
    text
}
