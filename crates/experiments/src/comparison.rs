//! Several methods on the same sequences, in one cell: what the paper's tables, its figure and the Pareto charts have in common.

use std::path::Path;
use std::sync::Arc;

use clap::{Args, ValueEnum};
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::shape_class::ShapeClass;
use ppnpack_cli::failure::{OrInput, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::{CatalogueOptions, Conditions, Network, PhysicsOptions, Simulated};
use ppnpack_model::weights::Model;
use ppnpack_packing::grid::{Grid, GridSettings};
use ppnpack_packing::item::Item;
use ppnpack_packing::method::{ProposalSource, Stability};
use ppnpack_physics::view::CameraSettings;

use crate::apart::Apart;
use crate::cases::Case;
use crate::document::{self, Page};
use crate::network::{self, NetworkOptions};
use crate::packer::{Packer, Run, sdfm};
use crate::runs::RunsOptions;
use crate::sheet::{Cell, Column};
use crate::statistics::Mean;
use crate::way::Way;

/// A column of this experiment's tables.
type Measured = Column<Run>;

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

    /// The seed of everything that is random
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    pub(crate) seed: u64,

    #[command(flatten)]
    pub(crate) runs: RunsOptions,
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
    /// What files are named by, and what readers see.
    pub(crate) fn names(self) -> [&'static str; 2] {
        match self {
            Self::Coarse => ["coarse", "1 cm, 4 yaws"],
            Self::Medium => ["medium", "5 mm, 8 yaws"],
            Self::Fine => ["fine", "2.5 mm, 16 yaws"],
        }
    }

    pub(crate) fn settings(self) -> GridSettings {
        let (cell_m, yaws) = match self {
            Self::Coarse => (0.01, 4),
            Self::Medium => (0.005, 8),
            Self::Fine => (0.0025, 16),
        };
        GridSettings {
            cell_m,
            yaws,
            ..GridSettings::default()
        }
    }
}

/// A comparison that is set up: on one grid, in one cell.
#[derive(Clone)]
pub(crate) struct Comparison<'a> {
    pub(crate) options: &'a ComparisonOptions,
    backend: &'a dyn Backend,
    grid_settings: GridSettings,
    pub(crate) grid: Grid,
    simulated: Simulated,
    pub(crate) catalogue: Arc<Catalogue>,
    /// The items that the network is told of ahead of time.
    items: Vec<Arc<Item>>,
    /// The network that proposes.
    network: NetworkOptions,
    /// Its model, or why none can be used here.
    pub(crate) model: Result<Model, String>,
}

impl<'a> Comparison<'a> {
    pub(crate) fn new(
        options: &'a ComparisonOptions,
        backend: &'a dyn Backend,
        grid_settings: GridSettings,
    ) -> Outcome<Self> {
        let grid = grid_settings.build().or_input()?;
        let (physics, seed) = (&options.physics, options.seed);
        let simulated = physics.simulated(&grid, seed, Conditions::Reference)?;
        let catalogue = options.catalogue.load(grid.resolution())?;
        let network = options.network.clone();
        Ok(Self {
            model: network.find(backend, &grid)?,
            items: catalogue.items(),
            catalogue: Arc::new(catalogue),
            options,
            backend,
            grid_settings,
            grid,
            simulated,
            network,
        })
    }

    /// The same with the objects of one class alone, and with the network of this file where one is given.
    pub(crate) fn of_class(&self, class: ShapeClass, network: Option<&Path>) -> Outcome<Self> {
        let catalogue = self.catalogue.of_class(class);
        let network = self.options.network.with_file(network);
        Ok(Self {
            items: catalogue.items(),
            catalogue: Arc::new(catalogue),
            model: network.find(self.backend, &self.grid)?,
            network,
            ..self.clone()
        })
    }

    /// SDF minimisation by a source of proposals.
    pub(crate) fn way(&self, name: String, proposals: ProposalSource) -> Way {
        let (options, buffer) = (self.options, self.options.buffer as usize);
        Way {
            name,
            grid: self.grid_settings,
            poses: options.catalogue.settings().poses,
            set_aside: 0,
            method: sdfm(proposals, Stability::Published, buffer, options.seed),
            ..Way::default()
        }
    }

    /// The network's proposals of so many percent, where it can be used.
    pub(crate) fn proposals(&self, percent: f64) -> Option<ProposalSource> {
        let model = self.model.as_ref().ok()?;
        Some(network::source(&self.grid, percent, model))
    }

    pub(crate) fn packer(&self, way: &Way) -> Packer<'_> {
        let network = self.model.as_ref().ok();
        Packer {
            way: way.clone(),
            grid: self.grid.clone(),
            catalogue: Arc::clone(&self.catalogue),
            simulated: self.simulated.clone(),
            apart: Apart::default(),
            network: network.map(|model| self.network(model)),
        }
    }

    fn network<'m>(&'m self, model: &'m Model) -> Network<'m> {
        self.network.of(self.backend, model, &self.items)
    }

    /// Packs all sequences in all ways; gives the runs by way, then sequence. A killed comparison goes on with what is kept.
    pub(crate) fn pack(
        &self,
        name: &str,
        ways: &[Way],
        cases: &[Case],
    ) -> Outcome<Vec<(String, Vec<Run>)>> {
        let ComparisonOptions { seed, runs, .. } = self.options;
        let pack = |way: &Way| {
            let packed = self.packer(way).pack_all(cases, *seed, runs, name)?;
            Ok((way.name.clone(), packed))
        };
        ways.iter().map(pack).collect()
    }

    /// A page that says how sequences were packed.
    pub(crate) fn page(&self, name: &str, head: &str) -> Page {
        let mut page = Page::new(name, format!("{head} {}\n", self.in_words()));
        let workers = self.options.runs.workers();
        page.keep("grid", self.grid_settings);
        page.keep("simulated", &self.simulated);
        page.keep("objects", self.catalogue.len());
        page.keep("workers", workers);
        page.say(&self.missing());
        if let Err(reason) = &self.model {
            page.keep("without_network", reason);
        }
        page
    }

    fn in_words(&self) -> String {
        let (grid, options) = (&self.grid, self.options);
        let container = grid.container();
        let [x_cm, y_cm, z_cm] =
            [container.x_m, container.y_m, container.z_m].map(|side_m| side_m * 100.0);
        format!(
            "Container {x_cm:.0} x {y_cm:.0} x {z_cm:.0} cm, {} x {} cells, {} yaws, buffer {}, published stability test, {} scan; {} \
             sequences at once, each on one core. Intervals are 95 % confidence intervals over the sequences, by Student's t.\n\n\
             {TERMS}",
            grid.nx(),
            grid.ny(),
            grid.resolution().yaws().count(),
            options.buffer,
            match &self.simulated.camera {
                Some(CameraSettings { cameras: 1, .. }) => "one camera in place of a".to_owned(),
                Some(_) => "two cameras in place of a".to_owned(),
                None => document::name_of(&self.simulated.scan),
            },
            options.runs.workers(),
        )
    }

    /// Why the network's rows are missing, where they are, as a paragraph.
    fn missing(&self) -> String {
        let reason = self.model.as_ref().err();
        reason.map_or_else(String::new, |reason| {
            format!("\nThe network is missing: {reason}.\n")
        })
    }
}

/// What is said of each method; the stages of its decisions, too, where they are to be shown.
pub(crate) fn columns(has_stages: bool) -> Vec<Measured> {
    let stage = |key, head, value: fn(&Run) -> f64| match has_stages {
        true => Measured::mean_ms(key, head, value),
        false => Measured::mean_ms(key, head, value).hidden(),
    };
    let ratio = |key, head, value: fn(&Run) -> f64| {
        Measured::compared(key, head, move |runs: &[Run], others: &[Run]| {
            Cell::mean(ratio_percent(runs, others, value), 1)
        })
    };
    let percent = |key, head, value: fn(&Run) -> f64| {
        Measured::mean(key, head, 1, move |run| 100.0 * value(run))
    };
    let mut columns = vec![
        Measured::sum("cases", "", |_| 1).hidden(),
        Measured::mean_ms("decision_s", "decision per item", Run::mean_decision_s),
        stage("propose_s", "proposing", |run| run.propose_s),
        stage("evaluate_s", "evaluating", |run| run.evaluate_s),
        stage("check_s", "checking", |run| run.check_s),
        Measured::mean("items", "items packed", 1, |run| run.items as f64),
        Measured::mean("voxels_cm3", "voxel volume (cm³)", 0, |run| {
            run.voxels_m3 * 1e6
        }),
        percent(
            "floor_compactness_percent",
            "compactness by floor (%)",
            |run| run.floor_compactness,
        ),
        percent("box_compactness_percent", "compactness by box (%)", |run| {
            run.box_compactness
        }),
        Measured::mean("meshes_cm3", "mesh volume (cm³)", 0, Run::meshes_cm3),
        percent(
            "mesh_floor_compactness_percent",
            "mesh compactness by floor (%)",
            |run| run.mesh_floor_compactness,
        ),
        Measured::mean("height_m", "", 3, |run: &Run| run.height_m).hidden(),
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
        Measured::sum("steps", "", |run| run.placed).hidden(),
        Measured::sum("steps_widened", "", |run: &Run| run.steps_widened).hidden(),
        Measured::share("steps_widened_percent", "steps widened", |run| {
            [run.steps_widened, run.placed]
        }),
    ];
    if has_stages {
        columns.push(ratio("decision_ratio_percent", "of its time (%)", |run| {
            run.mean_decision_s()
        }));
    }
    columns
}

/// The sum of a value over some runs divided by the sum over others on the same sequences, in percent. The interval
/// is that of a ratio of paired means (by the differences to the ratio's line).
fn ratio_percent(runs: &[Run], others: &[Run], value: fn(&Run) -> f64) -> Mean {
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

/// What the tables say of their terms.
const TERMS: &str = "Compactness is the volume of the packed items over the floor times the greatest height, \
    after the paper's published code, whose scan is from before the last placement, or over the minimum bounding box of what was packed, \
    as in its text. K is a share of all placements: as many are proposed, but none that does not fit. A step is widened to an exhaustive \
    search where none of its proposals is valid.";

/// What is said of steps that were widened.
pub(crate) const WIDENED: &str =
    "A step is widened to an exhaustive search where none of its proposals is valid.";

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
