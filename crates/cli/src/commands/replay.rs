//! `ppnpack replay`: the decisions of a recording, planned again and compared.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use ppnpack_planner::replay::{Replayer, what_follows};
use ppnpack_recording::{Difference, Reader, RecordedMessage, Topic, difference};
use ppnpack_wire::keys::Stream;
use ppnpack_wire::shape_store::ShapeStore;
use ppnpack_wire::{MAX_MESSAGE_BYTES, decode, v1};
use serde::Serialize;

use crate::failure::{OrInput, OrRun, Outcome};
use crate::output;
use crate::text::template;

/// Plans each step of recordings again, and compares bit for bit with what was decided. Ends with 1
/// where a step goes otherwise.
#[derive(Debug, Args)]
pub(crate) struct ReplayArguments {
    /// MCAP files of `ppnpack record`
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,

    /// Plan again also what another release of the software has planned
    #[arg(long)]
    any_version: bool,

    /// Print JSON instead of text, a line for each file
    #[arg(long)]
    json: bool,
}

/// The outcome for the steps of a recording.
#[derive(Debug, Default, Serialize)]
struct Replayed {
    /// Steps that went as they were recorded.
    equal: u64,
    /// Steps that went otherwise.
    different: Vec<Other>,
    /// Steps that were not planned again, by reason.
    not_replayed: BTreeMap<String, u64>,
    /// Whether its recorder ended the file.
    is_whole: bool,
    /// The file's damage, where there is some.
    #[serde(skip_serializing_if = "Option::is_none")]
    damage: Option<String>,
}

/// A step that went otherwise than it was recorded.
#[derive(Debug, Serialize)]
struct Other {
    cell: String,
    session: String,
    step: u64,
    field: String,
    recorded: String,
    replayed: String,
}

pub(crate) fn run(arguments: &ReplayArguments) -> Outcome {
    output::of_each(&arguments.files, arguments.json, |file| {
        again(file, arguments)
    })
}

fn again(file: &Path, arguments: &ReplayArguments) -> Outcome {
    let replayed = replay(file, arguments.any_version)?;
    output::print(&replayed, arguments.json, template!("replay.txt"))?;
    if let Some(first) = replayed.different.first() {
        let Other {
            cell,
            session,
            step,
            field,
            recorded,
            replayed: now,
        } = first;
        let count = replayed.different.len();
        let why = anyhow!(
            "{count} steps go otherwise than they were recorded: cell {cell}, session {session}, \
             step {step}: {field} is recorded as {recorded}, and is now {now}"
        );
        return Err(why.into());
    }
    match replayed.damage {
        Some(damage) => Err(anyhow!(damage).into()),
        None => Ok(()),
    }
}

fn replay(file: &Path, is_any_version: bool) -> Outcome<Replayed> {
    let mut reader = Reader::open(file).or_input()?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let replayer = Replayer::new(cores).map_err(|error| anyhow!(error));
    let mut replay = Replay {
        replayer: replayer.or_run()?,
        shapes: ShapeStore::default(),
        is_any_version,
        replayed: Replayed::default(),
    };
    loop {
        match reader.next_message() {
            Ok(Some(message)) => replay.take(&message)?,
            Ok(None) => break,
            Err(error @ ppnpack_recording::RecordingError::Damaged { .. }) => {
                replay.replayed.damage = Some(error.to_string());
                break;
            }
            Err(error) => return Err(anyhow::Error::from(error).into()),
        }
    }
    let mut replayed = replay.replayed;
    let lost = reader.dropped().iter().filter_map(|(topic, dropped)| {
        let topic = Topic::parse(topic)?;
        matches!(topic, Topic::Stream(_, Stream::Record)).then_some(*dropped)
    });
    let lost: u64 = lost.sum();
    if lost > 0 {
        let why = "they came faster than they could be recorded".to_owned();
        replayed.not_replayed.insert(why, lost);
    }
    replayed.is_whole = reader.is_whole();
    Ok(replayed)
}

/// Replaying, message after message.
struct Replay {
    replayer: Replayer,
    shapes: ShapeStore,
    is_any_version: bool,
    replayed: Replayed,
}

impl Replay {
    fn take(&mut self, message: &RecordedMessage) -> Outcome {
        match Topic::parse(&message.topic) {
            Some(Topic::Shape(_)) => {
                // One that cannot be read is not there for the steps that name it.
                if let Ok(shape) = decode::<v1::Shape>(&message.payload, MAX_MESSAGE_BYTES) {
                    self.shapes.add(shape);
                }
            }
            Some(Topic::Stream(_, Stream::Record)) => {
                match decode::<v1::PlanningRecord>(&message.payload, MAX_MESSAGE_BYTES) {
                    Ok(record) => self.step(&record)?,
                    Err(error) => self.leave_out(format!("the record cannot be read: {error}")),
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn step(&mut self, record: &v1::PlanningRecord) -> Outcome {
        let own = env!("CARGO_PKG_VERSION");
        let software = record.versions.clone().unwrap_or_default().software;
        if software != own && !self.is_any_version {
            let why = "--any-version plans it all the same";
            self.leave_out(format!(
                "release {software} planned it, and this is {own}: {why}"
            ));
            return Ok(());
        }
        let replayed = match self.replayer.replay(record, &self.shapes) {
            Ok(replayed) => replayed,
            Err(error) => {
                self.leave_out(error.to_string());
                return Ok(());
            }
        };
        let recorded = record.decision.as_ref().map(what_follows);
        match compare(recorded.as_ref(), replayed.as_ref())? {
            None => self.replayed.equal += 1,
            Some(difference) => self.replayed.different.push(Other {
                cell: record.cell.clone(),
                session: record.session_id.clone(),
                step: record.step,
                field: difference.field,
                recorded: difference.first,
                replayed: difference.second,
            }),
        }
        Ok(())
    }

    fn leave_out(&mut self, why: String) {
        *self.replayed.not_replayed.entry(why).or_default() += 1;
    }
}

/// Gives the first difference between what was decided and what is decided again.
fn compare(
    recorded: Option<&v1::Decision>,
    replayed: Option<&v1::Decision>,
) -> Outcome<Option<Difference>> {
    let said = |decision: Option<&v1::Decision>| match decision {
        Some(decision) => format!("item '{}' is placed", decision.item_id),
        None => "nothing has a valid placement".to_owned(),
    };
    match (recorded, replayed) {
        (Some(recorded), Some(replayed)) => difference(recorded, replayed).or_run(),
        (None, None) => Ok(None),
        (recorded, replayed) => Ok(Some(Difference {
            field: "decision".to_owned(),
            first: said(recorded),
            second: said(replayed),
        })),
    }
}
