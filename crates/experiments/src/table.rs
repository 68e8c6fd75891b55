//! What the commands of the paper's tables and of its figure are told alike, and what is published beside their results.

use clap::Args;
use ppnpack_cli::failure::Outcome;
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::{Conditions, GridOptions};
use serde::Serialize;

use crate::comparison::{Comparison, ComparisonOptions};

/// What is packed, on which grid, and how results are printed.
#[derive(Debug, Args)]
pub(crate) struct TableOptions {
    #[command(flatten)]
    grid: GridOptions,

    #[command(flatten)]
    pub(crate) comparison: ComparisonOptions,

    /// Print the results as JSON instead of a table
    #[arg(long)]
    pub(crate) json: bool,
}

impl TableOptions {
    /// The comparison in the paper's conditions.
    pub(crate) fn comparison<'a>(&'a self, backend: &'a dyn Backend) -> Outcome<Comparison<'a>> {
        let grid = self.grid.grid(Conditions::Reference)?;
        Comparison::new(&self.comparison, backend, grid)
    }
}

/// What is published of a method; not all of it everywhere.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Published {
    /// For an item, in seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) decision_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) voxels_cm3: Option<f64>,
    pub(crate) compactness_percent: f64,
    pub(crate) items: f64,
}
