//! The items of a step as messages, each sent to an instance once.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use ppnpack_packing::kernel::item::{Item, ShapeId};
use ppnpack_packing::ranking::step::StepInput;
use ppnpack_service::rpc::CallError;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::keys::Instance;
use ppnpack_wire::rpc::Request;
use ppnpack_wire::{convert, v1};

use super::peers::Peers;

/// Maximum number of items remembered; then all are forgotten and written anew.
const MAX_KEPT: usize = 4_096;

/// Items as messages, and the instances that have them.
#[derive(Debug, Default)]
pub(crate) struct ItemMessages {
    messages: HashMap<ShapeId, (ItemId, Arc<v1::Item>)>,
    sent: HashMap<Instance, HashSet<ItemId>>,
}

impl ItemMessages {
    /// Asks an instance about the candidates of a step, with those items that it may lack.
    pub(crate) fn ask<R: Request>(
        &mut self,
        peers: &Peers,
        instance: &Instance,
        input: &StepInput<'_>,
        request: impl Fn(&[ItemId], Vec<v1::Item>) -> R,
    ) -> Result<R::Reply, CallError> {
        let deadline = peers.deadline(input);
        if self.messages.len() > MAX_KEPT {
            *self = Self::default();
        }
        let items = || input.candidates.iter().map(|held| &*held.item);
        let ids: Vec<ItemId> = items().map(|item| self.message(item).0).collect();
        let Peers { cell, client, .. } = peers;
        let asking = request(&ids, self.unsent(instance, items()));
        let asked = match client.call_instance(cell, instance, asking, deadline) {
            Err(error) if error.status() == Some(v1::Status::MissingItems) => {
                // It was started anew, or let items go.
                self.sent.remove(instance);
                let asking = request(&ids, self.unsent(instance, items()));
                client.call_instance(cell, instance, asking, deadline)
            }
            asked => asked,
        };
        if asked.is_ok() {
            let sent = self.sent.entry(instance.clone()).or_default();
            if sent.len() > MAX_KEPT {
                sent.clear();
            }
            sent.extend(ids);
        }
        asked
    }

    /// Gives the messages of the items that an instance was not sent yet, each once.
    fn unsent<'a>(
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

    fn message(&mut self, item: &Item) -> (ItemId, Arc<v1::Item>) {
        let kept = self.messages.entry(item.shape()).or_insert_with(|| {
            let message = convert::item::write(item);
            (ItemId::of(&message), Arc::new(message))
        });
        (kept.0, Arc::clone(&kept.1))
    }
}
