//! The items and solids of a recording.

use std::collections::HashMap;
use std::sync::Arc;

use ppnpack_packing::item::Item;
use ppnpack_packing::model::Model;
use ppnpack_planner::replay::{ShapeSource, Unreadable};
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::{MAX_MESSAGE_BYTES, convert, decode, v1};

/// The items and solids of a recording, as far as it was read; each is decoded when it is first needed.
#[derive(Default)]
pub(super) struct RecordedShapes {
    encoded: HashMap<Vec<u8>, Vec<u8>>,
    items: HashMap<Vec<u8>, Arc<Item>>,
    solids: HashMap<Vec<u8>, Arc<Model>>,
}

impl RecordedShapes {
    /// Adds an encoded shape. One that cannot be read is not there for the steps that name it.
    pub(super) fn add(&mut self, payload: &[u8]) {
        if let Ok(shape) = decode::<v1::Shape>(payload, MAX_MESSAGE_BYTES) {
            self.encoded
                .entry(shape.id)
                .or_insert_with(|| payload.to_vec());
        }
    }

    fn shape(&self, id: &[u8]) -> Option<v1::shape::Shape> {
        let shape = decode::<v1::Shape>(self.encoded.get(id)?, MAX_MESSAGE_BYTES).ok()?;
        shape.shape.filter(|shape| is_named(shape, id))
    }
}

/// Whether a shape is what its id says: damaged ones are not planned with.
fn is_named(shape: &v1::shape::Shape, id: &[u8]) -> bool {
    let own = match shape {
        v1::shape::Shape::Item(item) => ItemId::of(item),
        v1::shape::Shape::Solid(solid) => ItemId::of_solid(solid),
    };
    own.to_bytes() == id
}

impl ShapeSource for RecordedShapes {
    fn item(&mut self, id: &[u8]) -> Result<Arc<Item>, Unreadable> {
        if let Some(item) = self.items.get(id) {
            return Ok(Arc::clone(item));
        }
        let Some(v1::shape::Shape::Item(item)) = self.shape(id) else {
            return Err(lacks("item", id));
        };
        let item = Arc::new(convert::item::read(&item)?);
        self.items.insert(id.to_vec(), Arc::clone(&item));
        Ok(item)
    }

    fn solid(&mut self, id: &[u8]) -> Result<Arc<Model>, Unreadable> {
        if let Some(solid) = self.solids.get(id) {
            return Ok(Arc::clone(solid));
        }
        let Some(v1::shape::Shape::Solid(solid)) = self.shape(id) else {
            return Err(lacks("solid", id));
        };
        let solid = Arc::new(convert::solid::read(&solid)?);
        self.solids.insert(id.to_vec(), Arc::clone(&solid));
        Ok(solid)
    }
}

fn lacks(what: &'static str, id: &[u8]) -> Unreadable {
    let digits = id.iter().take(8).map(|byte| format!("{byte:02x}"));
    let id = digits.collect();
    Unreadable::Lacks { what, id }
}
