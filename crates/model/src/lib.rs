//! What a placement proposal network is and was trained with: its architecture, how it was trained, its weights and
//! model card. Nothing here needs libtorch.

pub mod architecture;
pub mod card;
pub mod report;
pub mod settings;
pub mod weights;
