//! Several methods on the same sequences, in one cell: what the paper's tables, its figure and the Pareto charts have in common.

use std::path::Path;
use std::sync::Arc;

use clap::Args;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::shape_class::ShapeClass;
use ppnpack_chart::{Interval, PlotPoint};
use ppnpack_cli::failure::Outcome;
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::{
    CatalogueOptions, Conditions, Network, PhysicsOptions, Simulated, parse_stability,
};
use ppnpack_cli::simulation::simulate;
use ppnpack_model::weights::Model;
use ppnpack_packing::episode::{Episode, Play};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::item::Item;
use ppnpack_packing::method::{Method, OpenNetwork, ProposalSource, Stability};
use ppnpack_packing::objective::{Heuristic, Order};
use ppnpack_packing::plan::Timings;
use ppnpack_physics::packing_cell::SimulatedPackingCell;
use ppnpack_physics::view::CameraSettings;
use serde::{Deserialize, Serialize};

use crate::cases::Case;
use crate::document;
use crate::method::{cell_for, sdfm};
use crate::network::NetworkOptions;
use crate::runs::{Runs, RunsOptions, hash};
use crate::sheet::{Cell, Column};
use crate::statistics::Mean;

/// A column of the tables.
pub(crate) type Measured<'a> = Column<'a, Run>;

/// What all comparisons are told.
#[derive(Debug, Args)]
pub(crate) struct ComparisonOptions {
    #[command(flatten)]
    catalogue: CatalogueOptions,

    #[command(flatten)]
    physics: PhysicsOptions,

    #[command(flatten)]
    pub(crate) network: NetworkOptions,

    /// How many items the robot may choose among
    #[arg(long, value_name = "COUNT", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    buffer: u32,

    /// The stability test that placements must pass
    #[arg(long, value_parser = parse_stability(), default_value = "published")]
    stability: Stability,

    /// The seed of everything that is random
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    pub(crate) seed: u64,

    #[command(flatten)]
    pub(crate) runs: RunsOptions,
}

/// What all runs of a comparison share.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Setting {
    pub(crate) catalogue_hash: String,
    pub(crate) grid: Grid,
    pub(crate) simulated: Simulated,
    pub(crate) buffer: usize,
    pub(crate) stability: Stability,
    pub(crate) seed: u64,
}

/// A comparison that is set up: on one grid, in one cell.
pub(crate) struct Comparison<'a> {
    options: &'a ComparisonOptions,
    backend: &'a dyn Backend,
    pub(crate) setting: Setting,
    pub(crate) catalogue: Catalogue,
    /// The network's model, or why none can be used here.
    pub(crate) model: Result<Model, String>,
}

/// A row of one of the paper's tables.
pub(crate) struct Row {
    /// What it is asked for by.
    pub(crate) key: &'static str,
    pub(crate) name: &'static str,
    pub(crate) heuristic: Heuristic,
    pub(crate) order: Order,
    /// Where its proposals come from.
    pub(crate) proposals: RowProposals,
    /// What the paper reports: seconds, cm³, percent, items.
    pub(crate) paper: Option<[f64; 4]>,
}

/// Where the proposals of a row come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RowProposals {
    /// All placements are searched.
    All,
    /// The network proposes.
    Network,
    /// A few are tried.
    Tries,
}

#[derive(Debug, Clone, Serialize)]
pub(crate) struct Contender {
    pub(crate) name: String,
    pub(crate) heuristic: Heuristic,
    pub(crate) order: Order,
    pub(crate) proposals: ProposalSource,
}

/// One packed sequence.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Run {
    pub(crate) objects: Vec<usize>,
    /// Mean decision time per packed item, in seconds.
    pub(crate) decision_s: f64,
    /// The same by stage.
    pub(crate) propose_s: f64,
    pub(crate) evaluate_s: f64,
    pub(crate) check_s: f64,
    pub(crate) items: usize,
    pub(crate) placed: usize,
    /// Of the steps that placed them: searched exhaustively, as none of their proposals was valid.
    pub(crate) steps_widened: usize,
    pub(crate) voxels_m3: f64,
    pub(crate) meshes_m3: f64,
    pub(crate) floor_compactness: f64,
    pub(crate) box_compactness: f64,
    pub(crate) mesh_floor_compactness: f64,
    pub(crate) height_m: f64,
}

impl<'a> Comparison<'a> {
    pub(crate) fn new(
        options: &'a ComparisonOptions,
        backend: &'a dyn Backend,
        grid: Grid,
    ) -> Outcome<Self> {
        let (physics, seed) = (&options.physics, options.seed);
        let simulated = physics.simulated(&grid, seed, Conditions::Reference)?;
        let catalogue = options.catalogue.load(grid.resolution())?;
        Ok(Self {
            model: options.network.find(backend, &grid)?,
            setting: Setting {
                catalogue_hash: catalogue.content_hash(),
                grid,
                simulated,
                buffer: options.buffer as usize,
                stability: options.stability,
                seed,
            },
            catalogue,
            options,
            backend,
        })
    }

    /// The same with the objects of one class alone, and with the network of this file where one is given.
    pub(crate) fn of_class(&self, class: ShapeClass, network: Option<&Path>) -> Outcome<Self> {
        let mut setting = self.setting.clone();
        let catalogue = self.catalogue.of_class(class);
        setting.catalogue_hash = catalogue.content_hash();
        let options = self.options.network.with_file(network);
        Ok(Self {
            options: self.options,
            backend: self.backend,
            model: options.find(self.backend, &setting.grid)?,
            setting,
            catalogue,
        })
    }

    pub(crate) fn without_network(&self) -> Option<String> {
        self.model.as_ref().err().cloned()
    }

    /// The rows of a table and their methods, but for the network's where that cannot be used.
    pub(crate) fn contenders<'r>(
        &self,
        rows: impl IntoIterator<Item = &'r Row>,
    ) -> (Vec<&'r Row>, Vec<Contender>) {
        let rows = rows.into_iter();
        rows.filter_map(|row| Some((row, self.contender(row)?)))
            .unzip()
    }

    fn contender(&self, row: &Row) -> Option<Contender> {
        let network = &self.options.network;
        let (name, proposals) = match (row.proposals, &self.model) {
            (RowProposals::All, _) => (row.name.to_owned(), ProposalSource::All),
            (RowProposals::Tries, _) => (row.name.to_owned(), ProposalSource::PUBLISHED_TRIES),
            (RowProposals::Network, Ok(model)) => (
                format!("{} (K = {} %)", row.name, network.percent()),
                network.source(&self.setting.grid, model),
            ),
            (RowProposals::Network, Err(_)) => return None,
        };
        Some(Contender {
            name,
            heuristic: row.heuristic,
            order: row.order,
            proposals,
        })
    }

    /// Why the network's rows are missing, where they are, as a paragraph.
    pub(crate) fn missing(&self) -> String {
        let reason = self.model.as_ref().err();
        reason.map_or_else(String::new, |reason| {
            format!("\nPPN-Pack is missing: {reason}.\n")
        })
    }

    /// The network with the items that it is asked about, where it can be used.
    pub(crate) fn network<'i>(&'i self, items: &'i [Arc<Item>]) -> Option<Network<'i>> {
        let model = self.model.as_ref().ok()?;
        Some(self.options.network.of(self.backend, model, items))
    }

    /// Packs all sequences with all methods, those first that come first; gives the runs by method, then sequence. A killed comparison
    /// goes on with what is kept.
    pub(crate) fn pack(
        &self,
        contenders: &[Contender],
        cases: &[Case],
        kept: &Path,
    ) -> Outcome<Vec<Vec<Run>>> {
        let kept = Runs::new(kept, &self.setting)?;
        let items = self.catalogue.items();
        let network = self.network(&items);
        let jobs = cases
            .iter()
            .flat_map(|case| contenders.iter().map(move |contender| (case, contender)));
        let jobs: Vec<(&Case, &Contender)> = jobs.collect();
        let pack = |(case, contender): &(&Case, &Contender)| {
            let is_right = |run: &Run| run.objects == case.sequence.objects;
            kept.finish(&name(contender, case.number)?, is_right, || {
                self.pack_one(contender, case, network)
            })
        };
        let done = self.options.runs.make(&jobs, pack)?;
        let of_contender = |at| done.iter().skip(at).step_by(contenders.len()).cloned();
        let by_contender = (0..contenders.len()).map(|at| of_contender(at).collect());
        Ok(by_contender.collect())
    }

    /// Packs one sequence with one method; gives the episode and the cell as it was left.
    pub(crate) fn simulate(
        &self,
        contender: &Contender,
        Case { number, sequence }: &Case,
        network: Option<Network<'_>>,
    ) -> Outcome<(Episode, SimulatedPackingCell)> {
        let setting = &self.setting;
        let seed = setting.seed.wrapping_add(u64::from(*number));
        let proposals = contender.proposals.clone();
        let method = Method {
            heuristic: contender.heuristic,
            order: contender.order,
            ..sdfm(proposals, setting.stability, setting.buffer, seed)
        };
        let mut simulated = setting.simulated.clone();
        simulated.cell.seed = method.seed;
        let network = network.as_ref().map(|network| network as &dyn OpenNetwork);
        let mut planner = method.build(&setting.grid, network)?;
        let cell = cell_for(&method, &self.catalogue, &setting.grid, &simulated)?;
        simulate(
            &self.catalogue,
            &setting.grid,
            sequence,
            cell,
            &mut planner,
            Play::with_buffer(method.buffer),
            &mut (),
        )
    }

    fn pack_one(
        &self,
        contender: &Contender,
        case: &Case,
        network: Option<Network<'_>>,
    ) -> Outcome<Run> {
        let setting = &self.setting;
        let (episode, _) = self.simulate(contender, case, network)?;
        let height = episode.scene.heightmap().max();
        let steps = &episode.steps;
        let mean = |stage: fn(&Timings) -> std::time::Duration| {
            let total: std::time::Duration = steps.iter().map(|step| stage(&step.timings)).sum();
            total.as_secs_f64() / steps.len().max(1) as f64
        };
        Ok(Run {
            objects: case.sequence.objects.clone(),
            decision_s: episode.mean_decision_s(),
            propose_s: mean(|timings| timings.propose),
            evaluate_s: mean(|timings| timings.evaluate),
            check_s: mean(|timings| timings.check),
            items: episode.metrics.packed.items,
            placed: steps.len(),
            steps_widened: episode.steps_widened(),
            voxels_m3: episode.metrics.packed.voxels_m3,
            meshes_m3: episode.metrics.packed.meshes_m3,
            floor_compactness: episode.metrics.floor_compactness,
            box_compactness: episode.metrics.box_compactness,
            mesh_floor_compactness: episode.metrics.mesh_floor_compactness,
            height_m: f64::from(height) * setting.grid.resolution().height_unit_m(),
        })
    }
}

impl Setting {
    /// How sequences were packed, in words; `workers` at once.
    pub(crate) fn in_words(&self, workers: usize) -> String {
        format!(
            "buffer {}, {} stability test, {} scan; {workers} sequences at once, each on one core. Intervals are 95 % confidence \
             intervals over the sequences, by Student's t",
            self.buffer,
            document::name_of(&self.stability),
            match &self.simulated.camera {
                Some(CameraSettings { cameras: 1, .. }) => "one camera in place of a".to_owned(),
                Some(_) => "two cameras in place of a".to_owned(),
                None => document::name_of(&self.simulated.scan),
            },
        )
    }

    pub(crate) fn cells_in_words(&self) -> String {
        let grid = &self.grid;
        let yaws = grid.resolution().yaws().count();
        format!("{} x {} cells, {yaws} yaws", grid.nx(), grid.ny())
    }
}

/// What is said of each method; the stages of its decisions, too, where they are to be shown.
pub(crate) fn columns(has_stages: bool) -> Vec<Measured<'static>> {
    let stage = |key, head, value: fn(&Run) -> f64| {
        Measured::mean_ms(key, head, value).shown_if(has_stages)
    };
    let ratio = |key, head, value: fn(&Run) -> f64| {
        Measured::new(key, head, move |runs: &[Run], others: &[Run]| {
            Cell::mean(ratio_percent(runs, others, value), 1)
        })
    };
    let percent = |key, head, value: fn(&Run) -> f64| {
        Measured::mean(key, head, 1, move |run| 100.0 * value(run))
    };
    let cm3 = |key, head, value: fn(&Run) -> f64| {
        Measured::mean(key, head, 0, move |run| 1e6 * value(run))
    };
    let mut columns = vec![
        Measured::sum("cases", "", |_| 1).shown_if(false),
        Measured::mean_ms("decision_s", "decision per item", |run| run.decision_s),
        stage("propose_s", "proposing", |run| run.propose_s),
        stage("evaluate_s", "evaluating", |run| run.evaluate_s),
        stage("check_s", "checking", |run| run.check_s),
        Measured::mean("items", "items packed", 1, |run| run.items as f64),
        cm3("voxels_cm3", "voxel volume (cm³)", |run| run.voxels_m3),
        percent(
            "floor_compactness_percent",
            "compactness by floor (%)",
            |run| run.floor_compactness,
        ),
        percent("box_compactness_percent", "compactness by box (%)", |run| {
            run.box_compactness
        }),
        cm3("meshes_cm3", "mesh volume (cm³)", |run| run.meshes_m3),
        percent(
            "mesh_floor_compactness_percent",
            "mesh compactness by floor (%)",
            |run| run.mesh_floor_compactness,
        ),
        Measured::mean("height_m", "", 3, |run: &Run| run.height_m).shown_if(false),
        ratio(
            "floor_compactness_ratio_percent",
            "share of the search's compactness (%)",
            |run| run.floor_compactness,
        ),
        ratio(
            "mesh_volume_ratio_percent",
            "of its mesh volume (%)",
            |run| run.meshes_m3,
        ),
        Measured::mean("fallen_out", "fell out", 2, |run| {
            (run.placed - run.items) as f64
        }),
        Measured::sum("steps", "", |run| run.placed).shown_if(false),
        Measured::sum("steps_widened", "", |run: &Run| run.steps_widened).shown_if(false),
        Measured::share("steps_widened_percent", "steps widened", |run| {
            [run.steps_widened, run.placed]
        }),
    ];
    if has_stages {
        columns.push(ratio("decision_ratio_percent", "of its time (%)", |run| {
            run.decision_s
        }));
    }
    columns
}

/// The sum of a value over some runs divided by the sum over others on the same sequences, in percent. The interval
/// is that of a ratio of paired means (by the differences to the ratio's line).
pub(crate) fn ratio_percent(runs: &[Run], others: &[Run], value: fn(&Run) -> f64) -> Mean {
    let sum = |runs: &[Run]| runs.iter().map(value).sum::<f64>();
    let (ours, theirs) = (sum(runs), sum(others));
    if theirs <= 0.0 {
        return Mean::default();
    }
    let ratio = ours / theirs;
    let pairs = runs.iter().zip(others);
    let deviation = Mean::of(pairs.map(|(run, other)| value(run) - ratio * value(other)));
    let scale = runs.len() as f64 / theirs;
    Mean {
        mean: 100.0 * ratio,
        half_width: 100.0 * deviation.half_width * scale,
    }
}

/// What the tables say of compactness.
pub(crate) const COMPACTNESS: &str = "Compactness is the volume of the packed items over the floor times the greatest height, \
    after the paper's published code, whose scan is from before the last placement, or over the minimum bounding box of what was packed, as in its text.";

/// What the tables say of the share K.
pub(crate) const SHARE: &str =
    "K is a share of all placements: as many are proposed, but none that does not fit.";

/// What the tables say of steps that were widened.
pub(crate) const WIDENED: &str =
    "A step is widened to an exhaustive search where none of its proposals is valid.";

/// A point of a chart, with both intervals.
pub(crate) fn point(label: &str, x: &Mean, y: &Mean) -> PlotPoint {
    let interval = |mean: &Mean| Interval {
        low: mean.mean - mean.half_width,
        high: mean.mean + mean.half_width,
    };
    PlotPoint {
        label: label.to_owned(),
        x: x.mean,
        y: y.mean,
        x_interval: Some(interval(x)),
        y_interval: Some(interval(y)),
    }
}

/// The name of a run's file: readable, and another one for another method.
fn name(contender: &Contender, case: u32) -> Outcome<String> {
    let letters = contender.name.to_ascii_lowercase();
    let letters = letters.replace(|letter: char| !letter.is_ascii_alphanumeric(), "-");
    Ok(format!("{letters}-{}-{case:05}", hash(contender, 8)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(meshes_m3: f64) -> Run {
        Run {
            meshes_m3,
            ..Run::default()
        }
    }

    #[test]
    fn a_ratio_of_proportional_runs_is_certain() {
        let others = [run(1.0), run(2.0), run(4.0)];
        let halves = [run(0.5), run(1.0), run(2.0)];
        let ratio = ratio_percent(&halves, &others, |run| run.meshes_m3);
        assert!((ratio.mean - 50.0).abs() < 1e-9 && ratio.half_width < 1e-9);
        let uneven = [run(0.9), run(1.0), run(1.6)];
        let ratio = ratio_percent(&uneven, &others, |run| run.meshes_m3);
        assert!((ratio.mean - 50.0).abs() < 1e-9 && ratio.half_width > 1.0);
        let none = ratio_percent(&[], &[], |run| run.meshes_m3);
        assert_eq!(none, Mean::default());
    }
}
