//! `ppnpack experiment pareto`: decision time against packed volume, for every way to propose placements.

use clap::{Args, ValueEnum};
use ppnpack_chart::Scatter;
use ppnpack_cli::failure::Outcome;
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::{PROPOSAL_YAWS, at_least_one};
use ppnpack_packing::grid::{ContainerSize, Grid};
use ppnpack_packing::method::ProposalSource;
use ppnpack_packing::objective::{Heuristic, Order};
use serde::Serialize;

use crate::cases::SequenceOptions;
use crate::comparison::{
    Comparison, ComparisonOptions, Contender, Run, SHARE, Setting, WIDENED, columns,
};
use crate::document::{self, OutOptions};
use crate::scene;
use crate::sheet::{Lines, scatter};

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

    /// How many yaws at most the network proposes for; the others follow the nearest
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

#[derive(Debug, Serialize)]
struct OfGrid {
    name: &'static str,
    key: &'static str,
    settings: Setting,
    lines: Lines<Run>,
    #[serde(skip)]
    table: String,
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
        .publish("pareto", &results, &markdown(arguments, &results))
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
    let (key, name, ..) = option.parts();
    let names = contenders.iter().map(|contender| contender.name.clone());
    let mut lines = Lines::new("method", names.zip(packed).collect());
    lines.keep("proposals", contenders.iter().map(|one| &one.proposals));
    Ok(OfGrid {
        name,
        key,
        table: lines.table("proposals", &columns(true)),
        lines,
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
        document::figure(&folder, name, chart(grids).to_svg([900, 600]))
    };
    for grid in &results.grids {
        draw(&format!("pareto-{}", grid.key), std::slice::from_ref(grid))?;
    }
    draw("pareto", &results.grids)
}

fn chart(grids: &[OfGrid]) -> Scatter {
    scatter(
        "Mesh-volume compactness against decision time",
        [
            "Decision time per item (ms)",
            "Compactness of the meshes by the floor (%)",
        ],
        (["decision_s", "mesh_floor_compactness_percent"], 1e3),
        grids.iter().map(|grid| (grid.name, &grid.lines)),
    )
}

fn markdown(arguments: &ParetoArguments, results: &Results) -> String {
    let mut text = "# Decision time against packed volume\n\n".to_owned();
    if let Some(first) = results.grids.first() {
        text += &format!(
            "Sequences {} to {}, the same for every method; SDFM, {}; shares are of the exhaustive search (`all`) on the same grid, in this \
             run. Compactness is over the floor times the greatest height. {SHARE} {WIDENED}\n",
            arguments.sequences.first,
            arguments.sequences.last(),
            first.settings.in_words(results.workers),
        );
    }
    for OfGrid {
        name, key, table, ..
    } in &results.grids
    {
        text += &format!("\n## {name}\n\n{table}\n![{name}](pareto-{key}.svg)\n");
    }
    if let Some(reason) = &results.without_network {
        text += &format!("\nThe network is missing: {reason}.\n");
    }
    text + "\n## All grids\n\n![All grids](pareto.svg)\n"
}
