//! The contents of a recording.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use ppnpack_wire::keys::Stream;
use ppnpack_wire::{MAX_MESSAGE_BYTES, decode, v1};
use serde::Serialize;

use crate::error::RecordingError;
use crate::reader::{Reader, RecordedMessage};
use crate::topic::Topic;

/// The contents of a recording.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Contents {
    /// The program that wrote it.
    pub library: String,
    /// Whether its recorder ended it; otherwise that was killed, or is still writing it.
    pub is_whole: bool,
    /// The fault of a damaged file; all messages before it are counted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damage: Option<String>,
    /// When the first and the last message came, in nanoseconds since 1970; 0 where there is none.
    pub first_ns: u64,
    /// See [`Self::first_ns`].
    pub last_ns: u64,
    /// The channels by their names.
    pub topics: BTreeMap<String, TopicContents>,
    /// The cells and containers that published something.
    pub cells: BTreeSet<String>,
    /// The steps that were planned, as records have them.
    pub decisions: Decisions,
    /// The software that planned them: release, configuration and instance of each planner.
    pub planners: BTreeSet<String>,
}

/// The contents of a channel.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct TopicContents {
    /// The full name of the messages.
    pub schema: String,
    /// How many there are.
    pub messages: u64,
    /// How much they are, in bytes, before they were compressed.
    pub bytes: u64,
    /// How many did not get into it.
    pub dropped: u64,
}

/// The steps that were planned, as records have them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Decisions {
    /// Steps that led to a decision.
    pub decided: u64,
    /// Steps in which nothing had a valid placement.
    pub nothing_fitted: u64,
    /// Steps whose time was over before everything was looked at.
    pub cut: u64,
}

impl Contents {
    /// Reads a recording to its end, or to where it is damaged.
    ///
    /// # Errors
    /// [`RecordingError`] where it cannot be read, or is no recording at all.
    pub fn of(path: &Path) -> Result<Self, RecordingError> {
        let mut reader = Reader::open(path)?;
        let mut contents = Self {
            library: reader.library().to_owned(),
            ..Self::default()
        };
        loop {
            match reader.next_message() {
                Ok(Some(message)) => contents.add(&message),
                Ok(None) => break,
                Err(error @ RecordingError::Damaged { .. }) => {
                    contents.damage = Some(error.to_string());
                    break;
                }
                Err(error) => return Err(error),
            }
        }
        for (topic, dropped) in reader.dropped() {
            contents.topics.entry(topic.clone()).or_default().dropped = *dropped;
        }
        contents.is_whole = reader.is_whole();
        Ok(contents)
    }

    fn add(&mut self, message: &RecordedMessage) {
        let channel = self.topics.entry(message.topic.to_string()).or_default();
        channel.schema = message.schema.to_string();
        channel.messages += 1;
        channel.bytes += message.payload.len() as u64;
        self.last_ns = self.last_ns.max(message.at_ns);
        self.first_ns = match self.first_ns {
            0 => message.at_ns,
            first_ns => first_ns.min(message.at_ns),
        };
        let Some(topic) = Topic::parse(&message.topic) else {
            return;
        };
        self.cells.extend(topic.cell().map(ToString::to_string));
        if matches!(topic, Topic::Stream(_, Stream::Record))
            && let Ok(record) = decode::<v1::PlanningRecord>(&message.payload, MAX_MESSAGE_BYTES)
        {
            self.add_record(record);
        }
    }

    fn add_record(&mut self, record: v1::PlanningRecord) {
        match record.decision {
            Some(_) => self.decisions.decided += 1,
            None => self.decisions.nothing_fitted += 1,
        }
        self.decisions.cut += u64::from(record.is_cut);
        if let Some(versions) = record.versions {
            let told = [versions.software, versions.configuration, versions.instance];
            let told: Vec<String> = told.into_iter().filter(|part| !part.is_empty()).collect();
            self.planners.insert(told.join(" "));
        }
    }
}
