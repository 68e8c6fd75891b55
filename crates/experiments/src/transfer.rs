//! `ppnpack experiment transfer`: how often the optimum is among the network's proposals away from the grid that it
//! was trained on.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use ppnpack_model::weights::Model;
use ppnpack_packing::coarse::Coarsening;
use ppnpack_packing::episode::{IdealCell, Observer, Play, Step, play};
use ppnpack_packing::grid::{ContainerSize, Grid};
use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::item::Item;
use ppnpack_packing::method::{ProposalSource, Stability};
use ppnpack_packing::plan::{Candidate, Plan};
use ppnpack_packing::step::StepInput;
use serde::{Deserialize, Serialize};

use crate::document::{Answer, Document};
use crate::method::sdfm;
use crate::network::NetworkOptions;
use crate::origin;
use crate::runs::{Part, Runs, ShardOptions};
use crate::shares::{self, SHARES};
use crate::statistics::{Mean, percentage};
use crate::{scene, workers};
use ppnpack_cli::failure::{Failure, OrRun, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::{CatalogueOptions, Network};
use ppnpack_cli::sequence::SequenceFile;

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

    /// Where report.html, transfer.md, transfer.json and the figure are written
    #[arg(long, value_name = "DIR", default_value = "out/transfer")]
    out: PathBuf,

    #[command(flatten)]
    runs: ShardOptions,

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
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Found {
    candidates: usize,
    /// Per share, the candidates with an optimum among the proposals.
    found: [usize; 5],
    /// Per share, those for which no proposal was valid, so that all placements were searched: they do not count as found.
    widened: [usize; 5],
}

#[derive(Debug, Serialize)]
struct Line {
    grid: &'static str,
    candidates: usize,
    accuracy_percent: Vec<Mean>,
    /// Per share, the candidates for which no proposal was valid.
    steps_widened: Vec<usize>,
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
    let part = arguments.runs.part(&arguments.out);
    let measured = CASES
        .iter()
        .map(|case| measure(arguments, case, &part, backend, &model));
    let measured: Vec<Option<Line>> = measured.collect::<Outcome<_>>()?;
    let Some(lines) = measured.into_iter().collect() else {
        return part.tell(arguments.json);
    };
    let results = Results {
        machine: origin::machine(),
        model: model.card().weights_blake3.clone(),
        sequences: arguments.cases,
        shares_percent: SHARES,
        lines,
    };
    let folder = &arguments.out;
    let lines = results.lines.iter();
    shares::draw(
        (folder, "transfer"),
        "Optimum among the best-scored K %, away from the trained grid",
        "Candidates",
        lines.map(|line| (line.grid, &line.accuracy_percent)),
    )?;
    let document = Document {
        name: "transfer",
        answer: Answer {
            question: "Does the network find the optimum on grids that it was not trained on?",
            text: answer(&results),
            picture: "transfer.svg".to_owned(),
        },
        results: &results,
        asked: arguments,
        measured: &["lines"],
        markdown: markdown(&results),
    };
    document.publish(folder, arguments.json)
}

/// How often it is found at the smallest share: on the trained grid, and on those where that is most and least often.
fn answer(results: &Results) -> String {
    let found = |line: &Line| Some((line.grid, line.accuracy_percent.first().copied()?));
    let found: Vec<_> = results.lines.iter().filter_map(found).collect();
    let [(_, trained), others @ ..] = found.as_slice() else {
        return "Nothing was searched.".to_owned();
    };
    let mut others: Vec<_> = others.iter().collect();
    others.sort_by(|(_, one), (_, other)| one.mean.total_cmp(&other.mean));
    let others = match others.as_slice() {
        [(worst, least), .., (best, most)] => format!(
            "; on others for {} % ({worst}) to {} % ({best})",
            least.shown(1),
            most.shown(1)
        ),
        _ => String::new(),
    };
    format!(
        "With K = {} % it is among the proposals for {} % of the candidates on the grid that it was trained on{others}.",
        results.shares_percent.first().copied().unwrap_or_default(),
        trained.shown(1)
    )
}

/// What was found on one grid; `None` where only a shard of it is made here.
fn measure(
    arguments: &TransferArguments,
    case: &Case,
    part: &Part,
    backend: &dyn Backend,
    model: &Model,
) -> Outcome<Option<Line>> {
    let grid = scene::grid(case.container, case.cell_m, case.yaws)?;
    let catalogue = arguments.catalogue.load(grid.resolution())?;
    let file = SequenceFile::read(&arguments.sequences, &catalogue)?;
    let count = (arguments.cases as usize).min(file.count());
    let sequences = (0..count).map(|case| file.get(case));
    let sequences: Vec<_> = sequences.collect::<Outcome<_>>()?;
    let objects = sequences.iter().map(|sequence| sequence.objects.clone());
    let settings = Settings {
        catalogue_hash: catalogue.content_hash(),
        model: &model.card().weights_blake3,
        sequences: objects.collect(),
        grid: &grid,
    };
    let runs = Runs::new(&part.runs, &settings)?;
    let items = catalogue.items();
    let network = arguments.network.of(backend, model, &items);
    let jobs: Vec<_> = part.of((0_u64..).zip(&sequences)).collect();
    let found = workers::map(case.name, &jobs, workers::default_count(), |job| {
        let (index, sequence) = job;
        let search = || search(&grid, sequence.items(&catalogue), network, *index);
        runs.finish(&format!("{index:05}"), |_| true, search)
    })?;
    let Some(found) = part.finish(&runs, found)? else {
        return Ok(None);
    };
    let share = |at: usize| {
        Mean::of(found.iter().map(|run| {
            let hits = run.found.get(at).copied().unwrap_or(0);
            percentage(hits, run.candidates.max(1))
        }))
    };
    let widened = |at: usize| {
        let widened = found.iter().filter_map(|run| run.widened.get(at));
        widened.sum::<usize>()
    };
    Ok(Some(Line {
        grid: case.name,
        candidates: found.iter().map(|run| run.candidates).sum(),
        accuracy_percent: (0..SHARES.len()).map(share).collect(),
        steps_widened: (0..SHARES.len()).map(widened).collect(),
    }))
}

/// Packs a sequence exhaustively; at each step, plans every candidate of the buffer alone on the network's proposals
/// and compares the value with that of the exhaustive search.
fn search(grid: &Grid, items: Vec<Arc<Item>>, network: Network<'_>, seed: u64) -> Outcome<Found> {
    let method = |proposals| sdfm(proposals, Stability::Published, BUFFER, seed);
    let mut recorder = Recorder::default();
    let mut planner = method(ProposalSource::All).build(grid, None)?;
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
    let mut found = Found::default();
    for (scene, candidates) in &recorder.0 {
        for candidate in candidates.chunks(1) {
            let input = StepInput::new(grid, scene, candidate);
            let Some(best) = value(planner.plan(&input).or_run()?) else {
                continue;
            };
            found.candidates += 1;
            let shares = found.found.iter_mut().zip(&mut found.widened);
            for (planner, (hits, widened)) in pruned.iter_mut().zip(shares) {
                let plan = planner.plan(&input).or_run()?;
                let is_best = value(plan).is_some_and(|value| value <= best + 1e-9);
                *hits += usize::from(is_best && !plan.is_widened());
                *widened += usize::from(plan.is_widened());
            }
        }
    }
    Ok(found)
}

/// The value of the choice.
fn value(plan: &Plan) -> Option<f64> {
    plan.choice().map(|choice| choice.value)
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

fn markdown(results: &Results) -> String {
    let mut text = format!(
        "# Accuracy away from the trained grid\n\nThe share of candidates whose optimum, the exhaustive search's best valid \
         placement, is among the best-scored K % of the network with hash `{}`. {} test sequences per grid, packed \
         exhaustively as planned, without physics; every candidate of every step counts. Intervals are 95 % confidence \
         intervals over the sequences, by Student's t. Candidates of which no proposal is valid, so that a step is widened to \
         an exhaustive search, do not count as found; the last column has their number at each K.\n\n| grid | candidates |",
        results.model.get(..12).unwrap_or(""),
        results.sequences,
    );
    text += &shares::head();
    text += " widened |\n|---|---|---|---|---|---|---|---|\n";
    for line in &results.lines {
        text += &format!("| {} | {} |", line.grid, line.candidates);
        for accuracy in &line.accuracy_percent {
            text += &format!(" {} |", accuracy.shown(1));
        }
        let widened: Vec<String> = line.steps_widened.iter().map(usize::to_string).collect();
        text += &format!(" {} |\n", widened.join(", "));
    }
    text + "\n![Accuracy against K](transfer.svg)\n"
}
