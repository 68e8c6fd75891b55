//! Options that `pack` and `up` share: the objects, the cell, the sequence and the results.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_files::StagedFolder;
use ppnpack_model::weights::Model;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::planning::method::Method;
use ppnpack_robot::station::{ArmStation, StationSettings};

use crate::failure::Outcome;
use crate::network::Backend;
use crate::options::{
    CatalogueOptions, Conditions, GridOptions, MethodOptions, PhysicsOptions, Simulated,
};
use crate::output::{print_json, print_line};
use crate::report::{self, ArmWork, MethodWithArm, PAGE_FILE, Packing, Settings};
use crate::sequence::{Sequence, SequenceOptions};

/// Valid placements kept beside each choice, for the report.
pub(super) const ALTERNATIVES: u8 = 3;

/// Objects, container, method and simulated cell.
#[derive(Debug, Args)]
pub(super) struct CellOptions {
    #[command(flatten)]
    pub(super) catalogue: CatalogueOptions,

    #[command(flatten)]
    grid: GridOptions,

    #[command(flatten)]
    pub(super) method: MethodOptions,

    #[command(flatten)]
    physics: PhysicsOptions,
}

/// The same, checked and prepared.
pub(super) struct CellSetUp {
    conditions: Conditions,
    pub(super) grid: Grid,
    pub(super) method: Method,
    pub(super) arm: Option<StationSettings>,
    pub(super) station: Option<ArmStation>,
    pub(super) simulated: Simulated,
    pub(super) model: Option<Model>,
}

impl CellOptions {
    /// Checks what was asked for; before a network is needed, `backend` prepares for it where it
    /// runs here.
    pub(super) fn set_up(&self, backend: &dyn Backend, runs_here: bool) -> Outcome<CellSetUp> {
        let conditions = self.physics.conditions(Conditions::Robot);
        let grid = self.grid.grid(conditions)?;
        let proposals = &self.method.proposals;
        if proposals.uses_network() && runs_here {
            backend.prepare();
        }
        let model = proposals.read_model()?;
        let source = proposals.source(&grid, model.as_ref());
        let poses = self.catalogue.poses;
        let method = self.method.method(source, conditions, poses)?;
        let (arm, station) = self.method.arm.station()?.unzip();
        Ok(CellSetUp {
            conditions,
            simulated: self.physics.simulated(&grid, method.seed, conditions)?,
            grid,
            method,
            arm,
            station,
            model,
        })
    }

    /// Loads the objects of these names, or all where there are none, on the cell's grid.
    pub(super) fn load(&self, cell: &CellSetUp, names: &[String]) -> Outcome<Arc<Catalogue>> {
        let resolution = cell.grid.resolution();
        // What is preloaded is not known before the objects are.
        let is_empty = cell.simulated.preloaded.is_none();
        let names = if is_empty { names } else { &[] };
        Ok(Arc::new(self.catalogue.load_only(names, resolution)?))
    }
}

/// The sequence to pack.
#[derive(Debug, Args)]
#[command(next_help_heading = "Sequence")]
pub(super) struct JobOptions {
    #[command(flatten)]
    sequence: SequenceOptions,

    /// How many items that fit nowhere may be set aside for the next container; the packing then
    /// goes on with the next ones [default: 20 under robot conditions, 0 under the reference's]
    #[arg(long, value_name = "COUNT")]
    set_aside: Option<u32>,

    #[command(flatten)]
    results: ResultOptions,
}

impl JobOptions {
    /// Checks that the results can be written, before anything is packed; gives the names of the
    /// only objects that are needed, where they are known.
    pub(super) fn begin(&self) -> Outcome<&[String]> {
        StagedFolder::check(&self.results.out)?;
        Ok(self.sequence.names())
    }

    /// Gives everything that the packing depends on, and the arm's part in it: what the arm cannot
    /// hold or lift is no longer in the sequence.
    pub(super) fn settings(
        &self,
        options: &CellOptions,
        cell: &CellSetUp,
        catalogue: &Catalogue,
    ) -> Outcome<(Settings, Option<ArmWork>)> {
        let mut sequence: Sequence = self.sequence.sequence(catalogue, cell.method.seed)?;
        let station = cell.station.as_ref();
        let arm = station.map(|station| ArmWork::new(station, &mut sequence, catalogue));
        let usual = cell.conditions.set_aside();
        let settings = Settings {
            catalogue: options.catalogue.catalogue.clone(),
            catalogue_hash: catalogue.content_hash(),
            objects: catalogue.len(),
            poses: options.catalogue.poses,
            sequence,
            set_aside: self.set_aside.map_or(usual, |limit| limit as usize),
            grid: cell.grid.clone(),
            method: MethodWithArm {
                method: cell.method.clone(),
                arm: cell.arm.clone(),
            },
            simulated: cell.simulated.clone(),
        };
        Ok((settings, arm))
    }

    /// Writes the report and prints the summary.
    pub(super) fn publish(&self, packing: &Packing) -> Outcome {
        let ResultOptions { out, json } = &self.results;
        let summary = packing.summary();
        report::write(packing, &summary, out, None)?;
        if *json {
            return Ok(print_json(&summary)?);
        }
        let (table, page) = (summary.table()?, out.join(PAGE_FILE));
        Ok(print_line(&format!("{table}Report: {}", page.display()))?)
    }
}

/// Destination of the results of a packed sequence.
#[derive(Debug, Args)]
#[command(next_help_heading = "Results")]
struct ResultOptions {
    /// The folder of the results
    #[arg(long, value_name = "DIR", default_value = "out/pack")]
    out: PathBuf,

    /// Print the summary as JSON instead of a table
    #[arg(long)]
    json: bool,
}
