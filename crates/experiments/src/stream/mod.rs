//! `ppnpack experiment stream`: items that arrive without an end, of orders or not, packed into several containers that are open at the same
//! time.

mod columns;
mod packing;
mod source;

use std::path::PathBuf;

use clap::Args;
use ppnpack_cli::failure::{OrInput, Outcome};
use ppnpack_cli::options::CatalogueOptions;
use ppnpack_packing::closing::ClosingRules;
use ppnpack_packing::orders::{ContainerRules, Sharing};
use ppnpack_packing::stream::StreamPlay;
use serde::Serialize;

use crate::apart::Apart;
use crate::comparison::WIDENED;
use crate::document::Page;
use crate::packer::Packer;
use crate::runs::{self, RunsOptions};
use crate::sheet::Lines;
use crate::way::Way;
use packing::{Packing, Run};
use source::{Arrivals, SourceOptions};

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
    runs: RunsOptions,
}

/// How a line of the table is packed.
#[derive(Debug, Clone, Copy, Serialize)]
struct Setting {
    open: u8,
    sharing: Sharing,
}

impl Setting {
    fn shown(self, has_orders: bool) -> String {
        match self.sharing {
            Sharing::OneOrder => format!("{}, one order at a time", self.open),
            Sharing::Shared if has_orders => format!("{}, shared", self.open),
            Sharing::Shared => self.open.to_string(),
        }
    }
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

    fn rules(&self, sharing: Sharing) -> ContainerRules {
        ContainerRules {
            sharing,
            apart: self.apart.clone(),
            ..ContainerRules::default()
        }
    }
}

pub(crate) fn run(arguments: &StreamArguments) -> Outcome {
    let way = Way::read_one(arguments.method.as_deref())?;
    let packer = Packer::robot(way, &arguments.catalogue, Apart::default())?;
    let numbers = arguments.first..arguments.first.saturating_add(arguments.streams);
    let source = &arguments.source;
    let streams = source.streams(&packer.catalogue, numbers, arguments.items)?;
    let settings = arguments.settings();
    let has_orders = arguments.source.has_orders();
    let pack = |setting: &Setting| {
        let packing = Packing {
            packer: &packer,
            rules: arguments.rules(setting.sharing),
            how: StreamPlay {
                open: usize::from(setting.open),
                buffer: packer.way.method.buffer,
                closing: ClosingRules {
                    fill_percent: None,
                    order_complete: setting.sharing == Sharing::OneOrder,
                },
            },
        };
        let possible = packing.how.closing.validate(&packing.rules);
        possible.or_input()?;
        let settings = (
            packer.catalogue.content_hash(),
            &packer.way,
            &packing.rules,
            packing.how.closing,
            setting.open,
        );
        let name = |stream: &Arrivals| {
            // What is known of the items decides, too.
            let known = format!("{:?}", (&stream.orders, &stream.stops, &stream.expected));
            format!("{:05}-{}", stream.number, runs::hash(known.as_bytes(), 8))
        };
        let is_right = |stream: &Arrivals, run: &Run| run.objects == stream.objects;
        let make = |stream: &Arrivals| packing.pack(stream);
        let runs = arguments.runs.kept("stream", &settings)?;
        let packed = runs.make(&streams, name, is_right, make)?;
        Ok((setting.shown(has_orders), packed))
    };
    let packed = settings.iter().map(pack).collect::<Outcome<_>>()?;
    let mut lines = Lines::new("name", packed);
    lines.keep("setting", settings);
    publish(arguments, &packer.way, lines)
}

fn publish(arguments: &StreamArguments, way: &Way, mut lines: Lines<Run>) -> Outcome {
    let (workers, source) = (
        arguments.runs.workers(),
        arguments.source.said(arguments.items),
    );
    let text = format!(
        "# Streams: several containers open\n\n\
         {} streams of {source} from stream {} on, method *{}*, buffer of {}. An item goes into the fullest container in which an item of the \
         buffer has a valid placement. Where nothing in the buffer \
         has a valid placement in any, the fullest is closed and an empty one opened; other rules that closed containers are named below. \
         Volumes are of closed containers: the mean of \
         each stream, then over streams; differences are to the first line, stream by stream, with 95 % intervals by Student's t. \
         *Unsteady* is what toppled by more than 30 degrees, slid by more than 2 cm or left the container when it was placed. \
         {WIDENED} Decision times are of one step on one thread, {workers} streams at once.\n\n{}",
        arguments.streams,
        arguments.first,
        way.name,
        way.method.buffer,
        lines.table("open", &columns::volumes()),
    );
    let mut page = Page::new("stream", text);
    if arguments.source.has_orders() {
        page.say(&format!(
            "\nContainers in which something was packed, open ones at the end among them; differences are to the first line, stream by \
             stream. *Complete* orders have all of their items in containers.\n\n{}",
            lines.table("open", &columns::orders())
        ));
    }
    page.say(&format!(
        "\nWhy containers were closed, and how much of their volume was filled:\n\n{}",
        lines.table("open", &columns::closings())
    ));
    page.keep("workers", workers);
    page.keep("first_stream", arguments.first);
    page.keep("streams", arguments.streams);
    page.keep("source", source);
    page.keep("way", way);
    page.keep("lines", lines);
    page.publish(&arguments.runs.out)
}

fn parse_pair(text: &str) -> Result<(String, String), String> {
    let pair = text.split_once(':');
    let (a, b) =
        pair.ok_or_else(|| format!("'{text}' is no pair: write it like food:chemicals"))?;
    Ok((a.trim().to_owned(), b.trim().to_owned()))
}
