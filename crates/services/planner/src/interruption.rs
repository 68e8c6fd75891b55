//! Interruption of plans: whoever switches the automatic mode off does not wait for the plan that
//! is being made.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use ppnpack_packing::check::{Cost, Evidence, ValidityCheck, Verdict};
use ppnpack_packing::placement::RestingPlacement;
use ppnpack_packing::step::{Candidate, StageResult, StepInput};

/// Why an interrupted plan is none.
pub(crate) const INTERRUPTED: &str = "the automatic mode is being switched off: plan again";

/// Whether somebody waits for the plan that is being made to end. Clones share it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Interruption(Arc<AtomicUsize>);

/// Interrupts plans until it is dropped.
#[derive(Debug)]
pub(crate) struct Interrupting(Interruption);

impl Interruption {
    /// Interrupts plans from now on.
    pub(crate) fn begin(&self) -> Interrupting {
        self.0.fetch_add(1, Ordering::Relaxed);
        Interrupting(self.clone())
    }

    pub(crate) fn is_asked_for(&self) -> bool {
        self.0.load(Ordering::Relaxed) > 0
    }

    fn go_on(&self) -> StageResult {
        match self.is_asked_for() {
            true => Err(INTERRUPTED.into()),
            false => Ok(()),
        }
    }
}

impl Drop for Interrupting {
    fn drop(&mut self) {
        let Self(Interruption(count)) = self;
        count.fetch_sub(1, Ordering::Relaxed);
    }
}

/// A check that fails, and the plan with it, once that is interrupted.
impl ValidityCheck for Interruption {
    fn cost(&self) -> Cost {
        Cost::Lookup
    }

    fn begin(&mut self, _: &StepInput<'_>) -> StageResult {
        self.go_on()
    }

    fn judge(
        &mut self,
        _: &StepInput<'_>,
        _: &Candidate,
        _: &RestingPlacement,
    ) -> StageResult<Verdict> {
        self.go_on()?;
        Ok(Verdict::Accepted(Evidence::default()))
    }
}

#[cfg(test)]
mod tests {
    use ppnpack_packing::grid::Grid;
    use ppnpack_packing::heightmap::{Scene, Surface};

    use super::*;

    #[test]
    fn a_step_goes_on_until_it_is_interrupted_and_again_afterwards() {
        let grid = Grid::reference();
        let scene = Scene::from_surface(&grid, Surface::empty(&grid)).unwrap();
        let input = StepInput::new(&grid, &scene, &[]);
        let interruption = Interruption::default();
        let mut check = interruption.clone();
        assert!(ValidityCheck::begin(&mut check, &input).is_ok());
        let first = interruption.begin();
        let second = interruption.begin();
        drop(first);
        let error = ValidityCheck::begin(&mut check, &input).unwrap_err();
        assert_eq!(error.to_string(), INTERRUPTED);
        drop(second);
        assert!(ValidityCheck::begin(&mut check, &input).is_ok());
    }
}
