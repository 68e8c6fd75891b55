//! The items of a step as messages, each sent to an instance once.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use ppnpack_packing::item::{Item, ShapeId};
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::keys::Instance;
use ppnpack_wire::{convert, v1};

/// Items remembered at most; then all are forgotten and written anew.
const MAX_KEPT: usize = 4_096;

/// Items as messages, and who has them.
#[derive(Debug, Default)]
pub(crate) struct ItemMessages {
    messages: HashMap<ShapeId, (ItemId, Arc<v1::Item>)>,
    sent: HashMap<Instance, HashSet<ItemId>>,
}

impl ItemMessages {
    /// The ids of items, in their order.
    pub(crate) fn ids<'a>(&mut self, items: impl Iterator<Item = &'a Item>) -> Vec<ItemId> {
        if self.messages.len() > MAX_KEPT {
            *self = Self::default();
        }
        items.map(|item| self.message(item).0).collect()
    }

    /// The messages of those items that an instance was not sent yet, each once.
    pub(crate) fn unsent<'a>(
        &mut self,
        instance: &Instance,
        items: impl Iterator<Item = &'a Item>,
    ) -> Vec<v1::Item> {
        let sent = self.sent.get(instance).cloned().unwrap_or_default();
        let mut named = HashSet::new();
        items
            .map(|item| self.message(item))
            .filter(|(id, _)| !sent.contains(id) && named.insert(*id))
            .map(|(_, message)| v1::Item::clone(&message))
            .collect()
    }

    /// Remembers that an instance has these items now.
    pub(crate) fn has(&mut self, instance: &Instance, ids: &[ItemId]) {
        let sent = self.sent.entry(instance.clone()).or_default();
        if sent.len() > MAX_KEPT {
            sent.clear();
        }
        sent.extend(ids);
    }

    /// Forgets what an instance was sent: it was started anew, or let items go.
    pub(crate) fn forget(&mut self, instance: &Instance) {
        self.sent.remove(instance);
    }

    fn message(&mut self, item: &Item) -> (ItemId, Arc<v1::Item>) {
        let kept = self.messages.entry(item.shape()).or_insert_with(|| {
            let message = convert::item::write(item);
            (ItemId::of(&message), Arc::new(message))
        });
        (kept.0, Arc::clone(&kept.1))
    }
}
