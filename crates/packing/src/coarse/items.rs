//! Items on a coarser grid, kept.

use std::collections::HashMap;
use std::sync::Arc;

use super::CoarseGrid;
use crate::item::{Item, ItemError, ShapeId};

/// Items whose coarse views are kept.
const KEPT_ITEMS: usize = 512;

/// The coarse views of items, those that were used last.
#[derive(Debug, Default)]
pub(crate) struct CoarseItems {
    items: HashMap<ShapeId, CoarseItem>,
    uses: u64,
}

#[derive(Debug)]
struct CoarseItem {
    item: Arc<Item>,
    last_used: u64,
}

impl CoarseItems {
    /// An item on the coarse grid; always the same of these grids.
    pub(crate) fn of(&mut self, grids: &CoarseGrid, item: &Item) -> Result<Arc<Item>, ItemError> {
        self.uses += 1;
        if let Some(kept) = self.items.get_mut(&item.shape()) {
            kept.last_used = self.uses;
            return Ok(kept.item.clone());
        }
        let coarse = Arc::new(grids.item(item)?);
        self.keep(item.shape(), Arc::clone(&coarse));
        Ok(coarse)
    }

    /// Keeps what is known ahead of time.
    pub(crate) fn keep(&mut self, shape: ShapeId, item: Arc<Item>) {
        if self.items.len() >= KEPT_ITEMS {
            let oldest = self.items.iter().min_by_key(|(_, kept)| kept.last_used);
            if let Some(shape) = oldest.map(|(shape, _)| *shape) {
                self.items.remove(&shape);
            }
        }
        let last_used = self.uses;
        self.items.insert(shape, CoarseItem { item, last_used });
    }
}
