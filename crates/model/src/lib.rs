//! Models of placement proposal networks: architecture, training settings, weights and model card.
//! Nothing here needs libtorch.
//!
//! ```
//! use ppnpack_model::weights::Model;
//!
//! let model = Model::shipped()?;
//! let architecture = &model.card().architecture;
//! println!("{} weights for {architecture:?}", model.tensors().len());
//! # Ok::<(), ppnpack_model::weights::ModelError>(())
//! ```

pub mod accuracy;
pub mod architecture;
pub mod card;
pub mod report;
pub mod settings;
pub mod weights;
