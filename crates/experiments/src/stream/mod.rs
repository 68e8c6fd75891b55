//! `ppnpack experiment stream`: items that arrive without an end, of orders or not, packed into
//! several containers that are open at the same time.

mod packing;
mod source;

use std::path::PathBuf;

use clap::Args;
use ppnpack_cli::failure::{OrInput, Outcome};
use ppnpack_cli::options::CatalogueOptions;
use ppnpack_packing::streams::closing::ClosingRules;
use ppnpack_packing::streams::orders::{ContainerRules, Sharing};
use ppnpack_packing::streams::stream::StreamPlay;
use serde::Serialize;
use serde_json::{Value, json};

use crate::apart::Apart;
use crate::packer::Packer;
use crate::runs::RunsOptions;
use crate::way::Way;
use packing::{Packing, Run};
use source::{Arrivals, SourceOptions};

/// The most containers that are open at the same time.
const MOST_OPEN: u8 = 16;

/// Packs streams into one container after another and into several at the same time, and compares
/// how full they are closed. With orders the first line has one order at a time, in containers of
/// its own
#[derive(Debug, Args)]
pub(crate) struct StreamArguments {
    #[command(flatten)]
    catalogue: CatalogueOptions,

    #[command(flatten)]
    source: SourceOptions,

    /// Pairs of groups of the orders' table that never share a container, such as food:chemicals
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
        let is_right = |stream: &Arrivals, run: &Run| run.objects == stream.objects;
        let make = |stream: &Arrivals| packing.pack(stream);
        let runs = arguments.runs.kept("stream", &settings)?;
        runs.make(&streams, Arrivals::name, is_right, make)?;
        Ok(json!({ "setting": setting, "folder": runs.name() }))
    };
    let lines = arguments.settings();
    let lines: Vec<Value> = lines.iter().map(pack).collect::<Outcome<_>>()?;
    let results = json!({
        "first_stream": arguments.first,
        "streams": arguments.streams,
        "source": source.said(arguments.items),
        "way": packer.way,
        "runs": streams.iter().map(Arrivals::name).collect::<Vec<_>>(),
        "lines": lines,
    });
    arguments.runs.publish("stream", results, "stream")
}

fn parse_pair(text: &str) -> Result<(String, String), String> {
    let pair = text.split_once(':');
    let (a, b) =
        pair.ok_or_else(|| format!("'{text}' is no pair: write it like food:chemicals"))?;
    Ok((a.trim().to_owned(), b.trim().to_owned()))
}
