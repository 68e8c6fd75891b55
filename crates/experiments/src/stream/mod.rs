//! `ppnpack experiment stream`: items that arrive without an end, of orders or not, packed into several containers that are open at the same
//! time.

mod packing;
mod results;
mod source;

use std::path::PathBuf;

use clap::Args;
use ppnpack_cli::failure::{Failure, OrInput, Outcome};
use ppnpack_cli::options::{ArmOptions, CatalogueOptions, ViewOptions};
use ppnpack_packing::closing::ClosingRules;
use ppnpack_packing::orders::{ContainerRules, Sharing};
use ppnpack_packing::stream::StreamPlay;
use serde::Serialize;

use crate::document::OutOptions;
use crate::filling::apart::Physics;
use crate::filling::{self, Way};
use crate::runs::{self, Runs, RunsOptions};
use packing::{Packing, Run};
use results::Results;
use source::{Arrivals, SourceOptions, Wanted};

/// The most containers that are open at the same time.
const MOST_OPEN: u8 = 16;

/// Packs streams into one container after another and into several at the same time, and compares how full they are closed. With orders
/// the first line has one order at a time, in containers of its own
#[derive(Debug, Args)]
pub(crate) struct StreamArguments {
    #[command(flatten)]
    catalogue: CatalogueOptions,

    #[command(flatten)]
    source: SourceOptions,

    /// Pairs of groups of the orders' table that never travel in one container, such as food:chemicals
    #[arg(long, value_name = "GROUP:GROUP", value_delimiter = ',', value_parser = parse_pair, conflicts_with = "sequences")]
    apart: Vec<(String, String)>,

    /// Pairs of groups of the orders' table of which an order's items travel in one container, such as device:charger
    #[arg(long, value_name = "GROUP:GROUP", value_delimiter = ',', value_parser = parse_pair, conflicts_with = "sequences")]
    together: Vec<(String, String)>,

    /// No order is divided: all of its items go into one container
    #[arg(long, conflicts_with = "sequences")]
    undivided: bool,

    /// The greatest mass of what a container holds, in kilograms
    #[arg(long, value_name = "KG", value_parser = parse_mass_kg, conflicts_with = "sequences")]
    most_kg: Option<f64>,

    /// A container is closed as soon as its items fill so many percent of its volume
    #[arg(long, value_name = "PERCENT", value_parser = parse_percent)]
    full_at: Option<f64>,

    /// The first stream
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    first: u32,

    /// How many streams
    #[arg(long, value_name = "COUNT", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..))]
    streams: u32,

    /// The items of a stream of sequences
    #[arg(long, value_name = "COUNT", default_value_t = 400, value_parser = clap::value_parser!(u32).range(1..))]
    items: u32,

    /// How many containers are open at the same time; the others are compared with the first
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "1,2,3,4",
        value_parser = clap::value_parser!(u8).range(1..=i64::from(MOST_OPEN))
    )]
    open: Vec<u8>,

    /// A JSON file with the method, in place of placements that are tried on 5 mm and 8 yaws
    #[arg(long, value_name = "FILE")]
    method: Option<PathBuf>,

    #[command(flatten)]
    arm: ArmOptions,

    /// The physics of the cells that are packed in
    #[arg(long, value_enum, default_value_t = Physics::Own)]
    physics: Physics,

    #[command(flatten)]
    view: ViewOptions,

    #[command(flatten)]
    runs: RunsOptions,

    #[command(flatten)]
    out: OutOptions,
}

/// How a line of the table is packed.
#[derive(Debug, Clone, Copy, Serialize)]
struct Setting {
    open: u8,
    sharing: Sharing,
}

impl StreamArguments {
    /// The lines, the one that the others are compared with first.
    fn settings(&self) -> Vec<Setting> {
        let one = Setting {
            open: 1,
            sharing: Sharing::OneOrder,
        };
        let shared = self.open.iter().map(|open| Setting {
            open: *open,
            sharing: Sharing::Shared,
        });
        let first = self.source.has_orders().then_some(one);
        first.into_iter().chain(shared).collect()
    }

    fn wanted(&self) -> Wanted {
        Wanted {
            first: self.first,
            streams: self.streams,
            items: self.items,
        }
    }

    fn rules(&self, sharing: Sharing) -> Outcome<ContainerRules> {
        let rules = ContainerRules {
            sharing,
            undivided: self.undivided,
            apart: self.apart.clone(),
            together: self.together.clone(),
            most_kg: self.most_kg,
        };
        match rules.contradiction() {
            Some((a, b)) => Err(Failure::input(format_args!(
                "--together {a}:{b}: --apart has this pair, too, and none of them could be packed: leave one of them out"
            ))),
            None => Ok(rules),
        }
    }

    fn closing(&self, sharing: Sharing) -> ClosingRules {
        ClosingRules {
            fill_percent: self.full_at,
            order_complete: sharing == Sharing::OneOrder,
        }
    }
}

pub(crate) fn run(arguments: &StreamArguments) -> Outcome {
    if arguments.arm.listed()? {
        return Ok(());
    }
    let way = match &arguments.method {
        Some(path) => Way::read_one(path)?,
        None => Way::default(),
    }
    .seen_by(&arguments.view);
    let catalogue = filling::catalogue(&arguments.catalogue, &way)?;
    let streams = arguments.source.streams(&catalogue, arguments.wanted())?;
    let apart = arguments.physics.apart();
    let (arm, station) = arguments.arm.station()?.unzip();
    let grid = way.grid.build().or_input()?;
    let folder = arguments.runs.folder(&arguments.out, "stream");
    let mut packed = Vec::new();
    for setting in arguments.settings() {
        let packing = Packing {
            way: &way,
            catalogue: &catalogue,
            apart: &apart,
            station: station.as_ref(),
            rules: arguments.rules(setting.sharing)?,
            how: StreamPlay {
                open: usize::from(setting.open),
                buffer: way.method.buffer,
                closing: arguments.closing(setting.sharing),
            },
            grid: &grid,
        };
        let possible = packing.how.closing.validate(&packing.rules);
        possible.or_input()?;
        let settings = (
            catalogue.content_hash(),
            &way,
            (&apart, &arm),
            &packing.rules,
            packing.how.closing,
            setting.open,
        );
        let kept = Runs::new(&folder, &settings)?;
        let pack = |stream: &Arrivals| {
            let is_right = |run: &Run| run.objects == stream.objects;
            // What is known of the items decides, too.
            let known = (&stream.orders, &stream.stops, &stream.expected);
            let orders = runs::hash(&format!("{known:?}"), 8)?;
            let name = format!("{:05}-{orders}", stream.number);
            kept.finish(&name, is_right, || packing.pack(stream))
        };
        packed.push((setting, arguments.runs.make(&streams, pack)?));
    }
    let results = Results::new(arguments, &way, packed);
    arguments.out.publish("stream", &results, &results.text)
}

fn parse_pair(text: &str) -> Result<(String, String), String> {
    let pair = text.split_once(':');
    let (a, b) =
        pair.ok_or_else(|| format!("'{text}' is no pair: write it like food:chemicals"))?;
    Ok((a.trim().to_owned(), b.trim().to_owned()))
}

fn parse_mass_kg(text: &str) -> Result<f64, String> {
    let mass_kg = text.parse::<f64>().ok();
    let mass_kg = mass_kg.filter(|mass_kg| mass_kg.is_finite() && *mass_kg > 0.0);
    mass_kg.ok_or_else(|| format!("'{text}' is no mass: write it like 12.5"))
}

fn parse_percent(text: &str) -> Result<f64, String> {
    let percent = text.parse::<f64>().ok();
    let percent = percent.filter(|percent| (1.0..=100.0).contains(percent));
    percent.ok_or_else(|| format!("'{text}' is no percentage of 1 to 100: write it like 85"))
}
