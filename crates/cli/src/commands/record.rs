//! `ppnpack record`: records what cells do, into MCAP files.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::Context;
use clap::Args;
use clap::builder::PossibleValuesParser;
use ppnpack_recording::{RecordSettings, Recorded, Recorder, Rotation, Topic};
use ppnpack_service::Shutdown;
use ppnpack_wire::keys::{Cell, Stream};

use crate::failure::{OrInput, OrRun, Outcome};
use crate::output::print_line;
use crate::quantity::{parse_bytes, parse_time};
use crate::stack::connect::ConnectOptions;

/// Interval at which it is looked whether the recording still goes on.
const LOOK: Duration = Duration::from_millis(200);

/// Records what cells publish, with all that each decision depends on, until Ctrl-C: MCAP files
/// that Foxglove opens, and that `ppnpack inspect` and `ppnpack replay` read. What came is in the
/// file within a second.
#[derive(Debug, Args)]
pub(crate) struct RecordArguments {
    /// The folder of the files; it is made
    #[arg(long, value_name = "DIR")]
    out: PathBuf,

    /// A cell or a container to record (may be repeated) [default: all]
    #[arg(long, value_name = "NAME", value_parser = |text: &str| Cell::new(text))]
    cell: Vec<Cell>,

    /// A part to leave out (may be repeated)
    #[arg(long, value_name = "STREAM", value_parser = PossibleValuesParser::new(parts()))]
    without: Vec<String>,

    /// Go on in another file where one has this size
    #[arg(long, value_name = "SIZE", default_value = "1GiB", value_parser = parse_bytes)]
    rotate_size: u64,

    /// Go on in another file where one was begun so long ago, such as 1h
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    rotate_age: Option<Duration>,

    /// Keep no more than so many recordings in the folder: the oldest are deleted [default: all]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..))]
    keep: Option<u32>,

    /// The most that may wait to be written; more is dropped and counted
    #[arg(long, value_name = "SIZE", default_value = "256MiB", value_parser = parse_bytes)]
    queue: u64,

    /// End after so long [default: with Ctrl-C]
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    time: Option<Duration>,

    #[command(flatten)]
    connection: ConnectOptions,
}

/// Names the parts that can be left out of a recording.
fn parts() -> impl Iterator<Item = &'static str> {
    let streams = Stream::ALL.iter().map(|stream| stream.as_str());
    streams.chain([Topic::HEALTH])
}

pub(crate) fn run(arguments: &RecordArguments) -> Outcome {
    let folder = &arguments.out;
    std::fs::create_dir_all(folder)
        .with_context(|| format!("{} cannot be made", folder.display()))
        .or_input()?;
    let shutdown = Shutdown::default();
    let asked = shutdown.clone();
    ctrlc::set_handler(move || asked.request()).or_run()?;
    let session = arguments.connection.open()?;
    let recorder = Recorder::start(&session, &arguments.settings()).or_run()?;
    let folder = folder.display();
    print_line(&format!("Recording into {folder}. Ctrl-C ends it."))?;
    let end = arguments.time.map(|time| Instant::now() + time);
    let is_over = || recorder.has_ended() || end.is_some_and(|end| Instant::now() >= end);
    while !is_over() && !shutdown.wait_timeout(LOOK) {}
    let recorded = recorder.finish().or_run()?;
    Ok(print_line(&told(&recorded))?)
}

impl RecordArguments {
    fn settings(&self) -> RecordSettings {
        let has = |part: &str| self.without.iter().all(|left_out| left_out != part);
        let streams = Stream::ALL.iter().copied();
        RecordSettings {
            folder: self.out.clone(),
            cells: self.cell.clone(),
            streams: streams.filter(|stream| has(stream.as_str())).collect(),
            has_health: has(Topic::HEALTH),
            rotation: Rotation {
                size_bytes: self.rotate_size,
                age: self.rotate_age,
                keep: self.keep.map(|keep| keep as usize),
            },
            queue_bytes: usize::try_from(self.queue).unwrap_or(usize::MAX),
        }
    }
}

/// Says what was recorded, for people.
fn told(recorded: &Recorded) -> String {
    let Recorded {
        files,
        messages,
        dropped,
    } = recorded;
    let files = files.iter().map(|file| format!("  {}", file.display()));
    let dropped = dropped.iter().map(|(topic, count)| {
        format!("Dropped of {topic}: {count}, as they came faster than they could be written")
    });
    let first = format!("Recorded {messages} messages:");
    let lines: Vec<String> = std::iter::once(first).chain(files).chain(dropped).collect();
    lines.join("\n")
}
