//! The items and solids that records name by their ids.

use std::collections::HashMap;
use std::sync::Arc;

use ppnpack_packing::kernel::item::{Item, ShapeId};
use ppnpack_packing::scene::model::Model;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::{convert, v1};
use prost::Message;

/// Maximum bytes, as they are encoded, that are kept before all is forgotten.
const MOST_KEPT_BYTES: usize = 256 << 20;

/// Maximum bytes in one answer.
const MOST_ANSWERED_BYTES: usize = 8 << 20;

/// Items and solids that records named, kept for who asks for them.
#[derive(Default)]
pub(crate) struct Shapes {
    items: HashMap<ShapeId, Vec<u8>>,
    /// Solids by their address in memory, which stays theirs as long as they are kept here.
    solids: HashMap<usize, (Arc<Model>, Vec<u8>)>,
    kept: HashMap<Vec<u8>, Kept>,
    kept_bytes: usize,
}

enum Kept {
    Item(Arc<Item>),
    Solid(Arc<Model>),
}

impl Shapes {
    /// Forgets all where that is much. What a record names is kept until the next one is made.
    pub(crate) fn make_room(&mut self) {
        if self.kept_bytes > MOST_KEPT_BYTES {
            *self = Self::default();
        }
    }

    pub(crate) fn item(&mut self, item: &Arc<Item>) -> Vec<u8> {
        if let Some(id) = self.items.get(&item.shape()) {
            return id.clone();
        }
        let message = convert::item::write(item);
        let id = ItemId::of(&message).to_bytes();
        self.kept_bytes += message.encoded_len();
        self.items.insert(item.shape(), id.clone());
        self.kept.insert(id.clone(), Kept::Item(Arc::clone(item)));
        id
    }

    pub(crate) fn solid(&mut self, model: &Arc<Model>) -> Vec<u8> {
        let at = Arc::as_ptr(model).addr();
        if let Some((_, id)) = self.solids.get(&at) {
            return id.clone();
        }
        let message = convert::solid::write(model);
        let id = ItemId::of_solid(&message).to_bytes();
        self.kept_bytes += message.encoded_len();
        self.solids.insert(at, (Arc::clone(model), id.clone()));
        self.kept.insert(id.clone(), Kept::Solid(Arc::clone(model)));
        id
    }

    /// Gives the shapes of these ids, as many as go into one message.
    pub(crate) fn reply(&self, ids: &[Vec<u8>]) -> v1::ShapesReply {
        let mut reply = v1::ShapesReply::default();
        let mut bytes = 0;
        for id in ids {
            let Some(kept) = self.kept.get(id) else {
                reply.unknown.push(id.clone());
                continue;
            };
            let shape = v1::Shape {
                id: id.clone(),
                shape: Some(match kept {
                    Kept::Item(item) => v1::shape::Shape::Item(convert::item::write(item)),
                    Kept::Solid(model) => v1::shape::Shape::Solid(convert::solid::write(model)),
                }),
            };
            bytes += shape.encoded_len();
            if bytes > MOST_ANSWERED_BYTES && !reply.shapes.is_empty() {
                break;
            }
            reply.shapes.push(shape);
        }
        reply
    }
}
