//! Options of the simulated cell.

use clap::Args;
use ppnpack_packing::grid::Grid;
use ppnpack_physics::packing_cell::Sampling;
use ppnpack_physics::settings::CellSettings;
use ppnpack_physics::view::CameraSettings;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::conditions::Conditions;
use super::file;
use super::view::ViewOptions;
use crate::failure::{OrInput, Outcome};

/// The simulated cell.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Simulated cell")]
pub struct PhysicsOptions {
    /// How items are released and seen; to pack, the defaults of grid, stability test and simulated check follow from it
    /// [default: robot to pack, reference in experiments]
    #[arg(long, value_enum)]
    conditions: Option<Conditions>,

    /// A TOML or JSON file with any settings of the simulated cell over those of the conditions, such as
    /// `settle_time_s` (the longest that items are given to settle), `release.height_m` or `contact.friction_combine`
    #[arg(long, value_name = "FILE", value_parser = parse_physics)]
    physics: Option<Value>,

    #[command(flatten)]
    view: ViewOptions,
}

fn parse_physics(path: &str) -> Result<Value, String> {
    let over: Value = file::settings(path)?;
    let settings = CellSettings::robot().overlaid(over.clone());
    settings.map_err(|error| error.to_string())?;
    Ok(over)
}

/// What a simulated cell is made with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Simulated {
    /// How the container is seen.
    pub scan: Sampling,
    /// The cameras that see it in place of that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraSettings>,
    /// Everything else.
    pub cell: CellSettings,
}

impl PhysicsOptions {
    /// The conditions that are asked for, else these.
    pub fn conditions(&self, default: Conditions) -> Conditions {
        self.conditions.unwrap_or(default)
    }

    /// The simulated cell for a grid, under these conditions unless others are asked for.
    ///
    /// # Errors
    /// Which setting is wrong.
    pub fn simulated(&self, grid: &Grid, seed: u64, default: Conditions) -> Outcome<Simulated> {
        let (scan, mut cell) = match self.conditions(default) {
            Conditions::Robot => (Sampling::Greatest, CellSettings::robot()),
            Conditions::Reference => (Sampling::Middle, CellSettings::default()),
        };
        if let Some(over) = &self.physics {
            cell = cell.overlaid(over.clone()).or_input()?;
        }
        cell.container = grid.container();
        cell.seed = seed;
        cell.validate().or_input()?;
        let camera = self.view.camera(seed);
        if let Some(camera) = &camera {
            camera.validate(cell.container).or_input()?;
        }
        Ok(Simulated {
            scan: self.view.scan().unwrap_or(scan),
            camera,
            cell,
        })
    }
}
