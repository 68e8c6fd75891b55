//! The placement proposal network (PPN) on libtorch: model, loss, training, inference.
//!
//! This is the only crate that links libtorch. [`training::train`] makes a model from a dataset;
//! [`proposer::NetworkProposer`] proposes placements with one.

mod error;
mod files;
mod inference;
mod maps;
mod network;
pub mod proposer;
mod runtime;
mod symmetry;
pub mod training;

pub use error::NetworkError;
pub use runtime::LIBTORCH_VERSION;
