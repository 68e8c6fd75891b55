//! `ppnpack experiment pareto`: decision time against packed volume, for every way to propose placements.

use clap::{Args, ValueEnum};
use ppnpack_chart::{PointSeries, Scatter};
use ppnpack_cli::failure::Outcome;
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::{PROPOSAL_YAWS, at_least_one};
use ppnpack_packing::grid::{ContainerSize, Grid};
use ppnpack_packing::method::ProposalSource;
use ppnpack_packing::objective::{Heuristic, Order};
use serde::Serialize;

use crate::cases::SequenceOptions;
use crate::comparison::{
    Comparison, ComparisonOptions, Contender, Means, SHARE, Setting, WIDENED, point, ratio_percent,
};
use crate::document::{self, OutOptions};
use crate::scene;
use crate::statistics::Mean;

/// Packs test sequences on several grids with every source of proposals at several shares K.
#[derive(Debug, Args)]
pub(crate) struct ParetoArguments {
    #[command(flatten)]
    sequences: SequenceOptions<0, 20>,

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
    comparison: ComparisonOptions,

    #[command(flatten)]
    out: OutOptions,
}

/// A grid over the reference container.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum GridOption {
    /// 1 cm, 4 yaws
    Coarse,
    /// 5 mm, 8 yaws
    Medium,
    /// 2.5 mm, 16 yaws
    Fine,
}

impl GridOption {
    /// What files are named by, what readers see, the edge of a cell in metres, how many yaws.
    pub(crate) fn parts(self) -> (&'static str, &'static str, f64, usize) {
        match self {
            Self::Coarse => ("coarse", "1 cm, 4 yaws", 0.01, 4),
            Self::Medium => ("medium", "5 mm, 8 yaws", 0.005, 8),
            Self::Fine => ("fine", "2.5 mm, 16 yaws", 0.0025, 16),
        }
    }

    pub(crate) fn grid(self) -> Outcome<Grid> {
        let (.., cell_m, yaws) = self.parts();
        scene::grid(ContainerSize::REFERENCE, cell_m, yaws)
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

#[derive(Debug, Serialize)]
struct OfGrid {
    name: &'static str,
    key: &'static str,
    settings: Setting,
    lines: Vec<Line>,
}

#[derive(Debug, Serialize)]
struct Results {
    workers: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    without_network: Option<String>,
    grids: Vec<OfGrid>,
}

pub(crate) fn run(arguments: &ParetoArguments, backend: &dyn Backend) -> Outcome {
    let mut results = Results {
        workers: arguments.comparison.runs.workers(),
        without_network: None,
        grids: Vec::new(),
    };
    for option in &arguments.grids {
        let comparison = Comparison::new(&arguments.comparison, backend, option.grid()?)?;
        results.without_network = comparison.without_network();
        results.grids.push(compare(arguments, *option, comparison)?);
    }
    draw(arguments, &results)?;
    arguments
        .out
        .publish("pareto", &results, &markdown(&results))
}

/// What a grid comes to.
fn compare(
    arguments: &ParetoArguments,
    option: GridOption,
    comparison: Comparison<'_>,
) -> Outcome<OfGrid> {
    let cases = arguments.sequences.read(&comparison.catalogue)?;
    let contenders = contenders(arguments, &comparison);
    let kept = arguments.comparison.runs.folder(&arguments.out, "pareto");
    let packed = comparison.pack(&contenders, &cases, &kept)?;
    let all = packed.first().map_or(&[][..], |runs| runs);
    let (key, name, ..) = option.parts();
    let lines = contenders.into_iter().zip(&packed);
    let lines = lines.map(|(contender, runs)| Line {
        method: contender.name,
        proposals: contender.proposals,
        means: Means::of(runs),
        mesh_volume_ratio_percent: ratio_percent(runs, all, |run| run.meshes_m3),
        decision_ratio_percent: ratio_percent(runs, all, |run| run.decision_s),
    });
    Ok(OfGrid {
        name,
        key,
        lines: lines.collect(),
        settings: comparison.setting,
    })
}

/// The exhaustive search first.
fn contenders(arguments: &ParetoArguments, comparison: &Comparison<'_>) -> Vec<Contender> {
    let grid = &comparison.setting.grid;
    let model = comparison.model.as_ref().ok();
    let percents = || arguments.percents.iter().copied();
    let yaws = arguments.proposal_yaws;
    let network = |percent| {
        let weights = &model?.card().weights_blake3;
        Some(ProposalSource::network(grid, percent, None, yaws, weights))
    };
    let mut sources = vec![ProposalSource::All, ProposalSource::Bounded];
    sources.extend(percents().filter_map(network));
    sources.extend(percents().map(|percent| ProposalSource::Random { percent }));
    let contenders = sources.into_iter().map(|proposals| Contender {
        name: proposals.to_string(),
        heuristic: Heuristic::Sdfm,
        order: Order::Balance,
        proposals,
    });
    contenders.collect()
}

fn draw(arguments: &ParetoArguments, results: &Results) -> Outcome {
    let folder = arguments.out.folder("pareto");
    let draw = |name: &str, grids: &[OfGrid]| {
        document::figure(&folder, name, scatter(grids).to_svg([900, 600]))
    };
    for grid in &results.grids {
        draw(&format!("pareto-{}", grid.key), std::slice::from_ref(grid))?;
    }
    draw("pareto", &results.grids)
}

fn scatter(grids: &[OfGrid]) -> Scatter {
    let point = |line: &Line| {
        let decision_ms = line.means.decision_s.scaled(1e3);
        let compactness = &line.means.mesh_floor_compactness_percent;
        point(&line.method, &decision_ms, compactness)
    };
    let series = grids.iter().map(|grid| PointSeries {
        name: grid.name.to_owned(),
        reference: false,
        points: grid.lines.iter().map(point).collect(),
    });
    Scatter {
        title: "Mesh-volume compactness against decision time".to_owned(),
        x_label: "Decision time per item (ms)".to_owned(),
        y_label: "Compactness of the meshes by the floor (%)".to_owned(),
        series: series.collect(),
    }
}

fn markdown(results: &Results) -> String {
    let mut text = "# Decision time against packed volume\n\n".to_owned();
    if let Some(first) = results.grids.first() {
        text += &format!(
            "{} sequences, the same for every method; SDFM, {}; shares are of the exhaustive search (`all`) on the same \
             grid, in this run. Compactness is over the floor times the greatest height. {SHARE} {WIDENED}\n",
            first.lines.first().map_or(0, |line| line.means.cases),
            first.settings.in_words(results.workers),
        );
    }
    for grid in &results.grids {
        text += &format!(
            "\n## {}\n\n| proposals | decision per item (ms) | proposing | evaluating | checking | items packed | mesh volume \
             (cm³) | mesh compactness by floor (%) | share of mesh volume (%) | share of decision time (%) | steps widened |\n\
             |---|---|---|---|---|---|---|---|---|---|---|\n",
            grid.name
        );
        for line in &grid.lines {
            let Line { means, .. } = line;
            text += &format!(
                "| {} | {} | {:.3} | {:.3} | {:.3} | {} | {} | {} | {} | {} | {} |\n",
                line.method,
                means.decision_s.scaled(1e3).shown(3),
                means.propose_s.mean * 1e3,
                means.evaluate_s.mean * 1e3,
                means.check_s.mean * 1e3,
                means.items.shown(1),
                means.meshes_cm3.shown(0),
                means.mesh_floor_compactness_percent.shown(1),
                line.mesh_volume_ratio_percent.shown(1),
                line.decision_ratio_percent.shown(1),
                means.widened(),
            );
        }
        text += &format!("\n![{}](pareto-{}.svg)\n", grid.name, grid.key);
    }
    if let Some(reason) = &results.without_network {
        text += &format!("\nThe network is missing: {reason}.\n");
    }
    text + "\n## All grids\n\n![All grids](pareto.svg)\n"
}
