//! The items and solids that records of planned steps name.

use std::collections::HashMap;
use std::sync::Arc;

use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::scene::model::Model;

use crate::convert;
use crate::item_id::ItemId;
use crate::v1::{self, shape::Shape};

/// Keeps items and solids by their ids.
#[derive(Debug, Default)]
pub struct ShapeStore {
    items: HashMap<Vec<u8>, Arc<Item>>,
    solids: HashMap<Vec<u8>, Arc<Model>>,
}

impl ShapeStore {
    /// Takes a shape in. One that cannot be read, or has another's id, is left out.
    pub fn add(&mut self, shape: v1::Shape) {
        match &shape.shape {
            Some(Shape::Item(item)) if ItemId::of(item).to_bytes() == shape.id => {
                let read = convert::item::read(item).ok();
                self.items.extend(read.map(|it| (shape.id, Arc::new(it))));
            }
            Some(Shape::Solid(solid)) if ItemId::of_solid(solid).to_bytes() == shape.id => {
                let read = convert::solid::read(solid).ok();
                self.solids.extend(read.map(|it| (shape.id, Arc::new(it))));
            }
            _ => {}
        }
    }

    /// Gives an item by its id.
    pub fn item(&self, id: &[u8]) -> Option<&Arc<Item>> {
        self.items.get(id)
    }

    /// Gives a solid by its id.
    pub fn solid(&self, id: &[u8]) -> Option<&Arc<Model>> {
        self.solids.get(id)
    }

    /// Counts the items and solids.
    pub fn count(&self) -> usize {
        self.items.len() + self.solids.len()
    }
}
