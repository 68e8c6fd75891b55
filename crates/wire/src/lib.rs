//! The wire of ppnpack, and the only crate that knows it: protobuf messages, key expressions and
//! checked conversions.
//!
//! [`v1`] has the messages as the schemas in `proto/` define them. Data that comes from outside
//! goes through [`decode`], which bounds its size and structure, and through the functions of
//! [`convert`], which check values and give types of the domain. [`keys`] builds and parses every
//! key expression. [`ros`] reads the clouds of ROS 2.
//!
//! ```
//! use ppnpack_wire::keys::{Cell, Key, Method, Service};
//!
//! let plan = Key::Request(Some(Cell::new("north")?), Service::Planner, Method::Plan, None);
//! assert_eq!(Key::parse(&plan.to_string())?, plan);
//! assert!(Key::parse("somebody/else").is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod convert;
mod decode;
pub mod error;
pub mod header;
pub mod item_id;
pub mod item_store;
pub mod keys;
pub mod limits;
pub mod ros;
pub mod rpc;
pub mod schemas;
pub mod shape_store;
mod structure;

pub use decode::{MAX_CLOUD_BYTES, MAX_MESSAGE_BYTES, decode, encoding_of};
pub use error::WireError;
pub use structure::schema;

/// The messages, as `proto/ppnpack/v1` defines them.
#[allow(missing_docs, clippy::all, clippy::pedantic)]
pub mod v1 {
    include!(concat!(env!("OUT_DIR"), "/ppnpack.v1.rs"));
}
