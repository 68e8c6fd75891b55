//! A store of items that were seen before.

use std::collections::HashMap;
use std::sync::Arc;

use ppnpack_packing::kernel::item::Item;
use prost::Message;

use crate::convert;
use crate::error::WireError;
use crate::item_id::ItemId;
use crate::v1;

/// Keeps items up to a size by their ids; those longest unused go first.
#[derive(Debug, Default)]
pub struct ItemStore {
    items: HashMap<ItemId, Kept>,
    capacity_bytes: usize,
    used_bytes: usize,
    uses: u64,
}

#[derive(Debug)]
struct Kept {
    item: Arc<Item>,
    bytes: usize,
    last_used: u64,
}

/// Items that are not in the store.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{} items are not known here: send the request again with them", .0.len())]
pub struct MissingItems(pub Vec<ItemId>);

impl ItemStore {
    /// Makes a store for items of together at most `capacity_bytes`, as they are encoded.
    pub fn new(capacity_bytes: usize) -> Self {
        Self {
            capacity_bytes,
            ..Self::default()
        }
    }

    /// Takes an item in.
    ///
    /// # Errors
    /// [`WireError`] where it is no possible item.
    pub fn add(&mut self, message: &v1::Item) -> Result<(ItemId, Arc<Item>), WireError> {
        let id = ItemId::of(message);
        if let Some(item) = self.get(id) {
            return Ok((id, item));
        }
        let item = Arc::new(convert::item::read(message)?);
        let bytes = message.encoded_len();
        self.make_room(bytes);
        self.used_bytes += bytes;
        let kept = Kept {
            item: Arc::clone(&item),
            bytes,
            last_used: self.uses,
        };
        self.items.insert(id, kept);
        Ok((id, item))
    }

    /// Gives an item that was seen before.
    pub fn get(&mut self, id: ItemId) -> Option<Arc<Item>> {
        self.uses += 1;
        let kept = self.items.get_mut(&id)?;
        kept.last_used = self.uses;
        Some(Arc::clone(&kept.item))
    }

    /// Takes in the items that come with a request and gives those that it names, in its order.
    ///
    /// # Errors
    /// [`WireError`] where one that comes with it is not possible; the inner error where some are
    /// not known.
    pub fn resolve(
        &mut self,
        given: &[v1::Item],
        ids: &[ItemId],
    ) -> Result<Result<Vec<Arc<Item>>, MissingItems>, WireError> {
        // Held on to until the end, as a store that is too small would let them go again.
        let given = given.iter().map(|message| self.add(message));
        let given: HashMap<ItemId, Arc<Item>> = given.collect::<Result<_, _>>()?;
        let mut missing = Vec::new();
        let mut found = Vec::with_capacity(ids.len());
        for id in ids {
            match given.get(id).cloned().or_else(|| self.get(*id)) {
                Some(item) => found.push(item),
                None => missing.push(*id),
            }
        }
        Ok(match missing.is_empty() {
            true => Ok(found),
            false => Err(MissingItems(missing)),
        })
    }

    fn make_room(&mut self, bytes: usize) {
        while self.used_bytes + bytes > self.capacity_bytes {
            let oldest = self.items.iter().min_by_key(|(_, kept)| kept.last_used);
            let Some(id) = oldest.map(|(id, _)| *id) else {
                break;
            };
            if let Some(kept) = self.items.remove(&id) {
                self.used_bytes -= kept.bytes;
            }
        }
    }
}
