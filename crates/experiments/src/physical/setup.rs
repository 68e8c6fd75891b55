//! Setup of runs: the container, the objects, the cell.

use ppnpack_bridge::simulated::FaultSettings;
use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::catalogue::{self, Catalogue, Source};
use ppnpack_packing::kernel::grid::{ContainerSize, Grid, GridSettings, Resolution};
use ppnpack_perception::doubts::DoubtSettings;
use ppnpack_perception::settings::MapperSettings;
use ppnpack_physics::settings::CellSettings;
use ppnpack_physics::view::CameraSettings;
use ppnpack_robot::arms;
use ppnpack_robot::station::StationSettings;
use serde::{Deserialize, Serialize};

use super::PhysicalArguments;
use ppnpack_cli::failure::{Failure, OrInput, Outcome};
use ppnpack_cli::options;

/// The container of the paper's robot cell.
const CONTAINER: ContainerSize = ContainerSize::cuboid(0.30, 0.30, 0.16);

pub(super) const KNOWN_COUNT: u32 = 1;

const BUFFER: usize = 2;

/// Standard deviation of release along each axis; in yaw as much as moves a point 10 cm away by it.
const PLACEMENT_NOISE_M: f64 = 0.002;

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Settings {
    pub(super) grid: GridSettings,
    pub(super) catalogue_hash: String,
    pub(super) unseen: usize,
    pub(super) unseen_count: u32,
    pub(super) known_count: u32,
    pub(super) strangers: bool,
    pub(super) arm: Option<StationSettings>,
    pub(super) simulated: CellSettings,
    pub(super) faults: FaultSettings,
    pub(super) camera: CameraSettings,
    pub(super) mapper: MapperSettings,
    pub(super) buffer: usize,
    pub(super) seed: u64,
}

/// Makes the grid of the paper's container, as finely as is asked for.
pub(super) fn grid(arguments: &PhysicalArguments) -> Outcome<Grid> {
    let settings = GridSettings {
        container: CONTAINER,
        cell_m: arguments.cell,
        yaws: arguments.yaws,
        ..GridSettings::default()
    };
    settings.build().or_input()
}

/// The unseen objects, then the others; how many are unseen.
pub(super) fn catalogue(
    arguments: &PhysicalArguments,
    resolution: &Resolution,
) -> Outcome<(Catalogue, usize)> {
    let settings = catalogue::Settings {
        cache: CacheDir::User,
        ..catalogue::Settings::default()
    };
    let load = |source: &Source| options::load(source, &settings, resolution);
    let mut all = load(&Source::Folder(arguments.unseen.clone()))?;
    let unseen = all.len();
    let known = load(&ppnpack_household::source(&arguments.known))?;
    for object in known.objects {
        if all.find(&object.model.name).is_some() {
            return Err(Failure::input(format_args!(
                "both --unseen and --known have an object '{}'",
                object.model.name
            )));
        }
        all.objects.push(object);
    }
    Ok((all, unseen))
}

pub(super) fn settings(
    arguments: &PhysicalArguments,
    grid: &Grid,
    catalogue: &Catalogue,
    unseen: usize,
) -> Outcome<Settings> {
    let mut simulated = CellSettings::robot();
    simulated.container = grid.container();
    simulated.seed = arguments.seed;
    simulated.release.jitter_m = PLACEMENT_NOISE_M;
    simulated.release.jitter_yaw_rad = PLACEMENT_NOISE_M / 0.1;
    simulated.validate().or_input()?;
    let camera = CameraSettings {
        seed: arguments.seed,
        ..CameraSettings::default()
    };
    let mapper = MapperSettings {
        doubts: DoubtSettings {
            wall_thickness_m: simulated.walls.thickness_m,
            reach_above_rim_m: 0.05,
            ..DoubtSettings::default()
        },
        ..MapperSettings::of_camera(camera.noise.sigma_m)
    };
    let arm = match arguments.arm.as_str() {
        "none" => None,
        arm => Some(StationSettings {
            arm: arm.to_owned(),
            ..StationSettings::default()
        }),
    };
    if let Some(arm) = &arm {
        let known: Vec<&str> = arms::names().collect();
        arm.parameters()
            .map_err(|error| Failure::input(format_args!("--arm: {error}; built in: {known:?}")))?;
    }
    Ok(Settings {
        grid: GridSettings::from(grid),
        catalogue_hash: catalogue.content_hash(),
        unseen,
        unseen_count: arguments.unseen_count,
        known_count: KNOWN_COUNT,
        strangers: arguments.strangers,
        arm,
        simulated,
        faults: FaultSettings {
            missed_picks: arguments.missed_picks,
            drops: arguments.drops,
            seed: arguments.seed,
        },
        camera,
        mapper,
        buffer: BUFFER,
        seed: arguments.seed,
    })
}
