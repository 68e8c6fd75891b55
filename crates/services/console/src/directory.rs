//! The cells that are known: shared by the thread that follows them and all requests.

use std::collections::BTreeMap;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use ppnpack_packing::kernel::grid::Resolution;
use ppnpack_service::sync::lock;
use ppnpack_wire::keys::Cell;

use crate::picture::Picture;

/// The containers of a cell, and the resolution of its grids.
pub(crate) struct Entry {
    /// Its containers, by their names for bridge and perception; at least one.
    pub(crate) containers: Vec<Cell>,
    pub(crate) resolution: Option<Resolution>,
}

/// How long after the start a cell may be there that was not heard yet.
const FIRST_WORD: Duration = Duration::from_secs(5);

/// The picture of the cells, and a list of them: a question about one waits for no change of the
/// picture.
pub(crate) struct Directory {
    picture: Mutex<Picture>,
    cells: Mutex<BTreeMap<Cell, Entry>>,
    changed: Condvar,
    /// The time when all cells that are there have been heard.
    complete_at: Instant,
}

impl Directory {
    /// Makes that of a console which begins to listen now.
    pub(crate) fn begun() -> Self {
        Self {
            picture: Mutex::default(),
            cells: Mutex::default(),
            changed: Condvar::new(),
            complete_at: Instant::now() + FIRST_WORD,
        }
    }

    pub(crate) fn picture(&self) -> MutexGuard<'_, Picture> {
        lock(&self.picture)
    }

    pub(crate) fn change<T>(&self, change: impl FnOnce(&mut Picture) -> T) -> T {
        let mut picture = self.picture();
        let changed = change(&mut picture);
        *lock(&self.cells) = picture.directory();
        self.changed.notify_all();
        changed
    }

    /// Gives the containers of a cell; `None` where there is no such cell. In the first seconds it
    /// waits for the cell to be heard: a hold that comes then must not be refused for a cell that
    /// exists.
    pub(crate) fn heard_containers(&self, cell: &Cell) -> Option<Vec<Cell>> {
        let left = self.complete_at.saturating_duration_since(Instant::now());
        let is_unheard = |cells: &mut BTreeMap<Cell, Entry>| !cells.contains_key(cell);
        let waited = self
            .changed
            .wait_timeout_while(lock(&self.cells), left, is_unheard);
        let (cells, _) = waited.unwrap_or_else(PoisonError::into_inner);
        cells.get(cell).map(|entry| entry.containers.clone())
    }

    pub(crate) fn has(&self, cell: &Cell) -> bool {
        lock(&self.cells).contains_key(cell)
    }

    pub(crate) fn all_containers(&self) -> Vec<Cell> {
        let cells = lock(&self.cells);
        let containers = cells.values().flat_map(|entry| &entry.containers);
        containers.cloned().collect()
    }

    pub(crate) fn resolution(&self, cell: &Cell) -> Option<Resolution> {
        lock(&self.cells).get(cell)?.resolution.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::News;

    fn cell(name: &str) -> Cell {
        Cell::new(name).unwrap()
    }

    impl Directory {
        fn hear(&self, name: &str) {
            let state = News::State(Box::default());
            self.change(|picture| picture.apply(0, &cell(name), state));
        }
    }

    #[test]
    fn a_cell_that_was_not_heard_yet_is_waited_for_in_the_first_seconds() {
        let directory = Directory {
            complete_at: Instant::now() + Duration::from_secs(600),
            ..Directory::begun()
        };
        std::thread::scope(|scope| {
            let asking = scope.spawn(|| directory.heard_containers(&cell("c1")));
            directory.hear("c2");
            directory.hear("c1");
            assert_eq!(asking.join().unwrap(), Some(vec![cell("c1")]));
        });
    }

    #[test]
    fn later_a_cell_that_was_never_heard_does_not_exist() {
        let directory = Directory {
            complete_at: Instant::now(),
            ..Directory::begun()
        };
        directory.hear("c1");
        let heard = ["c1", "c2"].map(|name| directory.heard_containers(&cell(name)));
        assert_eq!(heard, [Some(vec![cell("c1")]), None]);
    }
}
