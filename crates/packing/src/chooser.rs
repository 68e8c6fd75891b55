//! Choosing among the best placements of the waiting items, where the value of the objective does not decide alone.

use crate::step::{Evaluated, StageResult, StepInput};

/// A stage between ranking and choosing.
pub trait Chooser: Send {
    /// Which of a step's options to take, by index. Each option is the best placement of another item, of which a simulation
    /// was not asked yet; the first is the one that the objective prefers, and valid.
    fn choose(&mut self, input: &StepInput<'_>, options: &[Evaluated]) -> StageResult<usize>;
}

/// A chooser of any kind.
pub type BoxedChooser = Box<dyn Chooser>;
