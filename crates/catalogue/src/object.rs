//! What a catalogue holds of each object.

use std::sync::Arc;

use ppnpack_packing::candidate::Candidate;
use ppnpack_packing::item::Item;
pub use ppnpack_packing::model::{ConvexPiece, MassProperties, Model, RestingPose};

/// An object ready to be packed at one resolution.
#[derive(Debug, Clone)]
pub struct CatalogueObject {
    /// Its geometry.
    pub model: Arc<Model>,
    /// Its heightmap pairs, one per yaw of the resolution; its name is the model's.
    pub item: Arc<Item>,
}

impl CatalogueObject {
    /// The object as an item that arrives, standing as it is packed.
    pub fn candidate(&self, arrival: usize) -> Candidate {
        Candidate::new(arrival, Arc::clone(&self.item)).with_model(Arc::clone(&self.model))
    }
}
