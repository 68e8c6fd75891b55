//! Recordings of packing cells: [MCAP](https://mcap.dev) files with what the cells published, and
//! all that each decision depended on.
//!
//! [`Recorder`] writes them as the cells work. It reads the cells' streams through a bounded queue,
//! and counts in the file whatever does not fit. [`Reader`] reads them, also those whose recorder
//! was killed, and [`Contents`] says what is in one. [`difference`] finds what two messages do not
//! have alike.
//!
//! A file has a channel for each stream of each cell, such as `/cell-1/plan`, with the protobuf
//! schema of its messages. What steps were planned on is on `/cell-1/record`; the items and solids
//! that this names are on `/cell-1/shape`, each once, and before they are named. What services say
//! of their health is on `/all/health`.

mod contents;
mod difference;
mod error;
mod file;
mod health;
mod queue;
mod reader;
mod recorder;
mod rotation;
mod shapes;
mod topic;

pub use contents::{Contents, Decisions, TopicContents};
pub use difference::{Difference, difference};
pub use error::RecordingError;
pub use reader::{Reader, RecordedMessage};
pub use recorder::{RecordSettings, Recorded, Recorder};
pub use rotation::{Rotation, utc};
pub use topic::Topic;
