//! Options of the simulated cell: its conditions, and what is usual under them; its physics; what
//! sees it.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::lying;
use ppnpack_packing::kernel::grid::{Grid, GridSettings};
use ppnpack_packing::planning::method::{Method, SET_ASIDE};
use ppnpack_physics::packing_cell::{Sampling, SimulatedPackingCell};
use ppnpack_physics::settings::CellSettings;
use ppnpack_physics::view::CameraSettings;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::file;
use crate::failure::{Failure, OrInput, Outcome};

/// Conditions under which items are released and seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Conditions {
    /// Laid down from 1 cm, given 2 s to settle, every cell seen exactly
    Robot,
    /// The reference's: dropped from 12 cm, given the 0.375 s of the published code (the paper says
    /// 0.25 s), seen by a camera with one pixel per cell
    Reference,
}

impl Conditions {
    /// Gives the default grid.
    pub(crate) fn grid(self) -> GridSettings {
        match self {
            Self::Robot => GridSettings::default(),
            Self::Reference => GridSettings::from(&Grid::reference()),
        }
    }

    /// Gives the default method.
    pub(crate) fn method(self) -> Method {
        match self {
            Self::Robot => Method::default(),
            Self::Reference => Method::published(),
        }
    }

    /// Gives the default number of items that may be set aside.
    pub(crate) fn set_aside(self) -> usize {
        match self {
            Self::Robot => SET_ASIDE,
            Self::Reference => 0,
        }
    }
}

/// The simulated cell.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Simulated cell")]
pub struct PhysicsOptions {
    /// The conditions under which items are released and seen; to pack, the defaults of grid,
    /// stability test and simulated check follow from it [default: robot to pack, reference in
    /// experiments]
    #[arg(long, value_enum)]
    conditions: Option<Conditions>,

    /// A TOML or JSON file with any settings of the simulated cell over those of the conditions,
    /// such as `settle_time_s` (the longest that items are given to settle), `release.height_m`, or
    /// `taken`, boxes of the container that are not free; and `preloaded`, a CSV of what lies there
    /// from the start, such as another packing's `placements.csv`
    #[arg(long, value_name = "FILE", value_parser = parse_physics)]
    physics: Option<PhysicsFile>,

    /// The view of the container: `exact`, the greatest height in each cell; `middles`, the height
    /// at the middle of each, as a camera with one pixel per cell gives it; `camera`, a depth
    /// camera above with noise and dropouts; or by the cameras of a TOML file with `cameras` (1 or
    /// 2), `height_m`, `width_px`, `height_px` and `noise = { sigma_m, dropout, step_m }` [default:
    /// that of the conditions]
    #[arg(long, value_name = "VIEW|FILE", value_parser = parse_view)]
    view: Option<View>,
}

/// The content of a file of physics.
#[derive(Debug, Clone, Deserialize)]
struct PhysicsFile {
    /// Table of what lies in the container from the start.
    preloaded: Option<PathBuf>,
    /// Settings of the cell over those of the conditions.
    #[serde(flatten)]
    over: Value,
}

fn parse_physics(path: &str) -> Result<PhysicsFile, String> {
    let mut file: PhysicsFile = file::settings(path)?;
    let settings = CellSettings::robot().overlaid(file.over.clone());
    settings.map_err(|error| error.to_string())?;
    // The table is named as seen from the file.
    let folder = Path::new(path).parent().unwrap_or(Path::new(""));
    file.preloaded = file.preloaded.map(|table| folder.join(table));
    Ok(file)
}

/// Settings of a simulated cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Simulated {
    /// The way in which the container is seen.
    pub scan: Sampling,
    /// The cameras that see it in place of that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraSettings>,
    /// The table of what lies in the container from the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preloaded: Option<PathBuf>,
    /// Everything else.
    pub cell: CellSettings,
}

impl Simulated {
    /// Makes a cell with these physics, seen as is set, with nothing but what is preloaded; the seed
    /// of the physics is also that of the cameras.
    pub fn packing_cell(
        &self,
        physics: CellSettings,
        grid: &Grid,
        catalogue: &Catalogue,
    ) -> Outcome<SimulatedPackingCell> {
        let seed = physics.seed;
        let mut cell = SimulatedPackingCell::new(physics, grid, catalogue, self.scan).or_input()?;
        if let Some(path) = &self.preloaded {
            preload(&mut cell, path, catalogue)?;
        }
        let Some(camera) = self.camera else {
            return Ok(cell);
        };
        let camera = CameraSettings { seed, ..camera };
        cell.with_cameras(&camera).or_input()
    }
}

/// Lays down what a table has.
fn preload(cell: &mut SimulatedPackingCell, path: &Path, catalogue: &Catalogue) -> Outcome {
    let lying = lying::read(path, catalogue).or_input()?;
    cell.lay_down(&lying).or_input()?;
    let outside = cell.preloaded().find(|body| !body.inside);
    outside.map_or(Ok(()), |body| {
        let (path, name) = (path.display(), &body.model.name);
        Err(Failure::input(format_args!(
            "{path}: {name} does not lie in the container"
        )))
    })
}

impl PhysicsOptions {
    /// Gives the conditions that are asked for, else these.
    pub fn conditions(&self, default: Conditions) -> Conditions {
        self.conditions.unwrap_or(default)
    }

    /// Gives the simulated cell for a grid, under these conditions unless others are asked for.
    pub fn simulated(&self, grid: &Grid, seed: u64, default: Conditions) -> Outcome<Simulated> {
        let (usual, mut cell) = match self.conditions(default) {
            Conditions::Robot => (Sampling::Greatest, CellSettings::robot()),
            Conditions::Reference => (Sampling::Middle, CellSettings::default()),
        };
        let (scan, camera) = match self.view {
            Some(View::Cameras(camera)) => (usual, Some(CameraSettings { seed, ..camera })),
            Some(View::Scan(scan)) => (scan, None),
            None => (usual, None),
        };
        if let Some(file) = &self.physics {
            cell = cell.overlaid(file.over.clone()).or_input()?;
        }
        cell.container = grid.container();
        cell.seed = seed;
        cell.validate().or_input()?;
        if let Some(camera) = &camera {
            camera.validate(cell.container).or_input()?;
        }
        let preloaded = self.physics.as_ref();
        let preloaded = preloaded.and_then(|file| file.preloaded.clone());
        Ok(Simulated {
            scan,
            camera,
            preloaded,
            cell,
        })
    }
}

/// The view of the container.
#[derive(Debug, Clone, Copy, PartialEq)]
enum View {
    Scan(Sampling),
    Cameras(CameraSettings),
}

fn parse_view(text: &str) -> Result<View, String> {
    Ok(match text {
        "exact" => View::Scan(Sampling::Greatest),
        "middles" => View::Scan(Sampling::Middle),
        "camera" => View::Cameras(CameraSettings::default()),
        file => View::Cameras(file::settings(file).map_err(|error| {
            format!("none of exact, middles and camera, and no file of cameras: {error}")
        })?),
    })
}
