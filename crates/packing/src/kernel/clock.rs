//! The time of a step.

use std::time::Instant;

/// Cells of footprints between two looks at the clock: some tens of microseconds.
const CELLS_BETWEEN_LOOKS: usize = 1 << 16;

/// Says when the time of a step is over, without looking at the clock for each little work.
#[derive(Debug, Clone)]
pub(crate) struct Clock {
    deadline: Option<Instant>,
    cells: usize,
    is_over: bool,
}

impl Clock {
    pub(crate) fn new(deadline: Option<Instant>) -> Self {
        Self {
            deadline,
            cells: CELLS_BETWEEN_LOOKS,
            is_over: false,
        }
    }

    /// Whether the time is over before work on so many cells begins. The first call looks.
    #[inline(always)]
    pub(crate) fn is_over_before(&mut self, cells: usize) -> bool {
        self.cells += cells;
        if self.cells >= CELLS_BETWEEN_LOOKS {
            self.look();
        }
        self.is_over
    }

    #[cold]
    fn look(&mut self) {
        self.cells = 0;
        self.is_over |= self
            .deadline
            .is_some_and(|deadline| Instant::now() >= deadline);
    }
}
