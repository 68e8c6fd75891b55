//! `ppnpack experiment physical`: the paper's robot cell with its sensors, through the services.

mod contenders;
mod held;
mod pictures;
mod record;
mod run;
mod setup;
mod tray;

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use ppnpack_bridge::simulated::FaultSettings;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::packing_cell::Sampling;
use ppnpack_physics::settings::CellSettings;
use ppnpack_physics::view::CameraSettings;
use ppnpack_recognition::library::{Library, LibrarySettings};
use ppnpack_robot::station::ArmStation;
use ppnpack_wire::keys::Cell;
use rand::seq::index;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

use crate::network::{NetworkOptions, source};
use crate::results::OutOptions;
use crate::runs::Runs;
use contenders::{Contender, contenders, key};
use ppnpack_cli::failure::{Failure, OrInput, OrRun, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::{Network, Simulated};
use ppnpack_cli::quantity::parse_length;
use ppnpack_cli::stack::report::contents;
use ppnpack_cli::stack::{Containers, Plan, Sensing, Stack};
use record::RunRecord;
use run::{Case, Done, Seeds};
use setup::Settings;

/// The share that the paper's network proposes in its robot cell, in percent.
const PERCENT: f64 = 20.0;

/// Packs objects that the network was not trained on in the paper's robot cell: seen on a tray by a
/// depth camera, recognised, planned with the arm, placed, seen again; with the physical stability
/// test, and with placements that are tried in a simulation before they are made.
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

    /// The unseen objects are not in the recogniser's library: they are packed as unknown items
    #[arg(long)]
    strangers: bool,

    /// The first run
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    first: u32,

    /// How many runs, each with another seed
    #[arg(long, value_name = "COUNT", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    runs: u32,

    /// The edge of a grid cell
    #[arg(long, value_name = "LENGTH", default_value = "5mm", value_parser = parse_length, allow_hyphen_values = true)]
    cell: f64,

    /// How many yaws, evenly over half a turn
    #[arg(long, value_name = "COUNT", default_value_t = 8)]
    yaws: usize,

    /// The arm: a name, a parameter file, or `none`
    #[arg(long, value_name = "NAME|FILE|none", default_value = "nachi-mz07l")]
    arm: String,

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

    #[command(flatten)]
    network: NetworkOptions,

    /// The seed of everything that is random
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    seed: u64,

    #[command(flatten)]
    out: OutOptions,
}

pub(super) fn run(arguments: &PhysicalArguments, backend: &dyn Backend) -> Outcome {
    let grid = setup::grid(arguments)?;
    let (catalogue, unseen) = setup::catalogue(arguments, grid.resolution())?;
    let settings = setup::settings(arguments, &grid, &catalogue, unseen)?;
    let strangers = if settings.strangers { unseen } else { 0 };
    let models = catalogue.models();
    let known = models.get(strangers..).unwrap_or_default();
    let library = Library::new(known, LibrarySettings::default()).or_input()?;
    let station = settings.arm.as_ref().map(ArmStation::new).transpose();
    let held = held::objects(&catalogue, &grid, station.or_input()?.as_ref());
    let (unseen, others) = pools(arguments, held, unseen)?;
    let network = arguments.network.with_default(PERCENT);
    let model = network.find(backend, &grid)?;
    let items = catalogue.items();
    let shipped = model.as_ref().ok();
    let proposals = shipped.map(|model| source(&grid, network.percent(), model));
    let contenders = contenders(settings.buffer, settings.seed, proposals);
    let network = shipped.map(|model| network.of(backend, model, &items));
    let world = World {
        grid: &grid,
        settings: &settings,
        catalogue: &catalogue,
        library: Arc::new(library),
        unseen,
        others,
        network,
    };
    let lines = contenders.iter().map(|contender| {
        let (method, _) = contender;
        let records = world.runs(arguments, contender)?;
        Ok(json!({ "method": method, "records": records }))
    });
    let lines: Vec<Value> = lines.collect::<Outcome<_>>()?;
    let results = json!({
        "without_network": model.as_ref().err(),
        "settings": settings,
        "unseen_held": world.unseen.len(),
        "others_held": world.others.len(),
        "lines": lines,
    });
    arguments.out.publish("physical", results, "physical", "")
}

/// The objects of `held` to draw from: unseen ones, the first `unseen` of the catalogue, and
/// others.
fn pools(
    arguments: &PhysicalArguments,
    held: Vec<usize>,
    unseen: usize,
) -> Outcome<(Vec<usize>, Vec<usize>)> {
    let (unseen, others): (Vec<usize>, Vec<usize>) =
        held.into_iter().partition(|index| *index < unseen);
    let is_enough = unseen.len() >= arguments.unseen_count as usize
        && others.len() >= setup::KNOWN_COUNT as usize;
    if !is_enough {
        return Err(Failure::input(format_args!(
            "the arm can hold {} objects of --unseen and {} of --known: too few for a run",
            unseen.len(),
            others.len()
        )));
    }
    Ok((unseen, others))
}

struct World<'a> {
    grid: &'a Grid,
    settings: &'a Settings,
    catalogue: &'a Catalogue,
    /// Objects that can be recognised.
    library: Arc<Library>,
    unseen: Vec<usize>,
    others: Vec<usize>,
    network: Option<Network<'a>>,
}

impl World<'_> {
    fn known(&self, name: &str) -> Option<usize> {
        let mut objects = self.library.objects.iter();
        objects.position(|object| object.model.name == name)
    }

    fn runs(
        &self,
        arguments: &PhysicalArguments,
        contender: &Contender,
    ) -> Outcome<Vec<RunRecord>> {
        let folder = arguments.out.folder("physical").join("runs");
        // One after another: each has a stack of its own.
        let (_, method) = contender;
        let kept = Runs::new(&folder, &(self.settings, method), 1)?;
        let numbers = arguments.first..arguments.first.saturating_add(arguments.runs);
        let numbers: Vec<u32> = numbers.collect();
        let name = |number: &u32| format!("{number:05}");
        kept.make(
            &numbers,
            name,
            |_, _| true,
            |number| self.make(arguments, contender, *number),
        )
    }

    /// Makes a run through a stack of its own: it meets its faults whatever ran before. Draws the
    /// first.
    fn make(
        &self,
        arguments: &PhysicalArguments,
        contender: &Contender,
        number: u32,
    ) -> Outcome<RunRecord> {
        let case = self.case(number);
        let stack = self.start(contender, case.seeds)?;
        let mut done = run::run(self, &stack, &case)?;
        stack.finish()?;
        self.measure(&mut done)?;
        if number == arguments.first {
            let (name, _) = contender;
            let folder = arguments.out.folder("physical").join(key(name));
            pictures::draw(&done, self.catalogue, self.grid, &folder)?;
        }
        Ok(done.record)
    }

    fn start(&self, (_, method): &Contender, seeds: Seeds) -> Outcome<Stack> {
        let settings = self.settings;
        let is_network = method.proposals.is_network();
        Stack::start(&Plan {
            cells: vec![cell()?],
            containers: Containers::ONE,
            grid: self.grid,
            method,
            poses: 1,
            alternatives: 0,
            arm: settings.arm.as_ref(),
            simulated: &Simulated {
                preloaded: None,
                scan: Sampling::Greatest,
                camera: None,
                cell: CellSettings {
                    seed: seeds.release,
                    ..settings.simulated.clone()
                },
            },
            sensing: &Sensing {
                camera: Some(CameraSettings {
                    seed: seeds.camera,
                    ..settings.camera
                }),
                mapper: settings.mapper.clone(),
                faults: FaultSettings {
                    seed: seeds.faults,
                    ..settings.faults
                },
                remote: None,
                motion_speed: 0.0,
                inspect: Some(true),
                tray: Some(tray::settings()),
                library: Some(Arc::clone(&self.library)),
            },
            catalogue: Arc::new(self.catalogue.clone()),
            source: "builtin",
            network: self.network.filter(|_| is_network),
            store: None,
            listen: Vec::new(),
            ros: None,
        })
    }

    /// Measures what the container holds at the end by the bodies, not by the camera.
    fn measure(&self, done: &mut Done) -> Outcome {
        let contents = contents(&done.state, self.catalogue).or_run()?;
        let mut cell = SimulatedCell::new(self.settings.simulated.clone()).or_run()?;
        let bodies = contents.iter();
        let bodies = bodies.map(|(_, body)| (Arc::clone(&body.model), body.container_from_item));
        cell.lay_down(&bodies.collect::<Vec<_>>()).or_run()?;
        let surface = cell.scan_surface(self.grid).or_run()?;
        let highest_m = surface.heights_m().iter().copied().fold(0.0, f32::max);
        let container = self.grid.container();
        let below_m3 = container.volume_below_m3(f64::from(highest_m));
        let inside = contents.iter().filter(|(_, body)| body.inside);
        let record = &mut done.record;
        record.volume_m3 = inside.map(|(_, body)| body.model.volume_m3).sum();
        if below_m3 > 0.0 {
            record.compactness = record.volume_m3 / below_m3;
        }
        record.deepest_overlap_m = cell.deepest_overlap_m();
        Ok(())
    }

    fn case(&self, number: u32) -> Case {
        let settings = self.settings;
        let mut random = ChaCha8Rng::seed_from_u64(settings.seed);
        random.set_stream(u64::from(number));
        let mut draw = |from: &[usize], count: u32| -> Vec<usize> {
            let drawn = index::sample(&mut random, from.len(), count as usize);
            let drawn = drawn.iter().filter_map(|at| from.get(at).copied());
            drawn.collect()
        };
        let mut objects = draw(&self.unseen, settings.unseen_count);
        objects.extend(draw(&self.others, settings.known_count));
        // The known object comes at any time.
        for last in (1..objects.len()).rev() {
            objects.swap(last, random.random_range(0..=last));
        }
        Case {
            session_id: format!("physical-{number}-{:016x}", rand::random::<u64>()),
            seeds: Seeds {
                tray: random.random(),
                release: random.random(),
                camera: random.random(),
                faults: random.random(),
            },
            objects,
        }
    }
}

fn cell() -> Outcome<Cell> {
    Cell::new("cell-1").or_input()
}
