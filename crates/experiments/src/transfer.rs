//! `ppnpack experiment transfer`: how often the optimum is among the network's proposals away from the grid that it
//! was trained on.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use ppnpack_chart::Lines;
use ppnpack_model::weights::Model;
use ppnpack_packing::coarse::Coarsening;
use ppnpack_packing::episode::{IdealCell, Observer, Play, Step, play};
use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::item::Item;
use ppnpack_packing::method::{Method, ProposalSource, Stability};
use ppnpack_packing::plan::{Candidate, Planner};
use ppnpack_packing::step::StepInput;
use serde::{Deserialize, Serialize};

use crate::document;
use crate::network::NetworkOptions;
use crate::runs::Runs;
use crate::shares::{self, SHARES};
use crate::statistics::Mean;
use crate::workers;
use ppnpack_cli::failure::{Failure, OrInput, OrRun, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::{CatalogueOptions, Network};
use ppnpack_cli::sequence::SequenceFile;
use ppnpack_files::write_whole;

/// Measures on several containers, cells and yaws how often the optimum is among the network's proposals, without
/// training it anew.
#[derive(Debug, Args)]
pub(crate) struct TransferArguments {
    #[command(flatten)]
    catalogue: CatalogueOptions,

    /// A .npy file of sequences, int64 [sequences, length], of object indices
    #[arg(long, value_name = "FILE")]
    sequences: PathBuf,

    /// How many sequences, from the first
    #[arg(long, value_name = "COUNT", default_value_t = 10, value_parser = clap::value_parser!(u32).range(2..))]
    cases: u32,

    #[command(flatten)]
    network: NetworkOptions,

    /// Where transfer.md, transfer.json and the figure are written; a killed run goes on there
    #[arg(long, value_name = "DIR", default_value = "out/transfer")]
    out: PathBuf,

    /// Print the results as JSON instead of a table
    #[arg(long)]
    json: bool,
}

const BUFFER: usize = 5;

/// A grid that the network scores placements on.
struct Case {
    name: &'static str,
    container: ContainerSize,
    cell_m: f64,
    yaws: usize,
}

const fn container(x_m: f64, y_m: f64, z_m: f64) -> ContainerSize {
    ContainerSize { x_m, y_m, z_m }
}

const REFERENCE: ContainerSize = ContainerSize::REFERENCE;

#[rustfmt::skip]
const CASES: [Case; 8] = [
    Case { name: "1 cm, 4 yaws (trained)", container: REFERENCE, cell_m: 0.01, yaws: 4 },
    Case { name: "1 cm, 3 yaws", container: REFERENCE, cell_m: 0.01, yaws: 3 },
    Case { name: "1 cm, 8 yaws", container: REFERENCE, cell_m: 0.01, yaws: 8 },
    Case { name: "2 cm, 4 yaws", container: REFERENCE, cell_m: 0.02, yaws: 4 },
    Case { name: "8 mm, 4 yaws", container: REFERENCE, cell_m: 0.008, yaws: 4 },
    Case { name: "5 mm, 4 yaws", container: REFERENCE, cell_m: 0.005, yaws: 4 },
    Case { name: "20 x 45 x 30 cm, 1 cm, 4 yaws", container: container(0.20, 0.45, 0.30), cell_m: 0.01, yaws: 4 },
    Case { name: "60 x 40 x 20 cm, 1 cm, 4 yaws", container: container(0.60, 0.40, 0.20), cell_m: 0.01, yaws: 4 },
];

/// How often the optimum was found on one grid, for one sequence.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Found {
    candidates: usize,
    /// Per share, the candidates with an optimum among the proposals.
    found: [usize; 5],
}

/// A row of the results.
#[derive(Debug, Serialize)]
struct Line {
    grid: &'static str,
    candidates: usize,
    accuracy_percent: Vec<Mean>,
}

#[derive(Debug, Serialize)]
struct Results {
    machine: String,
    model: String,
    sequences: u32,
    shares_percent: [f64; 5],
    lines: Vec<Line>,
}

/// What all runs of the experiment depend on.
#[derive(Debug, Serialize)]
struct Settings<'a> {
    catalogue_hash: String,
    model: &'a str,
    sequences: Vec<Vec<usize>>,
    grid: &'a Grid,
}

pub(crate) fn run(arguments: &TransferArguments, backend: &dyn Backend) -> Outcome {
    let model = arguments
        .network
        .find(backend, &Grid::reference())?
        .map_err(|reason| Failure::Run(anyhow::anyhow!(reason)))?;
    let mut lines = Vec::new();
    for case in &CASES {
        lines.push(measure(arguments, case, backend, &model)?);
    }
    let results = Results {
        machine: document::machine(),
        model: model.card().weights_blake3.clone(),
        sequences: arguments.cases,
        shares_percent: SHARES,
        lines,
    };
    publish(arguments, &results)
}

fn measure(
    arguments: &TransferArguments,
    case: &Case,
    backend: &dyn Backend,
    model: &Model,
) -> Outcome<Line> {
    let yaws = Yaws::half_turn(case.yaws).or_input()?;
    let resolution = Resolution::new(case.cell_m, 0.002, yaws).or_input()?;
    let grid = Grid::new(case.container, resolution).or_input()?;
    let catalogue = arguments.catalogue.load(grid.resolution())?;
    let file = SequenceFile::read(&arguments.sequences, &catalogue)?;
    let count = (arguments.cases as usize).min(file.count());
    let sequences: Vec<_> = (0..count)
        .map(|case| file.get(case))
        .collect::<Outcome<_>>()?;
    let settings = Settings {
        catalogue_hash: catalogue.content_hash(),
        model: &model.card().weights_blake3,
        sequences: sequences
            .iter()
            .map(|sequence| sequence.objects.clone())
            .collect(),
        grid: &grid,
    };
    let runs = Runs::new(&arguments.out.join("runs"), &settings)?;
    let items = catalogue.items();
    let network = arguments.network.of(backend, model, &items);
    let jobs: Vec<usize> = (0..count).collect();
    let found = workers::map(case.name, &jobs, workers::default_count(), |index| {
        runs.finish(
            &format!("{index:05}"),
            |_| true,
            || {
                let sequence = sequences.get(*index);
                let items = sequence.map(|sequence| sequence.items(&catalogue));
                search(&grid, items.unwrap_or_default(), network, *index as u64)
            },
        )
    })?;
    let share = |at: usize| {
        Mean::of(found.iter().map(|run| {
            let hits = run.found.get(at).copied().unwrap_or(0);
            100.0 * hits as f64 / run.candidates.max(1) as f64
        }))
    };
    Ok(Line {
        grid: case.name,
        candidates: found.iter().map(|run| run.candidates).sum(),
        accuracy_percent: (0..SHARES.len()).map(share).collect(),
    })
}

/// Packs a sequence exhaustively; at each step, plans every candidate of the buffer alone on the network's proposals
/// and compares the value with that of the exhaustive search.
fn search(grid: &Grid, items: Vec<Arc<Item>>, network: Network<'_>, seed: u64) -> Outcome<Found> {
    let method = |proposals| Method {
        proposals,
        stability: Stability::Published,
        buffer: BUFFER,
        seed,
        ..Method::default()
    };
    let all = method(ProposalSource::All);
    let mut recorder = Recorder::default();
    let mut planner = all.build(grid, None)?;
    let mut cell = IdealCell::new(grid);
    let items = Candidate::sequence(items);
    let how = Play::with_buffer(BUFFER);
    play(grid, &mut planner, &mut cell, items, how, &mut recorder).or_run()?;
    let mut pruned = Vec::new();
    for percent in SHARES {
        let proposals = ProposalSource::Network {
            percent,
            coarsening: Coarsening { cells: 1, yaws: 1 },
            model: None,
        };
        pruned.push(method(proposals).build(grid, Some(&network))?);
    }
    let mut found = Found {
        candidates: 0,
        found: [0; 5],
    };
    for (scene, candidates) in &recorder.0 {
        for candidate in candidates.chunks(1) {
            let input = StepInput::new(grid, scene, candidate);
            let Some(best) = value(&mut planner, &input)? else {
                continue;
            };
            found.candidates += 1;
            for (planner, hits) in pruned.iter_mut().zip(&mut found.found) {
                // A step for which no proposal was valid is searched exhaustively, and does not count as found.
                let is_found = value(planner, &input)?.is_some_and(|value| value <= best + 1e-9);
                *hits += usize::from(is_found);
            }
        }
    }
    Ok(found)
}

/// The value of a planner's choice among the proposals.
fn value(planner: &mut Planner, input: &StepInput<'_>) -> Outcome<Option<f64>> {
    let plan = planner.plan(input).or_run()?;
    Ok(plan
        .choice()
        .filter(|_| !plan.is_widened())
        .map(|choice| choice.value))
}

/// The steps of an episode.
#[derive(Default)]
struct Recorder(Vec<(Scene, Vec<Candidate>)>);

impl Observer for Recorder {
    fn on_step(&mut self, _step: &Step, input: &StepInput<'_>) {
        self.0
            .push((input.scene.clone(), input.candidates.to_vec()));
    }
}

fn publish(arguments: &TransferArguments, results: &Results) -> Outcome {
    let folder = &arguments.out;
    let svg = chart(results).to_svg([900, 560]).or_run()?;
    write_whole(&folder.join("transfer.svg"), svg.as_bytes())?;
    let markdown = markdown(results);
    document::publish(folder, "transfer", results, &markdown, arguments.json)
}

fn chart(results: &Results) -> Lines {
    let rows = results.lines.iter();
    shares::chart(
        "Optimum among the best-scored K %, away from the trained grid",
        "Candidates",
        rows.map(|line| (line.grid, &line.accuracy_percent[..])),
    )
}

fn markdown(results: &Results) -> String {
    let mut text = format!(
        "# Accuracy away from the trained grid\n\nThe share of candidates whose optimum, the exhaustive search's best valid \
         placement, is among the best-scored K % of the network with hash `{}`. {} test sequences per grid, packed \
         exhaustively as planned, without physics; every candidate of every step counts. Intervals are 95 % confidence \
         intervals over the sequences, by Student's t.\n\n| grid | candidates |",
        results.model.get(..12).unwrap_or(""),
        results.sequences,
    );
    text.push_str(&shares::head());
    text.push_str("\n|---|---|---|---|---|---|---|\n");
    for line in &results.lines {
        text.push_str(&format!("| {} | {} |", line.grid, line.candidates));
        for accuracy in &line.accuracy_percent {
            text.push_str(&format!(" {} |", accuracy.shown(1)));
        }
        text.push('\n');
    }
    text.push_str("\n![Accuracy against K](transfer.svg)\n");
    text
}
