//! Several methods on the same sequences in one cell, as in the paper's tables and Pareto charts.

use std::path::Path;
use std::sync::Arc;

use clap::{Args, ValueEnum};
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::shape_class::ShapeClass;
use ppnpack_cli::failure::{OrInput, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::{CatalogueOptions, Conditions, PhysicsOptions, Simulated};
use ppnpack_model::weights::Model;
use ppnpack_packing::kernel::grid::{Grid, GridSettings};
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::planning::method::{ProposalSource, Stability};
use serde_json::{Value, json};

use crate::apart::Apart;
use crate::cases::Case;
use crate::network::{self, NetworkOptions};
use crate::packer::{Packer, sdfm};
use crate::results::with;
use crate::runs::RunsOptions;
use crate::way::Way;

/// Options of all comparisons.
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
    runs: RunsOptions,
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
    /// Gives the name of files, and that for readers.
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

#[derive(Clone)]
pub(crate) struct Comparison<'a> {
    pub(crate) options: &'a ComparisonOptions,
    backend: &'a dyn Backend,
    grid_settings: GridSettings,
    grid: Grid,
    simulated: Simulated,
    pub(crate) catalogue: Arc<Catalogue>,
    items: Vec<Arc<Item>>,
    network: NetworkOptions,
    /// Its model, or why none can be used here.
    model: Result<Model, String>,
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

    /// The same with objects of one class alone, and with the network of this file where given.
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

    /// Packs all sequences in a way, and gives the name of the folder of its runs. A killed
    /// comparison goes on with what is kept.
    pub(crate) fn pack(&self, experiment: &str, way: &Way, cases: &[Case]) -> Outcome<String> {
        let ComparisonOptions { seed, runs, .. } = self.options;
        let network = |model| self.network.of(self.backend, model, &self.items);
        let packer = Packer {
            way: way.clone(),
            grid: self.grid.clone(),
            catalogue: Arc::clone(&self.catalogue),
            simulated: self.simulated.clone(),
            apart: Apart::default(),
            network: self.model.as_ref().ok().map(network),
        };
        packer.pack_all(cases, *seed, runs, experiment)
    }

    pub(crate) fn publish(&self, name: &str, results: Value) -> Outcome {
        let ComparisonOptions { buffer, seed, .. } = self.options;
        let told = json!({
            "experiment": name,
            "grid": self.grid_settings,
            "simulated": self.simulated,
            "objects": self.catalogue.len(),
            "buffer": buffer,
            "seed": seed,
            "without_network": self.model.as_ref().err(),
        });
        let runs = &self.options.runs;
        runs.publish(name, with(told, results), "tables")
    }
}
