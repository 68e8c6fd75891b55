//! The scores of steps as grids, for people to look at.

use std::collections::VecDeque;
use std::sync::Arc;

use ppnpack_packing::grid::Grid;
use ppnpack_packing::item::Item;
use ppnpack_packing::score_map::ScoreMap;
use ppnpack_service::ServiceError;
use ppnpack_service::clock;
use ppnpack_service::process::Process;
use ppnpack_service::stream::Publisher;
use ppnpack_wire::debug::{self, ItemScores};
use ppnpack_wire::keys::{Cell, Stream};

/// Cells that scores can be published of at once; those that asked longest ago go first.
const CELLS_KEPT: usize = 64;

/// Publishes the scores of cells while somebody reads them.
pub(crate) struct DebugScores {
    process: Process,
    /// Those that asked last are first.
    publishers: VecDeque<CellPublisher>,
}

struct CellPublisher {
    cell: Cell,
    publisher: Publisher<debug::Grid>,
}

/// What the items of a step of a cell were scored.
pub(crate) struct CellScores {
    pub(crate) cell: Cell,
    pub(crate) items: Vec<Arc<Item>>,
    /// Per item.
    pub(crate) scores: Vec<ScoreMap>,
}

impl DebugScores {
    pub(crate) fn new(process: Process) -> Self {
        Self {
            process,
            publishers: VecDeque::new(),
        }
    }

    /// Whether somebody reads the scores of a cell, as far as has been heard: for a cell that was not asked of before, that is
    /// most often nothing yet.
    pub(crate) fn is_wanted(&mut self, cell: &Cell) -> bool {
        let has_readers = self.has_readers(cell);
        has_readers.unwrap_or_else(|error| {
            tracing::warn!(%cell, %error, "scores cannot be published");
            false
        })
    }

    fn has_readers(&mut self, cell: &Cell) -> Result<bool, ServiceError> {
        let index = self.publishers.iter().position(|kept| kept.cell == *cell);
        let kept = match index.and_then(|index| self.publishers.remove(index)) {
            Some(kept) => kept,
            None => CellPublisher {
                cell: cell.clone(),
                publisher: Publisher::new(&self.process, cell, Stream::DebugScores)?,
            },
        };
        let has_readers = kept.publisher.has_readers();
        self.publishers.truncate(CELLS_KEPT - 1);
        self.publishers.push_front(kept);
        Ok(has_readers)
    }

    /// Publishes scores. Nothing depends on them.
    pub(crate) fn tell(&self, grid: &Grid, of_cell: &CellScores) {
        let CellScores {
            cell,
            items,
            scores,
        } = of_cell;
        let Some(kept) = self.publishers.iter().find(|kept| kept.cell == *cell) else {
            return;
        };
        let items = items.iter().zip(scores).map(|(item, scores)| ItemScores {
            name: item.name(),
            scores,
        });
        let items: Vec<ItemScores<'_>> = items.collect();
        let at_ns = i64::try_from(clock::now_ns()).unwrap_or(i64::MAX);
        let message = debug::scores(cell, at_ns, grid, &items);
        if let Err(error) = kept.publisher.put(&message) {
            tracing::warn!(%cell, %error, "scores not published");
        }
    }
}

#[cfg(test)]
mod tests {
    use ppnpack_service::embedded;
    use ppnpack_wire::keys::Service;

    use super::*;

    #[test]
    fn the_cells_that_asked_last_are_kept() {
        let hub = embedded::hub().unwrap();
        let process = embedded::process(&hub, Service::Ppn, "ppn-1").unwrap();
        let mut scores = DebugScores::new(process);
        let cells = (0..CELLS_KEPT + 3).map(|index| Cell::new(&format!("cell-{index}")).unwrap());
        let cells: Vec<Cell> = cells.collect();
        for cell in &cells {
            assert!(!scores.is_wanted(cell));
            assert!(!scores.is_wanted(&cells[0]));
        }
        let kept: Vec<&Cell> = scores.publishers.iter().map(|kept| &kept.cell).collect();
        assert_eq!(kept.len(), CELLS_KEPT);
        let last = cells.iter().rev().take(CELLS_KEPT - 1);
        let expected: Vec<&Cell> = cells.iter().take(1).chain(last).collect();
        assert_eq!(kept, expected);
    }
}
