//! Options that several commands share.

mod cloud;
pub(crate) mod container;
pub(crate) mod file;
mod method;
mod physics;
mod proposals;
mod sensor;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use ppnpack_catalogue::build::Pose;
use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::catalogue::{Catalogue, Settings, Source};
use ppnpack_catalogue::unit::LengthUnit;
use ppnpack_packing::kernel::grid::{ContainerSize, Grid, GridSettings, Resolution};

use crate::failure::{OrInput, Outcome};
use crate::options::container::parse_container;
use crate::progress;
use crate::quantity::parse_length;
pub(crate) use cloud::read_cloud;
pub(crate) use method::MethodOptions;
pub use physics::{Conditions, PhysicsOptions, Simulated};
pub use proposals::{Network, PROPOSAL_YAWS, parse_device, read_model};
pub(crate) use sensor::{Sensor, calibration_file, parse_region, parse_sensor};

/// The objects to choose from.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Objects")]
pub struct CatalogueOptions {
    /// `builtin`, the household set that needs no files, or a folder of .ply, .obj, .stl, .glb or .3mf meshes
    #[arg(long, value_name = "builtin|DIR", default_value = "builtin")]
    pub(crate) catalogue: String,

    /// The unit of the folder's mesh files where its objects.csv gives none
    #[arg(long, value_name = "UNIT", default_value = "m")]
    pub(crate) unit: LengthUnit,

    /// The density of objects whose mass is not known, in kg/m^3
    #[arg(long, value_name = "KG_M3", default_value_t = 400.0, value_parser = positive, allow_hyphen_values = true)]
    pub(crate) density: f64,

    /// Leave out files of the folder that cannot be used, with a warning; the objects after them move up
    #[arg(long)]
    pub(crate) skip_unusable: bool,

    /// The pose in which objects are packed
    #[arg(long, value_parser = one_of(&POSES), default_value = "as-given")]
    pub(crate) pose: Pose,

    /// In how many resting poses an object may be packed at most: --pose, then the likeliest
    /// others. A step chooses the pose with the place
    #[arg(long, value_name = "COUNT", default_value_t = 1, overrides_with = "poses", value_parser = clap::value_parser!(u32).range(1..=6))]
    pub(crate) poses: u32,
}

const POSES: [Choice<Pose>; 2] = [
    ("as-given", Pose::AsGiven, "As the mesh has it, z up"),
    (
        "most-probable",
        Pose::MostProbable,
        "The most probable resting pose",
    ),
];

impl CatalogueOptions {
    /// Gives the source of the objects.
    pub fn source(&self) -> Source {
        ppnpack_household::source(&self.catalogue)
    }

    /// Gives the settings by which they are made.
    pub fn settings(&self) -> Settings {
        Settings {
            unit: self.unit,
            density_kg_m3: self.density,
            skip_unusable: self.skip_unusable,
            pose: self.pose,
            poses: self.poses as usize,
            cache: CacheDir::User,
        }
    }

    /// Loads the catalogue, with a progress bar.
    pub fn load(&self, resolution: &Resolution) -> Outcome<Catalogue> {
        self.load_only(&[], resolution)
    }

    /// Loads the objects of these names, or all where there are none, with a progress bar.
    pub(crate) fn load_only(
        &self,
        names: &[String],
        resolution: &Resolution,
    ) -> Outcome<Catalogue> {
        load_only(&self.source(), &self.settings(), names, resolution)
    }
}

/// Loads a catalogue, with a progress bar.
pub fn load(source: &Source, settings: &Settings, resolution: &Resolution) -> Outcome<Catalogue> {
    load_only(source, settings, &[], resolution)
}

fn load_only(
    source: &Source,
    settings: &Settings,
    names: &[String],
    resolution: &Resolution,
) -> Outcome<Catalogue> {
    let bar = progress::bar("Preparing objects", 1);
    let loaded = Catalogue::load_only(source, settings, names, resolution, &|_, total| {
        bar.set_length(total as u64);
        bar.inc(1);
    });
    bar.finish_and_clear();
    loaded.or_input()
}

/// The container and its grid.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Container and grid")]
pub struct GridOptions {
    /// The container's inner size, or a TOML file with its size, draft and corner_radius
    #[arg(long, value_name = "XxYxZ|FILE", allow_hyphen_values = true, default_value = "32x32x30cm", value_parser = parse_container)]
    pub(crate) container: ContainerSize,

    /// The edge of a grid cell [default: 2.5mm under robot conditions, 1cm under the reference's]
    #[arg(long, value_name = "LENGTH", value_parser = parse_length, allow_hyphen_values = true)]
    pub(crate) cell: Option<f64>,

    /// How many yaws, evenly over half a turn [default: 16 under robot conditions, 4 under the
    /// reference's]
    #[arg(long, value_name = "COUNT")]
    pub(crate) yaws: Option<usize>,
}

impl GridOptions {
    /// Makes the grid, by default the one that suits the conditions.
    pub fn grid(&self, conditions: Conditions) -> Outcome<Grid> {
        self.settings(conditions).build().or_input()
    }

    /// Gives the settings of the grid.
    pub fn settings(&self, conditions: Conditions) -> GridSettings {
        let usual = conditions.grid();
        GridSettings {
            container: self.container,
            cell_m: self.cell.unwrap_or(usual.cell_m),
            yaws: self.yaws.unwrap_or(usual.yaws),
            ..usual
        }
    }
}

/// Parses a number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("must be a number above 0".to_owned()),
    }
}

/// A value: its name on the command line, itself, and what it is.
pub type Choice<T> = (&'static str, T, &'static str);

/// Parses the name of one of these values.
pub fn one_of<T: Copy + Send + Sync>(
    choices: &'static [Choice<T>],
) -> impl TypedValueParser<Value = T> {
    let named = choices.iter();
    let named = named.map(|(name, _, what)| PossibleValue::new(*name).help(*what));
    PossibleValuesParser::new(named).try_map(|given| {
        let found = choices.iter().find(|(name, ..)| *name == given);
        found
            .map(|(_, value, _)| *value)
            .ok_or("there is no such value")
    })
}
