//! Objects of a catalogue.

use std::iter::once;
use std::sync::Arc;

use nalgebra::UnitQuaternion;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::ranking::candidate::Lying;
use ppnpack_packing::ranking::step::Candidate;
pub use ppnpack_packing::scene::model::{ConvexPiece, MassProperties, Model, RestingPose};

/// An object ready to be packed at one resolution.
#[derive(Debug, Clone)]
pub struct CatalogueObject {
    /// Its geometry.
    pub model: Arc<Model>,
    /// Its heightmap pairs, one per yaw of the resolution; its name is the model's.
    pub item: Arc<Item>,
    /// The further poses in which it may be packed, the most probable first.
    pub poses: Vec<PosedObject>,
}

/// An object in another resting pose than that of its model in the catalogue.
#[derive(Debug, Clone)]
pub struct PosedObject {
    /// The model, turned into the pose; it has the same name.
    pub model: Arc<Model>,
    /// The heightmap pairs of the turned model.
    pub item: Arc<Item>,
    /// Turn: the object's own frame in that of the heightmaps. Their origins are the same.
    pub rotation: UnitQuaternion<f64>,
}

impl CatalogueObject {
    /// The object as an item that arrives, standing as it does in the catalogue.
    pub fn candidate(&self, arrival: usize) -> Candidate {
        Candidate::new(arrival, Arc::clone(&self.item)).with_model(Arc::clone(&self.model))
    }

    /// The object as an item that arrives, in each pose in which it may be packed: first as it
    /// stands in the catalogue.
    pub fn candidates(&self, arrival: usize) -> Vec<Candidate> {
        let further = (1..).zip(&self.poses).map(|(pose, posed)| Candidate {
            pose,
            lying: Lying {
                heightmap_from_item: Some(nalgebra::convert(posed.rotation)),
                waits_at: None,
            },
            ..Candidate::new(arrival, Arc::clone(&posed.item)).with_model(Arc::clone(&posed.model))
        });
        once(self.candidate(arrival)).chain(further).collect()
    }
}
