//! The items and solids that records name, asked for and kept.

use std::time::{Duration, Instant};

use ppnpack_service::rpc::Client;
use ppnpack_service::shapes;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::shape_store::ShapeStore;
use ppnpack_wire::v1;

/// How long a planner may take to answer: it plans a step before.
const PATIENCE: Duration = Duration::from_secs(5);

/// Shapes that are kept before all are forgotten and asked for anew.
const MOST_KEPT: usize = 1_024;

/// Items and solids, and who is asked for more.
pub(crate) struct Shapes {
    client: Client,
    pub(crate) store: ShapeStore,
}

impl Shapes {
    pub(crate) fn new(client: Client) -> Self {
        Self {
            client,
            store: ShapeStore::default(),
        }
    }

    /// Asks for what a record names and is not kept yet; what nobody has is left out.
    pub(crate) fn fetch(&mut self, cell: &Cell, record: &v1::PlanningRecord) {
        if self.store.count() > MOST_KEPT {
            self.store = ShapeStore::default();
        }
        let store = &mut self.store;
        let mut missing = shapes::named(record);
        missing.retain(|id| store.item(id).is_none() && store.solid(id).is_none());
        let deadline = Instant::now() + PATIENCE;
        let keep = |shape| store.add(shape);
        if let Err(error) = shapes::fetch(&self.client, cell, missing, deadline, keep) {
            tracing::debug!(%cell, %error, "not all shapes");
        }
    }
}
