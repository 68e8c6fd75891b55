//! Training data of placement proposal networks: what an exhaustive expert sees and prefers, step
//! by step.
//!
//! A dataset is a folder. `settings.json` says what it is made with; `items.safetensors.zst` has
//! the heightmap pairs of all objects; each `sequence-NNNNN.safetensors.zst` the steps of a
//! sequence. A step has the container's heightmap, and for each candidate of the buffer the optimal
//! valid placements per yaw, with all ties, and optionally the value of every placement.
//!
//! Writing: a [`Recorder`] watches an episode and asks the [`Expert`] for the labels; a
//! [`DatasetWriter`] keeps finished sequences so that a killed run goes on where it was. Reading:
//! [`Dataset`].
//!
//! Sequence `i` is drawn from `(seed, i)` alone ([`draw`]), so the files depend neither on how many
//! sequences there are nor on the order in which they were played. [`Split::of`] parts them 9 to 1.
//!
//! ```
//! use ppnpack_dataset::{Split, draw};
//!
//! // The objects of sequence 19: 80 arrivals out of 96 objects.
//! let drawn = draw(7, 19, 80, 96);
//! assert_eq!(drawn.objects.len(), 80);
//! assert_eq!(draw(7, 19, 80, 96).objects, drawn.objects);
//! assert!(Split::of(19) == Split::Test);
//! ```

mod arrays;
mod draw;
mod error;
mod expert;
mod items;
mod reader;
mod record;
mod recorder;
mod sequence;
mod settings;
mod validate;
mod values;
mod writer;

pub use draw::{Drawn, draw};
pub use error::DatasetError;
pub use expert::Expert;
pub use reader::{Dataset, Split};
pub use record::{CandidateRecord, Corner, SequenceRecord, StepRecord, TIE_TOLERANCE, YawOptima};
pub use recorder::Recorder;
pub use settings::{ExpertSettings, FORMAT_VERSION, SETTINGS_FILE, Settings};
pub use values::{VALUE_STEP, Values, YawValues};
pub use writer::DatasetWriter;
