//! The items and solids that records name, asked for and kept.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use ppnpack_packing::item::Item;
use ppnpack_packing::model::Model;
use ppnpack_service::rpc::Client;
use ppnpack_service::shapes;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::{convert, v1};

/// How long a planner may take to answer: it plans a step before.
const PATIENCE: Duration = Duration::from_secs(5);

/// Shapes that are kept before all are forgotten and asked for anew.
const MOST_KEPT: usize = 1_024;

/// Items and solids by their ids.
pub(crate) struct Shapes {
    client: Client,
    items: HashMap<Vec<u8>, Arc<Item>>,
    solids: HashMap<Vec<u8>, Arc<Model>>,
}

impl Shapes {
    pub(crate) fn new(client: Client) -> Self {
        Self {
            client,
            items: HashMap::new(),
            solids: HashMap::new(),
        }
    }

    pub(crate) fn item(&self, id: &[u8]) -> Option<&Arc<Item>> {
        self.items.get(id)
    }

    pub(crate) fn solid(&self, id: &[u8]) -> Option<&Arc<Model>> {
        self.solids.get(id)
    }

    /// Asks for what a record names and is not kept yet; what nobody has is left out.
    pub(crate) fn fetch(&mut self, cell: &Cell, record: &v1::PlanningRecord) {
        if self.items.len() + self.solids.len() > MOST_KEPT {
            self.items.clear();
            self.solids.clear();
        }
        let mut missing = shapes::named(record);
        missing.retain(|id| !self.items.contains_key(id) && !self.solids.contains_key(id));
        let deadline = Instant::now() + PATIENCE;
        let mut fetched = Vec::new();
        let keep = |shape| fetched.push(shape);
        if let Err(error) = shapes::fetch(&self.client, cell, missing, deadline, keep) {
            tracing::debug!(%cell, %error, "not all shapes");
        }
        fetched.into_iter().for_each(|shape| self.keep(shape));
    }

    fn keep(&mut self, shape: v1::Shape) {
        match shape.shape {
            Some(v1::shape::Shape::Item(item)) => {
                let item = convert::item::read(&item).ok();
                self.items
                    .extend(item.map(|item| (shape.id, Arc::new(item))));
            }
            Some(v1::shape::Shape::Solid(solid)) => {
                let solid = convert::solid::read(&solid).ok();
                self.solids
                    .extend(solid.map(|solid| (shape.id, Arc::new(solid))));
            }
            None => {}
        }
    }
}
