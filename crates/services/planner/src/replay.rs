//! Recorded steps planned again, without any other service.
//!
//! Whatever a decision depends on is in its record, and what is planned depends on nothing else:
//! not on the number of threads, on what was planned before, on who evaluated the placements, nor
//! on how long it took. So a step that was planned to its end leads to the same decision again, bit
//! for bit, in the same build on processors that reckon alike.

use std::collections::HashMap;
use std::sync::Arc;

use ppnpack_packing::planning::plan::{Plan, PlanError};
use ppnpack_packing::ranking::step::StepInput;
use ppnpack_physics::trial;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::shape_store::ShapeStore;
use ppnpack_wire::v1;

use crate::planning::Planning;
use crate::record;
pub use crate::record::Unreadable;
use crate::settings::CellSettings;
use crate::step::plan::PlansContainers;

/// Why a step is not planned again.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Unreplayable {
    /// It ran out of time.
    #[error("its time was over before everything was looked at")]
    Cut,
    /// The placements that the network proposed are not recorded.
    #[error("the network proposed its placements, and is not in the recording")]
    Network,
    /// The settings are those of another version.
    #[error("the settings of its cell cannot be read: {0}")]
    Settings(serde_json::Error),
    /// The settings cannot be followed here, such as with an arm whose file is not here.
    #[error("its cell cannot be planned here: {0}")]
    Planning(String),
    /// It names a container that the settings do not have.
    #[error("its cell has no container '{0}'")]
    Container(String),
    /// The record is no step.
    #[error(transparent)]
    Record(#[from] Unreadable),
    /// Planning failed.
    #[error("planning it again failed: {0}")]
    Failed(#[from] PlanError),
}

/// Plans recorded steps again.
pub struct Replayer {
    threads: Option<Arc<rayon::ThreadPool>>,
    /// The cell that was planned last.
    cell: Option<ReplayedCell>,
}

/// The containers of a cell, each planned by the settings of a record.
struct ReplayedCell {
    /// The name and the settings in the record.
    made_of: (String, String),
    plannings: HashMap<String, Planning>,
}

impl Replayer {
    /// Makes one that plans on so many threads; the decisions are the same with any number.
    ///
    /// # Errors
    /// Where the threads cannot be had.
    pub fn new(threads: usize) -> Result<Self, String> {
        let threads = trial::pool(threads).map_err(|error| error.to_string())?;
        Ok(Self {
            threads,
            cell: None,
        })
    }

    /// Plans a step again. The decision has all that follows from the input, and no names, times
    /// and states. `None` where nothing has a valid placement.
    ///
    /// # Errors
    /// [`Unreplayable`] says why it cannot be planned again.
    pub fn replay(
        &mut self,
        record: &v1::PlanningRecord,
        shapes: &ShapeStore,
    ) -> Result<Option<v1::Decision>, Unreplayable> {
        if record.is_cut {
            return Err(Unreplayable::Cut);
        }
        let step = record::step(record, shapes)?;
        let found = step.plan(self.cell_of(record)?)?;
        Ok(found.and_then(|found| step.decision(&found)))
    }

    /// Gives the cell of a record, which is kept for the next one.
    fn cell_of(&mut self, record: &v1::PlanningRecord) -> Result<&mut ReplayedCell, Unreplayable> {
        let made_of = (record.cell.clone(), record.settings.clone());
        let kept = self.cell.take().filter(|cell| cell.made_of == made_of);
        let cell = match kept {
            Some(kept) => kept,
            None => ReplayedCell::new(made_of, self.threads.as_ref())?,
        };
        Ok(self.cell.insert(cell))
    }
}

impl ReplayedCell {
    fn new(
        made_of: (String, String),
        threads: Option<&Arc<rayon::ThreadPool>>,
    ) -> Result<Self, Unreplayable> {
        let (cell, settings) = &made_of;
        let settings: CellSettings =
            serde_json::from_str(settings).map_err(Unreplayable::Settings)?;
        if settings.method.proposals.is_network() {
            return Err(Unreplayable::Network);
        }
        let possible = settings.validate();
        possible.map_err(Unreplayable::Planning)?;
        let planned = |error: &dyn std::fmt::Display| Unreplayable::Planning(error.to_string());
        let cell = Cell::new(cell).map_err(|error| planned(&error))?;
        let plans = settings.container_plans(&cell);
        let plannings = plans.map_err(|error| planned(&error))?.into_iter();
        let plannings = plannings.map(|plan| {
            let planning = Planning::alone(&plan.settings, threads.cloned());
            Ok((plan.name, planning.map_err(Unreplayable::Planning)?))
        });
        Ok(Self {
            plannings: plannings.collect::<Result<_, Unreplayable>>()?,
            made_of,
        })
    }
}

impl PlansContainers for ReplayedCell {
    type Error = Unreplayable;

    fn plan_in(&mut self, container: &str, input: &StepInput<'_>) -> Result<Plan, Unreplayable> {
        let unknown = || Unreplayable::Container(container.to_owned());
        let planning = self.plannings.get_mut(container).ok_or_else(unknown)?;
        Ok(planning.plan(input)?.clone())
    }
}

/// Keeps of a decision what follows from its input: all but its names, times and states, and which
/// services were there.
pub fn what_follows(decision: &v1::Decision) -> v1::Decision {
    v1::Decision {
        decision_id: String::new(),
        request_id: String::new(),
        session_id: String::new(),
        step: 0,
        heightmap: None,
        state_number: 0,
        degraded: Vec::new(),
        stages: Vec::new(),
        set_aside: Vec::new(),
        decided_at_ns: 0,
        ..decision.clone()
    }
}
