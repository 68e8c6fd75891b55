//! Which cells and containers there are, for whoever is asked about one.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use ppnpack_wire::keys::Cell;

/// The size of a grid's cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CellSize {
    /// Their edge, in metres.
    pub(crate) cell_m: f64,
    /// One unit of height, in metres.
    pub(crate) height_unit_m: f64,
}

/// What is known of a cell.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Entry {
    /// Its containers, by the names under which bridge and perception serve them; at least one.
    pub(crate) containers: Vec<Cell>,
    /// The size of the cells of its grids.
    pub(crate) size: Option<CellSize>,
}

/// The cells, kept current by who follows them.
#[derive(Default)]
pub(crate) struct Directory {
    cells: Mutex<BTreeMap<Cell, Entry>>,
}

impl Directory {
    /// From now on it has these.
    pub(crate) fn set(&self, cells: BTreeMap<Cell, Entry>) {
        *self.lock() = cells;
    }

    /// The containers of a cell; `None` where there is no such cell.
    pub(crate) fn containers(&self, cell: &Cell) -> Option<Vec<Cell>> {
        self.lock().get(cell).map(|entry| entry.containers.clone())
    }

    /// The containers of all cells.
    pub(crate) fn all_containers(&self) -> Vec<Cell> {
        let cells = self.lock();
        let containers = cells.values().flat_map(|entry| &entry.containers);
        containers.cloned().collect()
    }

    /// The size of the cells of a cell's grids, where it is known.
    pub(crate) fn cell_size(&self, cell: &Cell) -> Option<CellSize> {
        self.lock().get(cell)?.size
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<Cell, Entry>> {
        self.cells.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
