//! Options of the simulated cell.

use std::path::{Path, PathBuf};

use clap::Args;
use ppnpack_packing::grid::Grid;
use ppnpack_physics::packing_cell::Sampling;
use ppnpack_physics::settings::CellSettings;
use ppnpack_physics::view::CameraSettings;
use serde::{Deserialize, Serialize};

use super::choice::{Choice, one_of};
use super::conditions::Conditions;
use super::positive;
use super::view::ViewOptions;
use crate::failure::{Failure, OrInput, Outcome};
use crate::length::parse_distance;

/// The simulated cell.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Simulated cell")]
pub struct PhysicsOptions {
    /// How items are released and seen; to pack, the defaults of grid, stability test and simulated check follow from it
    /// [default: robot to pack, reference in experiments]
    #[arg(long, value_enum)]
    pub(crate) conditions: Option<Conditions>,

    /// How far above its planned height an item is released [default: that of the conditions]
    #[arg(long, value_name = "LENGTH", value_parser = parse_distance, allow_hyphen_values = true)]
    pub(crate) release_height: Option<f64>,

    /// The longest that items are given to settle after each placement, in seconds
    /// [default: that of the conditions]
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    pub settle: Option<f64>,

    /// How the container is seen [default: that of the conditions]
    #[arg(long, value_parser = one_of(&SCANS))]
    pub(crate) scan: Option<Sampling>,

    /// A JSON file with any settings of the simulated cell, over those of the conditions
    #[arg(long, value_name = "FILE")]
    pub(crate) physics: Option<PathBuf>,

    #[command(flatten)]
    view: ViewOptions,
}

const SCANS: [Choice<Sampling>; 2] = [
    (
        "exact",
        Sampling::Greatest,
        "The greatest height in each cell",
    ),
    (
        "camera",
        Sampling::Middle,
        "The height at the middle of each cell, as a camera with one pixel per cell gives it",
    ),
];

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
        let (scan, base) = match self.conditions(default) {
            Conditions::Robot => (Sampling::Greatest, CellSettings::robot()),
            Conditions::Reference => (Sampling::Middle, CellSettings::default()),
        };
        let mut cell = match &self.physics {
            Some(path) => with_file(&base, path)?,
            None => base,
        };
        cell.container = grid.container();
        cell.seed = seed;
        cell.release.height_m = self.release_height.unwrap_or(cell.release.height_m);
        cell.settle_time_s = self.settle.unwrap_or(cell.settle_time_s);
        cell.validate().or_input()?;
        let scan = self.scan.unwrap_or(scan);
        let camera = self.view.camera(seed);
        if let Some(camera) = &camera {
            camera.validate(cell.container).or_input()?;
        }
        Ok(Simulated { scan, camera, cell })
    }
}

/// Settings with those of a JSON file over them.
fn with_file(base: &CellSettings, path: &Path) -> Outcome<CellSettings> {
    let wrong = |error: &dyn std::fmt::Display| {
        Failure::input(format_args!("--physics {}: {error}", path.display()))
    };
    let text = std::fs::read_to_string(path).map_err(|error| wrong(&error))?;
    let file = serde_json::from_str(&text).map_err(|error| wrong(&error))?;
    base.overlaid(file).map_err(|error| wrong(&error))
}
