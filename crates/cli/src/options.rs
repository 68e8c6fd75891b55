//! Options that several commands share, and what they stand for.

use std::path::PathBuf;
use std::sync::Arc;

use clap::{Args, ValueEnum};
use ppnpack_catalogue::build::Pose;
use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::catalogue::{Catalogue, Settings, Source};
use ppnpack_catalogue::unit::LengthUnit;
use ppnpack_packing::check::BoxedCheck;
use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::objective::{Heuristic, Order, Weights};
use ppnpack_packing::plan::Planner;
use ppnpack_packing::proposals::{Percent, ProposeAll, ProposeRandom, Proposer};
use ppnpack_packing::search::{Search, SearchSettings};
use ppnpack_packing::stability::{
    PhysicalStability, PhysicalStabilitySettings, PublishedStability,
};
use ppnpack_physics::packing_cell::Scan;
use ppnpack_physics::settings::CellSettings;
use serde::{Deserialize, Serialize};

use crate::failure::{Failure, OrInput, Outcome};
use crate::length::{parse_distance, parse_length, parse_size};
use crate::progress;

/// Which objects there are.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Objects")]
pub(crate) struct CatalogueOptions {
    /// `builtin`, the household set that needs no files, or a folder of .ply, .obj or .stl meshes
    #[arg(long, value_name = "builtin|DIR", default_value = "builtin")]
    pub(crate) catalogue: String,

    /// The unit of the folder's mesh files where its objects.csv gives none
    #[arg(long, value_name = "UNIT", default_value = "m", value_parser = parse_unit)]
    pub(crate) unit: LengthUnit,

    /// The density of objects whose mass is not known, in kg/m^3
    #[arg(long, value_name = "KG_M3", default_value_t = 400.0, value_parser = positive, allow_hyphen_values = true)]
    pub(crate) density: f64,

    /// The pose in which objects are packed
    #[arg(long, value_enum, default_value = "as-given")]
    pub(crate) pose: PoseOption,

    /// Where processed meshes are kept between runs (default: the user's cache folder)
    #[arg(long, value_name = "DIR")]
    pub(crate) cache: Option<PathBuf>,
}

/// See [`Pose`].
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum PoseOption {
    /// As the mesh has it, z up
    AsGiven,
    /// The most probable resting pose
    MostProbable,
}

impl CatalogueOptions {
    pub(crate) fn source(&self) -> Source {
        match self.catalogue.as_str() {
            "builtin" => Source::Builtin,
            folder => Source::Folder(folder.into()),
        }
    }

    pub(crate) fn settings(&self) -> Settings {
        Settings {
            unit: self.unit,
            density_kg_m3: self.density,
            pose: match self.pose {
                PoseOption::AsGiven => Pose::AsGiven,
                PoseOption::MostProbable => Pose::MostProbable,
            },
            cache: self.cache.clone().map_or(CacheDir::User, CacheDir::At),
        }
    }

    /// Loads the catalogue, with a progress bar.
    pub(crate) fn load(&self, resolution: &Resolution) -> Outcome<Catalogue> {
        let bar = progress::bar("Preparing objects", 0);
        let loaded = Catalogue::load(
            &self.source(),
            &self.settings(),
            resolution,
            &|done, total| {
                bar.set_length(total as u64);
                bar.set_position(done as u64);
            },
        );
        bar.finish_and_clear();
        loaded.or_input()
    }
}

/// The container and how finely it is planned.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Container and grid")]
pub(crate) struct GridOptions {
    /// The container's inner size
    #[arg(long, value_name = "XxYxZ", allow_hyphen_values = true, default_value = "32x32x30cm", value_parser = parse_size)]
    pub(crate) container: Sides,

    /// The edge of a grid cell
    #[arg(long, value_name = "LENGTH", default_value = "1cm", value_parser = parse_length, allow_hyphen_values = true)]
    pub(crate) cell: f64,

    /// One unit of height
    #[arg(long, value_name = "LENGTH", default_value = "2mm", value_parser = parse_length, allow_hyphen_values = true)]
    pub(crate) height_unit: f64,

    /// How many yaws, evenly over half a turn
    #[arg(long, value_name = "COUNT", default_value_t = 4)]
    pub(crate) yaws: usize,
}

/// The three inner lengths of a container, in metres.
type Sides = [f64; 3];

impl GridOptions {
    pub(crate) fn resolution(&self) -> Outcome<Resolution> {
        let yaws = Yaws::half_turn(self.yaws).or_input()?;
        Resolution::new(self.cell, self.height_unit, yaws).or_input()
    }

    pub(crate) fn grid(&self) -> Outcome<Grid> {
        let [x_m, y_m, z_m] = self.container;
        Grid::new(ContainerSize { x_m, y_m, z_m }, self.resolution()?).or_input()
    }
}

/// How placements are found and judged.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Method")]
pub(crate) struct MethodOptions {
    /// What placements are judged by
    #[arg(long, value_enum, default_value = "sdfm")]
    pub(crate) heuristic: HeuristicOption,

    /// How the items of the buffer compete for a step
    #[arg(long, value_enum, default_value = "balance")]
    pub(crate) order: OrderOption,

    /// Which placements are evaluated
    #[arg(long, value_enum, default_value = "all")]
    pub(crate) proposals: ProposalsOption,

    /// The share of placements that is proposed, in percent
    #[arg(
        long = "k",
        value_name = "PERCENT",
        default_value_t = 5.0,
        allow_hyphen_values = true
    )]
    pub(crate) percent: f64,

    /// The stability test: `physical` for real cells, `published` for comparisons with the paper
    #[arg(long, value_enum, default_value = "physical")]
    pub(crate) stability: StabilityOption,

    /// A weight of the objective, such as distance=2.5 (may be repeated)
    #[arg(long = "weight", value_name = "NAME=VALUE")]
    pub(crate) weights: Vec<String>,

    /// How many items the robot may choose among
    #[arg(long, value_name = "COUNT", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) buffer: u32,

    /// The seed of everything that is random
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    pub(crate) seed: u64,

    /// Threads for one step; the result is the same with any number
    #[arg(long, value_name = "COUNT", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=256))]
    pub(crate) threads: u32,
}

/// See [`Heuristic`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum HeuristicOption {
    /// Low, close to content, compact (SDF minimisation)
    Sdfm,
    /// Deepest bottom-left
    Dbl,
    /// Heightmap minimisation
    Hm,
    /// Maximum touching area
    Mta,
    /// The first valid placement
    FirstFit,
    /// A valid placement at random
    Random,
}

impl From<HeuristicOption> for Heuristic {
    fn from(option: HeuristicOption) -> Self {
        match option {
            HeuristicOption::Sdfm => Self::Sdfm,
            HeuristicOption::Dbl => Self::Dbl,
            HeuristicOption::Hm => Self::Hm,
            HeuristicOption::Mta => Self::Mta,
            HeuristicOption::FirstFit => Self::FirstFit,
            HeuristicOption::Random => Self::Random,
        }
    }
}

/// See [`Order`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum OrderOption {
    /// All together, large items early
    Balance,
    /// By decreasing volume of the bounding box
    Bbox,
    /// As they arrived
    Arrival,
    /// In random order
    Shuffled,
}

impl From<OrderOption> for Order {
    fn from(option: OrderOption) -> Self {
        match option {
            OrderOption::Balance => Self::Balance,
            OrderOption::Bbox => Self::BboxVolume,
            OrderOption::Arrival => Self::Arrival,
            OrderOption::Shuffled => Self::Shuffled,
        }
    }
}

/// Where proposals come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProposalsOption {
    /// Every placement: the exhaustive search
    All,
    /// A random share of them, see --k
    Random,
}

/// Which stability test placements must pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum StabilityOption {
    /// On the real surfaces, in metres
    Physical,
    /// The paper's
    Published,
    /// None: only the fit is checked
    None,
}

impl StabilityOption {
    pub(crate) fn checks(self) -> Vec<BoxedCheck> {
        match self {
            Self::Physical => {
                vec![Box::new(PhysicalStability::new(
                    PhysicalStabilitySettings::default(),
                ))]
            }
            Self::Published => vec![Box::new(PublishedStability::default())],
            Self::None => vec![],
        }
    }
}

/// A packing method, as results record it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Method {
    pub(crate) heuristic: Heuristic,
    pub(crate) order: Order,
    /// The random share of placements that is evaluated, in percent; all of them where there is none.
    pub(crate) random_percent: Option<f64>,
    pub(crate) stability: StabilityOption,
    pub(crate) weights: Weights,
    pub(crate) buffer: usize,
    pub(crate) seed: u64,
}

impl MethodOptions {
    pub(crate) fn method(&self) -> Outcome<Method> {
        let share = Percent::new(self.percent).or_input()?;
        let random = self.proposals == ProposalsOption::Random;
        Ok(Method {
            heuristic: self.heuristic.into(),
            order: self.order.into(),
            random_percent: random.then_some(self.percent).filter(|_| share.of(100) > 0),
            stability: self.stability,
            weights: weights(&self.weights)?,
            buffer: self.buffer as usize,
            seed: self.seed,
        })
    }
}

impl Method {
    /// The planner that follows this method on `threads` threads.
    pub(crate) fn planner(&self, grid: &Grid, threads: u32) -> Outcome<Planner> {
        let proposer: Box<dyn Proposer> = match self.random_percent {
            None => Box::new(ProposeAll),
            Some(percent) => Box::new(ProposeRandom::new(
                Percent::new(percent).or_input()?,
                self.seed,
            )),
        };
        let settings = SearchSettings {
            heuristic: self.heuristic,
            order: self.order,
            weights: self.weights,
            seed: self.seed,
        };
        let mut search = Search::new(grid, &settings).or_input()?;
        if threads > 1 {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads as usize)
                .build();
            search = search.with_pool(Arc::new(pool.or_input()?));
        }
        let checks = self.stability.checks();
        Ok(Planner::new(
            proposer,
            Box::new(search),
            checks,
            self.order,
            self.seed,
        ))
    }
}

/// The simulated cell.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Simulated cell")]
pub(crate) struct PhysicsOptions {
    /// How far above its planned height an item is released
    #[arg(long, value_name = "LENGTH", value_parser = parse_distance, allow_hyphen_values = true)]
    pub(crate) release_height: Option<f64>,

    /// The longest that items are given to settle after each placement, in seconds
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    pub(crate) settle: Option<f64>,

    /// How the container is seen [default: exact; camera for comparisons with the paper]
    #[arg(long, value_enum)]
    pub(crate) scan: Option<ScanOption>,

    /// A JSON file with any settings of the simulated cell
    #[arg(long, value_name = "FILE")]
    pub(crate) physics: Option<PathBuf>,
}

/// See [`Scan`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ScanOption {
    /// The greatest height in each cell
    Exact,
    /// The height at the middle of each cell, as a camera with one pixel per cell gives it
    Camera,
}

impl From<ScanOption> for Scan {
    fn from(option: ScanOption) -> Self {
        match option {
            ScanOption::Exact => Self::Exact,
            ScanOption::Camera => Self::Camera,
        }
    }
}

impl PhysicsOptions {
    /// How the container is seen.
    pub(crate) fn scan(&self, default: Scan) -> Scan {
        self.scan.map_or(default, Scan::from)
    }

    pub(crate) fn settings(&self, grid: &Grid, seed: u64) -> Outcome<CellSettings> {
        let mut settings = match &self.physics {
            None => CellSettings::default(),
            Some(path) => {
                let text = std::fs::read_to_string(path).map_err(|error| {
                    Failure::input(format_args!("--physics {}: {error}", path.display()))
                })?;
                serde_json::from_str(&text).map_err(|error| {
                    Failure::input(format_args!("--physics {}: {error}", path.display()))
                })?
            }
        };
        settings.container = grid.container();
        settings.seed = seed;
        if let Some(height_m) = self.release_height {
            settings.release.height_m = height_m;
        }
        if let Some(time_s) = self.settle {
            settings.settle_time_s = time_s;
        }
        settings.validate().or_input()?;
        Ok(settings)
    }
}

fn weights(assignments: &[String]) -> Outcome<Weights> {
    let mut named = match serde_json::to_value(Weights::default()).or_input()? {
        serde_json::Value::Object(named) => named,
        _ => serde_json::Map::new(),
    };
    for assignment in assignments {
        let wrong = |why: &str| {
            let names: Vec<&str> = named.keys().map(String::as_str).collect();
            Failure::input(format_args!(
                "--weight {assignment}: {why}; give NAME=VALUE with one of {}",
                names.join(", ")
            ))
        };
        let Some((name, value)) = assignment.split_once('=') else {
            return Err(wrong("there is no '='"));
        };
        if !named.contains_key(name) {
            return Err(wrong("there is no such weight"));
        }
        let value: f64 = value.parse().map_err(|_| wrong("the value is no number"))?;
        named.insert(name.to_owned(), serde_json::json!(value));
    }
    let weights: Weights = serde_json::from_value(serde_json::Value::Object(named)).or_input()?;
    weights.validate().or_input()?;
    Ok(weights)
}

fn parse_unit(text: &str) -> Result<LengthUnit, String> {
    text.parse()
        .map_err(|error: ppnpack_catalogue::unit::UnknownUnit| error.to_string())
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("must be a number above 0".to_owned()),
    }
}
