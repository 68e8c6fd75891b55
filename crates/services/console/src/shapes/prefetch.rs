//! Shapes, asked for as soon as they are named, so that pictures and volumes are there in time.

use std::collections::HashSet;
use std::sync::Arc;

use ppnpack_service::actor::Actor;
use ppnpack_wire::keys::Cell;

use super::{ShapeId, ShapeStore};
use crate::now_ms;

/// Shapes that a cell's planner named.
#[derive(Debug)]
pub(crate) struct Wanted {
    pub(crate) cell: Cell,
    pub(crate) shapes: HashSet<ShapeId>,
}

/// The actor that asks for shapes, and tells their volumes.
pub(crate) struct Prefetcher {
    pub(crate) store: Arc<ShapeStore>,
}

impl Actor for Prefetcher {
    type Message = Wanted;

    fn handle(&mut self, wanted: Wanted) {
        let Wanted { cell, shapes } = wanted;
        let is_missing = |id: &&ShapeId| self.store.kept(id).is_none();
        let missing: HashSet<ShapeId> = shapes.iter().filter(is_missing).copied().collect();
        if !missing.is_empty()
            && let Err(error) = self.store.fetch(&cell, &missing)
        {
            tracing::debug!(%cell, %error, "not all shapes");
        }
        let known = shapes
            .iter()
            .filter_map(|id| Some((*id, self.store.kept(id)?)));
        let volumes = known.filter_map(|(id, known)| Some((id, known.volume_m3?)));
        let volumes = volumes.collect();
        let directory = &self.store.directory;
        directory.change(|picture| picture.learn_volumes(now_ms(), volumes));
    }
}
