//! `ppnpack experiment pareto`: decision time against packed volume, for every way to propose placements.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use ppnpack_chart::{Interval, PlotPoint, PointSeries, Scatter};
use ppnpack_model::weights::Model;
use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::objective::{Heuristic, Order};
use serde::Serialize;

use super::comparison::{Contender, Means, Run, Setting, pack_all, ratio_percent};
use super::document;
use super::network::NetworkOptions;
use super::runs::Runs;
use super::statistics::Mean;
use crate::failure::{Failure, OrInput, OrRun, Outcome};
use crate::network::Backend;
use crate::options::{
    CatalogueOptions, Conditions, PROPOSAL_YAWS, PhysicsOptions, ProposalSource, StabilityOption,
    at_least_one,
};
use crate::output::{print_json, print_line, write_whole};
use crate::sequence::{Sequence, SequenceFile};
use crate::workers;

/// Packs test sequences on several grids with every source of proposals at several shares K.
#[derive(Debug, Args)]
pub(super) struct ParetoArguments {
    #[command(flatten)]
    catalogue: CatalogueOptions,

    /// A .npy file of sequences, int64 [sequences, length], of object indices
    #[arg(long, value_name = "FILE")]
    sequences: PathBuf,

    /// How many sequences, from the first
    #[arg(long, value_name = "COUNT", default_value_t = 20, value_parser = clap::value_parser!(u32).range(2..))]
    cases: u32,

    /// The grids
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        default_value = "coarse,medium,fine"
    )]
    grids: Vec<GridOption>,

    /// The shares K that are compared, in percent
    #[arg(
        long = "shares",
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "0.25,1,5,20"
    )]
    percents: Vec<f64>,

    /// How many yaws at most the network and the coarse search propose for; the others follow the nearest
    #[arg(long, value_name = "COUNT", default_value_t = PROPOSAL_YAWS, value_parser = at_least_one)]
    proposal_yaws: usize,

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

    /// The seed of everything that is random
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    seed: u64,

    /// Sequences packed at once; one per core at most, so that decision times stay those of a free core
    /// [default: one per core]
    #[arg(long, value_name = "COUNT")]
    workers: Option<usize>,

    /// Where pareto.md, pareto.json and the figures are written; a killed run goes on there
    #[arg(long, value_name = "DIR", default_value = "out/pareto")]
    out: PathBuf,

    /// Print the results as JSON instead of tables
    #[arg(long)]
    json: bool,
}

/// A grid over the reference container.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum GridOption {
    /// 1 cm, 4 yaws
    Coarse,
    /// 5 mm, 8 yaws
    Medium,
    /// 2.5 mm, 16 yaws
    Fine,
}

impl GridOption {
    fn shape(self) -> (f64, usize, &'static str) {
        match self {
            Self::Coarse => (0.01, 4, "1 cm, 4 yaws"),
            Self::Medium => (0.005, 8, "5 mm, 8 yaws"),
            Self::Fine => (0.0025, 16, "2.5 mm, 16 yaws"),
        }
    }

    fn key(self) -> &'static str {
        match self {
            Self::Coarse => "coarse",
            Self::Medium => "medium",
            Self::Fine => "fine",
        }
    }

    fn resolution(self) -> Outcome<Resolution> {
        let (cell_m, yaws, _) = self.shape();
        let yaws = Yaws::half_turn(yaws).or_input()?;
        Resolution::new(cell_m, 0.002, yaws).or_input()
    }
}

/// A way to propose on one grid.
#[derive(Debug, Serialize)]
struct Line {
    method: String,
    proposals: ProposalSource,
    #[serde(flatten)]
    means: Means,
    /// Of the exhaustive search's, on the same sequences and grid.
    mesh_volume_ratio_percent: Mean,
    decision_ratio_percent: Mean,
}

/// The results on one grid.
#[derive(Debug, Serialize)]
struct OfGrid {
    name: &'static str,
    key: &'static str,
    settings: Setting,
    lines: Vec<Line>,
}

#[derive(Debug, Serialize)]
struct Results {
    machine: String,
    workers: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    without_network: Option<String>,
    grids: Vec<OfGrid>,
}

pub(super) fn run(arguments: &ParetoArguments, backend: &dyn Backend) -> Outcome {
    let cores = workers::default_count();
    let workers = arguments.workers.unwrap_or(cores).clamp(1, cores);
    let mut results = Results {
        machine: document::machine(),
        workers,
        without_network: None,
        grids: Vec::new(),
    };
    for option in &arguments.grids {
        let grid = Grid::new(ContainerSize::REFERENCE, option.resolution()?).or_input()?;
        let available = arguments.network.find(backend, &grid)?;
        results.without_network = available.as_ref().err().cloned();
        let of_grid = compare(arguments, *option, grid, backend, workers, &available)?;
        results.grids.push(of_grid);
        // What is done is shown, even if a later grid is interrupted.
        publish(arguments, &results)?;
    }
    if arguments.json {
        print_json(&results)?;
    } else {
        print_line(&markdown(&results))?;
        let path = arguments.out.join("pareto.md");
        print_line(&format!("Written to {}", path.display()))?;
    }
    Ok(())
}

fn compare(
    arguments: &ParetoArguments,
    option: GridOption,
    grid: Grid,
    backend: &dyn Backend,
    workers: usize,
    available: &Result<Model, String>,
) -> Outcome<OfGrid> {
    let simulated = arguments
        .physics
        .simulated(&grid, arguments.seed, Conditions::Reference)?;
    let catalogue = arguments.catalogue.load(grid.resolution())?;
    let file = SequenceFile::read(&arguments.sequences, &catalogue)?;
    let cases = arguments.cases as usize;
    if cases > file.len() {
        return Err(Failure::input(format_args!(
            "--cases {cases}: {} has {} sequences",
            arguments.sequences.display(),
            file.len()
        )));
    }
    let sequences: Vec<Sequence> = (0..cases)
        .map(|case| file.get(case))
        .collect::<Outcome<_>>()?;
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
    let contenders = contenders(arguments, &settings.grid, available.as_ref().ok());
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
    let all = packed.first().map_or(&[][..], |runs| runs);
    let lines = contenders
        .into_iter()
        .zip(&packed)
        .map(|(contender, runs)| Line {
            method: contender.name,
            proposals: contender.proposals,
            means: Means::of(runs),
            mesh_volume_ratio_percent: ratio_percent(runs, all, |run: &Run| run.meshes_m3),
            decision_ratio_percent: ratio_percent(runs, all, |run: &Run| run.decision_s),
        });
    let (_, _, name) = option.shape();
    Ok(OfGrid {
        name,
        key: option.key(),
        lines: lines.collect(),
        settings,
    })
}

/// The exhaustive search first.
fn contenders(arguments: &ParetoArguments, grid: &Grid, model: Option<&Model>) -> Vec<Contender> {
    let percents = || arguments.percents.iter().copied();
    let yaws = arguments.proposal_yaws;
    let network = |percent| Some(ProposalSource::network(grid, percent, yaws, model?));
    let mut sources = vec![ProposalSource::All, ProposalSource::Bounded];
    sources.extend(percents().filter_map(network));
    sources.extend(percents().map(|percent| ProposalSource::coarse(grid, percent, yaws)));
    sources.extend(percents().map(|percent| ProposalSource::Random { percent }));
    let contenders = sources.into_iter().map(|proposals| Contender {
        name: proposals.to_string(),
        heuristic: Heuristic::Sdfm,
        order: Order::Balance,
        proposals,
    });
    contenders.collect()
}

fn publish(arguments: &ParetoArguments, results: &Results) -> Outcome {
    let folder = &arguments.out;
    let mut charts: Vec<(String, Scatter)> = results
        .grids
        .iter()
        .map(|grid| (format!("pareto-{}", grid.key), scatter(&[grid])))
        .collect();
    charts.push((
        "pareto".to_owned(),
        scatter(&results.grids.iter().collect::<Vec<_>>()),
    ));
    for (name, chart) in charts {
        let svg = chart.to_svg([900, 600]).or_run()?;
        write_whole(&folder.join(format!("{name}.svg")), svg.as_bytes())?;
    }
    let json = serde_json::to_vec_pretty(results).or_run()?;
    write_whole(&folder.join("pareto.json"), &json)?;
    document::write(&folder.join("pareto.md"), &markdown(results))
}

fn scatter(grids: &[&OfGrid]) -> Scatter {
    let series = grids.iter().map(|grid| PointSeries {
        name: grid.name.to_owned(),
        reference: false,
        points: grid
            .lines
            .iter()
            .map(|line| PlotPoint {
                label: line.method.clone(),
                x: line.means.decision_s.mean * 1e3,
                y: line.means.mesh_compactness_percent.mean,
                x_interval: Some(interval(&line.means.decision_s.scaled(1e3))),
                y_interval: Some(interval(&line.means.mesh_compactness_percent)),
            })
            .collect(),
    });
    Scatter {
        title: "Mesh-volume compactness against decision time".to_owned(),
        x_label: "Decision time per item (ms)".to_owned(),
        y_label: "Compactness by mesh volume (%)".to_owned(),
        logarithmic_x: true,
        series: series.collect(),
    }
}

fn interval(mean: &Mean) -> Interval {
    Interval {
        low: mean.mean - mean.half_width,
        high: mean.mean + mean.half_width,
    }
}

fn markdown(results: &Results) -> String {
    let mut text = "# Decision time against packed volume\n\n".to_owned();
    if let Some(OfGrid {
        settings, lines, ..
    }) = results.grids.first()
    {
        text.push_str(&format!(
            "{} sequences, the same for every method; SDFM, buffer {}, {} stability test, {} scan. Machine: {}; {} \
             sequences at once, each on one core. Intervals are 95 % confidence intervals over the sequences; shares \
             are of the exhaustive search (`all`) on the same grid, in this run.\n",
            lines.first().map_or(0, |line| line.means.cases),
            settings.buffer,
            document::name_of(&settings.stability),
            document::name_of(&settings.simulated.scan),
            results.machine,
            results.workers,
        ));
    }
    for grid in &results.grids {
        text.push_str(&format!(
            "\n## {}\n\n| proposals | decision per item (ms) | proposing | evaluating | checking | items packed | mesh volume \
             (cm³) | mesh compactness (%) | share of mesh volume (%) | share of decision time (%) |\n\
             |---|---|---|---|---|---|---|---|---|---|\n",
            grid.name
        ));
        for line in &grid.lines {
            let Line { means, .. } = line;
            text.push_str(&format!(
                "| {} | {} | {:.3} | {:.3} | {:.3} | {} | {} | {} | {} | {} |\n",
                line.method,
                means.decision_s.scaled(1e3).shown(3),
                means.propose_s.mean * 1e3,
                means.evaluate_s.mean * 1e3,
                means.check_s.mean * 1e3,
                means.items.shown(1),
                means.meshes_cm3.shown(0),
                means.mesh_compactness_percent.shown(1),
                line.mesh_volume_ratio_percent.shown(1),
                line.decision_ratio_percent.shown(1),
            ));
        }
        text.push_str(&format!("\n![{}](pareto-{}.svg)\n", grid.name, grid.key));
    }
    if let Some(reason) = &results.without_network {
        text.push_str(&format!("\nThe network is missing: {reason}.\n"));
    }
    text.push_str("\n## All grids\n\n![All grids](pareto.svg)\n");
    text
}
