//! `ppnpack experiment physical`: the paper's robot cell, simulated with its sensors, through the services.

mod content;
mod held;
mod pictures;
mod record;
mod results;
mod run;
mod sums;
mod tray;

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use ppnpack_bridge::simulated::{CameraSettings, FaultSettings, Scan};
use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::catalogue::{self, Catalogue, Source};
use ppnpack_packing::grid::{ContainerSize, Grid, Resolution};
use ppnpack_packing::objective::{Heuristic, Order, Weights};
use ppnpack_perception::doubts::DoubtSettings;
use ppnpack_perception::settings::MapperSettings;
use ppnpack_physics::camera::DepthNoise;
use ppnpack_physics::packing_cell::Scan as PhysicsScan;
use ppnpack_physics::settings::CellSettings;
use ppnpack_recognition::library::{Library, LibrarySettings};
use ppnpack_robot::arms;
use ppnpack_robot::station::{ArmStation, StationSettings};
use ppnpack_wire::keys::Cell;
use rand::seq::index;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::network::NetworkOptions;
use super::runs::Runs;
use crate::failure::{Failure, OrInput, OrRun, Outcome};
use crate::network::Backend;
use crate::options::{
    DeviceOption, Method, Network, ProposalSource, Simulated, StabilityOption, positive,
};
use crate::progress;
use crate::stack::controller::Controller;
use crate::stack::{Plan, Sensing, Stack, Tray as StackTray};
use record::RunRecord;
use run::{Bench, Case};
use sums::Line;

/// What says that there is no arm.
const NO_ARM: &str = "none";

/// Packs objects that the network was not trained on in the paper's robot cell: seen on a tray by a depth camera,
/// recognised, planned with the arm, placed, seen again; by the exhaustive search and with the network's proposals.
#[derive(Debug, Args)]
pub(super) struct PhysicalArguments {
    /// A folder of objects that the network was not trained on
    #[arg(long, value_name = "DIR")]
    unseen: PathBuf,

    /// Other objects: `builtin`, or a folder
    #[arg(long, value_name = "builtin|DIR", default_value = "builtin")]
    known: String,

    /// How many unseen objects a run has
    #[arg(long, value_name = "COUNT", default_value_t = 8, value_parser = clap::value_parser!(u32).range(0..=1000))]
    unseen_count: u32,

    /// How many other objects a run has
    #[arg(long, value_name = "COUNT", default_value_t = 1, value_parser = clap::value_parser!(u32).range(0..=1000))]
    known_count: u32,

    /// The unseen objects are not in the recogniser's library either: they are packed as unknown items
    #[arg(long)]
    strangers: bool,

    /// How many runs, each with another seed
    #[arg(long, value_name = "COUNT", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    runs: u32,

    /// How many items wait on the tray
    #[arg(long, value_name = "COUNT", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=16))]
    buffer: u32,

    /// The arm: a name, a parameter file, or `none`
    #[arg(long, value_name = "NAME|FILE|none", default_value = "nachi-mz07l")]
    arm: String,

    /// The standard deviation of where items are released, in metres along each axis; and as much in yaw as moves a
    /// point 10 cm away by it
    #[arg(
        long,
        value_name = "METRES",
        default_value_t = 0.002,
        allow_hyphen_values = true
    )]
    placement_noise: f64,

    /// The share of picks that miss
    #[arg(
        long,
        value_name = "SHARE",
        default_value_t = 0.02,
        allow_hyphen_values = true
    )]
    missed_picks: f64,

    /// The share of items that are dropped beside the container
    #[arg(
        long,
        value_name = "SHARE",
        default_value_t = 0.01,
        allow_hyphen_values = true
    )]
    drops: f64,

    /// The density of objects whose mass is not known, in kg/m^3
    #[arg(long, value_name = "KG_M3", default_value_t = 400.0, value_parser = positive, allow_hyphen_values = true)]
    density: f64,

    /// The network's weights, a .safetensors file with its .json card beside it [default: those that ship]
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,

    /// Where the network runs
    #[arg(long, value_enum, default_value = "cpu")]
    device: DeviceOption,

    /// The share of placements that the network proposes, in percent
    #[arg(
        long = "k",
        value_name = "PERCENT",
        default_value_t = 20.0,
        allow_hyphen_values = true
    )]
    percent: f64,

    /// The seed of everything that is random
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    seed: u64,

    /// Where physical.md, physical.json and pictures are written; a killed experiment goes on there
    #[arg(long, value_name = "DIR", default_value = "out/physical")]
    out: PathBuf,

    /// Print the results as JSON instead of tables
    #[arg(long)]
    json: bool,
}

/// What all runs have in common; with another one they begin anew.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Settings {
    version: String,
    container: ContainerSize,
    catalogue_hash: String,
    unseen: usize,
    unseen_count: u32,
    known_count: u32,
    strangers: bool,
    arm: Option<StationSettings>,
    simulated: CellSettings,
    faults: FaultSettings,
    camera: CameraSettings,
    mapper: MapperSettings,
    buffer: usize,
    seed: u64,
}

/// A way to plan.
struct Contender {
    name: String,
    proposals: ProposalSource,
}

pub(super) fn run(arguments: &PhysicalArguments, backend: &dyn Backend) -> Outcome {
    let grid = grid()?;
    let (catalogue, unseen) = catalogue(arguments, grid.resolution())?;
    let settings = settings(arguments, &grid, &catalogue, unseen)?;
    let library = library(&catalogue, if settings.strangers { unseen } else { 0 })?;
    let station = settings.arm.as_ref().map(ArmStation::new).transpose();
    let held = held::objects(&catalogue, &grid, station.or_input()?.as_ref());
    let pool = Pool::new(arguments, held, unseen)?;
    let runs = Runs::new(&arguments.out.join("runs"), &settings)?;
    let network = NetworkOptions::new(arguments.model.clone(), arguments.device, arguments.percent);
    let model = network.find(backend, &grid)?;
    let items = catalogue.items();
    let mut contenders = vec![Contender {
        name: "exhaustive".to_owned(),
        proposals: ProposalSource::All,
    }];
    if let Ok(model) = &model {
        let percent = arguments.percent;
        contenders.push(Contender {
            name: format!("network, K = {percent} %"),
            proposals: network.source(&grid, model),
        });
    }
    let shipped = model.as_ref().ok();
    let network = shipped.map(|model| network.of(backend, model, &items));
    let world = World {
        grid: &grid,
        settings: &settings,
        catalogue: &catalogue,
        library: &library,
        pool: &pool,
        network,
    };
    let mut lines = Vec::new();
    for contender in &contenders {
        let records = world.runs(arguments, contender, &runs)?;
        lines.push(Line::new(&contender.name, records));
    }
    let without_network = model.err();
    let kept = (pool.unseen.len(), pool.others.len());
    results::publish(arguments, &settings, kept, lines, without_network)
}

/// The objects that runs draw from, by index.
struct Pool {
    unseen: Vec<usize>,
    others: Vec<usize>,
}

impl Pool {
    /// Those of `held`; the first `unseen` of the catalogue are unseen.
    fn new(arguments: &PhysicalArguments, held: Vec<usize>, unseen: usize) -> Outcome<Self> {
        let (unseen, others): (Vec<usize>, Vec<usize>) =
            held.into_iter().partition(|index| *index < unseen);
        let is_enough = unseen.len() >= arguments.unseen_count as usize
            && others.len() >= arguments.known_count as usize;
        if !is_enough {
            return Err(Failure::input(format_args!(
                "the arm can hold {} objects of --unseen and {} of --known: too few for a run",
                unseen.len(),
                others.len()
            )));
        }
        Ok(Self { unseen, others })
    }
}

/// The grid of the paper's robot cell.
fn grid() -> Outcome<Grid> {
    let container = ContainerSize {
        x_m: 0.30,
        y_m: 0.30,
        z_m: 0.16,
    };
    Grid::new(container, Resolution::reference()).or_input()
}

/// The unseen objects, then the others; how many are unseen.
fn catalogue(
    arguments: &PhysicalArguments,
    resolution: &Resolution,
) -> Outcome<(Catalogue, usize)> {
    let settings = catalogue::Settings {
        density_kg_m3: arguments.density,
        cache: CacheDir::User,
        ..catalogue::Settings::default()
    };
    let load = |source: &Source| {
        let bar = progress::bar("Preparing objects", 0);
        let loaded = Catalogue::load(source, &settings, resolution, &|done, total| {
            bar.set_length(total as u64);
            bar.set_position(done as u64);
        });
        bar.finish_and_clear();
        loaded.or_input()
    };
    let mut all = load(&Source::Folder(arguments.unseen.clone()))?;
    let unseen = all.len();
    let known = match arguments.known.as_str() {
        "builtin" => load(&Source::Builtin)?,
        folder => load(&Source::Folder(folder.into()))?,
    };
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

/// What can be recognised: all objects but the first `strangers`.
fn library(catalogue: &Catalogue, strangers: usize) -> Outcome<Arc<Library>> {
    let models: Vec<_> = catalogue
        .objects
        .iter()
        .skip(strangers)
        .map(|object| Arc::clone(&object.model))
        .collect();
    Library::new(&models, LibrarySettings::default())
        .map(Arc::new)
        .or_input()
}

fn settings(
    arguments: &PhysicalArguments,
    grid: &Grid,
    catalogue: &Catalogue,
    unseen: usize,
) -> Outcome<Settings> {
    let mut simulated = CellSettings::robot();
    simulated.container = grid.container();
    simulated.seed = arguments.seed;
    simulated.release.jitter_m = arguments.placement_noise;
    simulated.release.jitter_yaw_rad = arguments.placement_noise / 0.1;
    simulated.validate().or_input()?;
    let noise = DepthNoise {
        sigma_m: 0.001,
        dropout: 0.05,
        step_m: 0.0,
    };
    let mapper = MapperSettings {
        noise_m: noise.sigma_m,
        point_radius_m: 0.001,
        largest_hole_m: 0.005,
        wall_margin_m: 0.003,
        largest_unseen_share: 0.25,
        doubts: DoubtSettings {
            wall_thickness_m: simulated.walls.thickness_m,
            reach_above_rim_m: Some(0.05),
            ..DoubtSettings::default()
        },
        ..MapperSettings::default()
    };
    let arm = match arguments.arm.as_str() {
        NO_ARM => None,
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
        version: env!("CARGO_PKG_VERSION").to_owned(),
        container: grid.container(),
        catalogue_hash: catalogue.content_hash(),
        unseen,
        unseen_count: arguments.unseen_count,
        known_count: arguments.known_count,
        strangers: arguments.strangers,
        arm,
        simulated,
        faults: FaultSettings {
            missed_picks: arguments.missed_picks,
            drops: arguments.drops,
            seed: arguments.seed,
        },
        camera: CameraSettings {
            noise,
            seed: arguments.seed,
            ..CameraSettings::default()
        },
        mapper,
        buffer: arguments.buffer as usize,
        seed: arguments.seed,
    })
}

/// What runs are made in.
struct World<'a> {
    grid: &'a Grid,
    settings: &'a Settings,
    catalogue: &'a Catalogue,
    library: &'a Arc<Library>,
    pool: &'a Pool,
    network: Option<Network<'a>>,
}

impl World<'_> {
    /// All runs of a contender: those on disk, and the others through a stack of its own.
    fn runs(
        &self,
        arguments: &PhysicalArguments,
        contender: &Contender,
        runs: &Runs,
    ) -> Outcome<Vec<RunRecord>> {
        let name = |number: u32| {
            let proposals = serde_json::to_vec(&contender.proposals).or_run()?;
            let key = blake3::hash(&proposals).to_hex();
            Ok::<_, Failure>(format!("{}-{number}", key.get(..16).unwrap_or("key")))
        };
        let mut stack = None;
        let mut records = Vec::new();
        let bar = progress::bar("Runs", u64::from(arguments.runs));
        for number in 0..arguments.runs {
            let name = name(number)?;
            let record = match runs.load(&name) {
                Some(record) => record,
                None => {
                    let running = match &mut stack {
                        Some(running) => running,
                        none => none.insert(self.start(contender)?),
                    };
                    let record = self.run_once(arguments, contender, number, running)?;
                    runs.save(&name, &record)?;
                    record
                }
            };
            records.push(record);
            bar.inc(1);
        }
        bar.finish_and_clear();
        if let Some(stack) = stack {
            stack.finish()?;
        }
        Ok(records)
    }

    fn start(&self, contender: &Contender) -> Outcome<Stack> {
        let settings = self.settings;
        let method = Method {
            heuristic: Heuristic::Sdfm,
            order: Order::Balance,
            proposals: contender.proposals.clone(),
            stability: StabilityOption::Physical,
            arm: settings.arm.clone(),
            weights: Weights::default(),
            buffer: settings.buffer,
            seed: settings.seed,
        };
        let is_network = contender.proposals.is_network();
        Stack::start(&Plan {
            cells: vec![cell()?],
            grid: self.grid,
            method: &method,
            simulated: &Simulated {
                scan: PhysicsScan::Exact,
                cell: settings.simulated.clone(),
            },
            sensing: &Sensing {
                scan: Scan::Camera,
                camera: settings.camera,
                mapper: settings.mapper.clone(),
                faults: settings.faults,
                inspect: true,
                tray: Some(StackTray {
                    settings: tray::settings(),
                    library: Arc::clone(self.library),
                }),
            },
            catalogue: Arc::new(self.catalogue.clone()),
            source: "builtin",
            network: self.network.filter(|_| is_network),
            store: None,
            listen: Vec::new(),
        })
    }

    fn run_once(
        &self,
        arguments: &PhysicalArguments,
        contender: &Contender,
        number: u32,
        stack: &Stack,
    ) -> Outcome<RunRecord> {
        let bench = Bench {
            controller: Controller::new(stack.client(), cell()?),
            session: stack.session(),
            cell: cell()?,
            catalogue: self.catalogue,
            library: self.library,
            buffer: self.settings.buffer,
        };
        let mut done = bench.run(&self.case(number))?;
        content::measure(
            &mut done,
            self.catalogue,
            &self.settings.simulated,
            self.grid,
        )?;
        if number == 0 {
            let folder = arguments.out.join(if contender.proposals.is_network() {
                "network"
            } else {
                "exhaustive"
            });
            pictures::draw(&done, self.catalogue, self.grid, &folder)?;
        }
        Ok(done.record)
    }

    /// The objects of a run, the same for every contender.
    fn case(&self, number: u32) -> Case {
        let settings = self.settings;
        let mut random = ChaCha8Rng::seed_from_u64(settings.seed);
        random.set_stream(u64::from(number));
        let mut draw = |from: &[usize], count: u32| -> Vec<usize> {
            let drawn = index::sample(&mut random, from.len(), count as usize);
            drawn
                .iter()
                .filter_map(|at| from.get(at).copied())
                .collect()
        };
        let mut objects = draw(&self.pool.unseen, settings.unseen_count);
        objects.extend(draw(&self.pool.others, settings.known_count));
        // The known object comes at any time.
        for last in (1..objects.len()).rev() {
            objects.swap(last, random.random_range(0..=last));
        }
        Case {
            session_id: format!("physical-{number}-{:016x}", rand::random::<u64>()),
            seed: random.random(),
            objects,
        }
    }
}

fn cell() -> Outcome<Cell> {
    Cell::new("cell-1").or_input()
}
