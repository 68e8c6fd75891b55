//! `ppnpack experiment table4`: objects that the network was not trained on.

use std::path::PathBuf;

use clap::Args;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_chart::{Bar, Bars};
use ppnpack_packing::objective::{Heuristic, Order};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::comparison::{Contender, Means, Run, Setting, pack_all, ratio_percent};
use super::document;
use super::network::NetworkOptions;
use super::runs::Runs;
use super::statistics::Mean;
use crate::failure::{OrRun, Outcome};
use crate::network::Backend;
use crate::options::{
    CatalogueOptions, Conditions, GridOptions, PhysicsOptions, ProposalSource, StabilityOption,
};
use crate::output::write_whole;
use crate::sequence::Sequence;
use crate::workers;

/// Packs random sequences of unseen objects: at random, with the network's proposals, searching all placements.
#[derive(Debug, Args)]
pub(super) struct Table4Arguments {
    /// The objects; give a --catalogue that the network was not trained on
    #[command(flatten)]
    catalogue: CatalogueOptions,

    /// How many sequences
    #[arg(long, value_name = "COUNT", default_value_t = 400, value_parser = clap::value_parser!(u32).range(2..))]
    cases: u32,

    /// Objects in a sequence
    #[arg(long, value_name = "COUNT", default_value_t = 80, value_parser = clap::value_parser!(u32).range(1..))]
    length: u32,

    #[command(flatten)]
    grid: GridOptions,

    #[command(flatten)]
    physics: PhysicsOptions,

    #[command(flatten)]
    network: NetworkOptions,

    /// How many items the robot may choose among
    #[arg(long, value_name = "COUNT", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    buffer: u32,

    /// The stability test that placements must pass
    #[arg(long, value_enum, default_value = "published")]
    stability: StabilityOption,

    /// The seed of everything that is random, the sequences among it
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    seed: u64,

    /// Sequences packed at once [default: one per core]
    #[arg(long, value_name = "COUNT")]
    workers: Option<usize>,

    /// Where table4.md, table4.json and table4.svg are written; a killed run goes on there
    #[arg(long, value_name = "DIR", default_value = "out/table4")]
    out: PathBuf,

    /// Print the results as JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// Results of the paper on its 28 unseen objects: seconds, cm³, percent, items; 400 cases.
const PAPER: [(&str, [f64; 4]); 3] = [
    ("Random", [0.37, 19_029.0, 39.5, 27.54]),
    ("PPN-Pack", [0.45, 22_993.0, 47.3, 33.69]),
    ("Search all", [1.58, 25_001.0, 49.8, 34.26]),
];

/// A row of the results.
#[derive(Debug, Serialize)]
struct Line {
    method: String,
    #[serde(flatten)]
    means: Means,
    /// Of the exhaustive search's, on the same sequences.
    compactness_ratio_percent: Mean,
    mesh_volume_ratio_percent: Mean,
    /// Seconds, cm³, percent, items.
    paper: [f64; 4],
}

#[derive(Debug, Serialize)]
struct Results<'a> {
    machine: String,
    workers: usize,
    objects: usize,
    settings: &'a Setting,
    #[serde(skip_serializing_if = "Option::is_none")]
    without_network: Option<String>,
    lines: Vec<Line>,
}

pub(super) fn run(arguments: &Table4Arguments, backend: &dyn Backend) -> Outcome {
    let grid = arguments.grid.grid()?;
    let simulated = arguments
        .physics
        .simulated(&grid, arguments.seed, Conditions::Reference)?;
    let catalogue = arguments.catalogue.load(grid.resolution())?;
    let sequences = draw(arguments, &catalogue);
    let settings = Setting {
        version: env!("CARGO_PKG_VERSION"),
        catalogue_hash: catalogue.content_hash(),
        grid,
        simulated,
        buffer: arguments.buffer as usize,
        stability: arguments.stability,
        seed: arguments.seed,
    };
    let runs = Runs::new(&arguments.out.join("runs"), &settings)?;
    let available = arguments.network.find(backend, &settings.grid)?;
    let mut rows = Vec::new();
    for (name, paper) in PAPER {
        let (heuristic, order, proposals) = match (name, &available) {
            ("Random", _) => (Heuristic::Random, Order::Shuffled, ProposalSource::All),
            ("PPN-Pack", Ok(model)) => {
                let source = arguments.network.source(&settings.grid, model);
                (Heuristic::Sdfm, Order::Balance, source)
            }
            ("PPN-Pack", Err(_)) => continue,
            _ => (Heuristic::Sdfm, Order::Balance, ProposalSource::All),
        };
        let name = match &proposals {
            ProposalSource::Network { percent, .. } => format!("{name} (K = {percent} %)"),
            _ => name.to_owned(),
        };
        let contender = Contender {
            name,
            heuristic,
            order,
            proposals,
        };
        rows.push((contender, paper));
    }
    let contenders: Vec<Contender> = rows
        .iter()
        .map(|(contender, _)| contender.clone())
        .collect();
    let cores = workers::default_count();
    let workers = arguments.workers.unwrap_or(cores).clamp(1, cores);
    let items = catalogue.items();
    let network = available
        .as_ref()
        .ok()
        .map(|model| arguments.network.of(backend, model, &items));
    let packed = pack_all(
        &catalogue,
        &settings,
        &contenders,
        &sequences,
        &runs,
        workers,
        network,
    )?;
    let all = packed.last().map_or(&[][..], |runs| runs);
    let lines = rows
        .iter()
        .zip(&packed)
        .map(|((contender, paper), runs)| Line {
            method: contender.name.clone(),
            means: Means::of(runs),
            compactness_ratio_percent: ratio_percent(runs, all, |run: &Run| run.compactness),
            mesh_volume_ratio_percent: ratio_percent(runs, all, |run: &Run| run.meshes_m3),
            paper: *paper,
        });
    let results = Results {
        machine: document::machine(),
        workers,
        objects: catalogue.len(),
        without_network: available.as_ref().err().cloned(),
        lines: lines.collect(),
        settings: &settings,
    };
    publish(arguments, &results)
}

/// Sequences that depend on the seed and their number alone.
fn draw(arguments: &Table4Arguments, catalogue: &Catalogue) -> Vec<Sequence> {
    let sequences = (0..u64::from(arguments.cases)).map(|case| {
        let mut random = ChaCha8Rng::seed_from_u64(arguments.seed);
        random.set_stream(case + 1);
        let objects = (0..arguments.length).map(|_| random.random_range(0..catalogue.len().max(1)));
        Sequence {
            from: format!("sequence {case} of seed {}", arguments.seed),
            objects: objects.collect(),
        }
    });
    sequences.collect()
}

fn publish(arguments: &Table4Arguments, results: &Results<'_>) -> Outcome {
    let folder = &arguments.out;
    let chart = Bars {
        title: "Compactness on unseen objects".to_owned(),
        value_label: "Compactness (%)".to_owned(),
        decimals: 1,
        bars: results
            .lines
            .iter()
            .map(|line| Bar {
                label: line.method.clone(),
                value: line.means.compactness_percent.mean,
            })
            .collect(),
    };
    let svg = chart.to_svg([700, 460]).or_run()?;
    write_whole(&folder.join("table4.svg"), svg.as_bytes())?;
    let markdown = markdown(results);
    document::publish(folder, "table4", results, &markdown, arguments.json)
}

fn markdown(results: &Results<'_>) -> String {
    let settings = results.settings;
    let cases = results.lines.first().map_or(0, |line| line.means.cases);
    let mut text = format!(
        "# Table 4: objects that the network was not trained on\n\n\
         {cases} random sequences of {} objects, seed {}; {} x {} cells, {} yaws, buffer {}, {} stability test, {} scan. \
         Machine: {}; {} sequences at once, each on one core. Intervals are 95 % confidence intervals over the \
         sequences; shares are of what the exhaustive search packs on the same sequences. The paper's figures (400 \
         sequences of its 28 objects, its own meshes and machine) are in brackets.\n\n\
         | method | decision per item | items packed | voxel volume (cm³) | compactness (%) | share of compactness (%) | \
         share of mesh volume (%) |\n|---|---|---|---|---|---|---|\n",
        results.objects,
        settings.seed,
        settings.grid.nx(),
        settings.grid.ny(),
        settings.grid.resolution().yaws().count(),
        settings.buffer,
        document::name_of(&settings.stability),
        document::name_of(&settings.simulated.scan),
        results.machine,
        results.workers,
    );
    for line in &results.lines {
        let Line { means, .. } = line;
        let [seconds, volume, compactness, items] = line.paper;
        text.push_str(&format!(
            "| {} | {} ms [{seconds} s] | {} [{items:.1}] | {} [{volume:.0}] | {} [{compactness:.1}] | {} | {} |\n",
            line.method,
            means.decision_s.scaled(1e3).shown(3),
            means.items.shown(1),
            means.voxels_cm3.shown(0),
            means.compactness_percent.shown(1),
            line.compactness_ratio_percent.shown(1),
            line.mesh_volume_ratio_percent.shown(1),
        ));
    }
    if let Some(reason) = &results.without_network {
        text.push_str(&format!("\nPPN-Pack is missing: {reason}.\n"));
    }
    text.push_str("\n![Compactness](table4.svg)\n");
    text
}
