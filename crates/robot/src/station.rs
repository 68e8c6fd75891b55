//! An arm at work in a cell, made of settings: the check that a planner asks, and the cycles of what was chosen.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use nalgebra::Isometry3;
use ppnpack_catalogue::object::Model;
use ppnpack_packing::check::{BoxedCheck, Cost, ValidityCheck};
use ppnpack_packing::grid::Resolution;
use ppnpack_packing::item::Item;
use ppnpack_packing::placement::RestingPlacement;
use ppnpack_packing::step::{Candidate, StageError, StepInput};
use serde::{Deserialize, Serialize};

use crate::arm::Arm;
use crate::arms;
use crate::cell::CellSettings;
use crate::cycle::{Cycle, CycleSettings, PickPlace};
use crate::error::ParameterError;
use crate::feasibility::{ArmCheck, NAME, Tally};
use crate::motion::PlacePlanner;
use crate::parameters::{ArmParameters, BaseParameters, GripperParameters};
use crate::pick::NoPickPoint;
use crate::refusal::Refusal;
use crate::surface::UpperSurface;

/// How finely models are sampled where they are held, in metres.
const SURFACE_PITCH_M: f64 = 0.002;

/// The longest parameter file, in bytes.
const MAX_FILE_BYTES: u64 = 1 << 20;

/// An arm, where it stands, what it holds items with, and what is around it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StationSettings {
    /// The name of a built-in arm, or the path of a parameter file.
    pub arm: String,
    /// Where it stands, if not where the parameter file says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base: Option<BaseParameters>,
    /// Its gripper, if not that of the parameter file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gripper: Option<GripperParameters>,
    /// Where items are picked.
    pub pick: PickPlace,
    /// What cycles depend on beside the arm.
    pub cycle: CycleSettings,
    /// What is around the arm, and how carefully it moves.
    pub cell: CellSettings,
}

/// The paper's kind of arm beside the reference container.
impl Default for StationSettings {
    fn default() -> Self {
        Self {
            arm: "nachi-mz07l".to_owned(),
            base: None,
            gripper: None,
            pick: PickPlace::default(),
            cycle: CycleSettings::default(),
            cell: CellSettings::default(),
        }
    }
}

impl StationSettings {
    /// The arm's parameters, with the base and the gripper of these settings.
    ///
    /// # Errors
    /// [`ParameterError`] where there is no such arm, or its file cannot be read.
    pub fn parameters(&self) -> Result<ArmParameters, ParameterError> {
        let mut parameters = match arms::text(&self.arm) {
            Some(text) => ArmParameters::from_toml(text)?,
            None => ArmParameters::from_toml(&file(&self.arm)?)?,
        };
        parameters.base = self.base.unwrap_or(parameters.base);
        parameters.gripper = self.gripper.unwrap_or(parameters.gripper);
        Ok(parameters)
    }
}

/// The text of a parameter file; what looks like no file is taken for a name.
fn file(path: &str) -> Result<String, ParameterError> {
    let unreadable = |reason: String| ParameterError::File {
        path: path.to_owned(),
        reason,
    };
    match std::fs::metadata(path) {
        Ok(found) if found.len() > MAX_FILE_BYTES => Err(unreadable(format!(
            "it is larger than {MAX_FILE_BYTES} bytes"
        ))),
        Err(_) if !path.ends_with(".toml") => Err(arms::unknown(path)),
        _ => std::fs::read_to_string(path).map_err(|error| unreadable(error.to_string())),
    }
}

/// An arm at work, shared by the check that a planner asks and by whoever wants the cycle of its choice.
#[derive(Debug, Clone)]
pub struct ArmStation {
    parameters: Arc<ArmParameters>,
    check: Arc<Mutex<ArmCheck>>,
}

impl ArmStation {
    /// The arm of settings.
    ///
    /// # Errors
    /// [`ParameterError`] names the first thing that is not possible.
    pub fn new(settings: &StationSettings) -> Result<Self, ParameterError> {
        let parameters = settings.parameters()?;
        settings.pick.validate()?;
        settings.cycle.validate()?;
        let arm = Arc::new(Arm::new(&parameters)?);
        let planner = PlacePlanner::new(arm, settings.cell.clone())?;
        let check = ArmCheck::new(planner).with_cycles(settings.pick, settings.cycle);
        Ok(Self {
            parameters: Arc::new(parameters),
            check: Arc::new(Mutex::new(check)),
        })
    }

    /// The arm's parameters, where it stands and its gripper among them.
    pub fn parameters(&self) -> &ArmParameters {
        &self.parameters
    }

    /// The check, for a planner.
    pub fn check(&self) -> BoxedCheck {
        Box::new(self.clone())
    }

    /// Has an item be held and lifted by what its model says; the same item again changes nothing.
    pub fn hold(&self, item: &Item, model: &Model) {
        let mut check = self.lock();
        if check.holds(item) {
            return;
        }
        check.weigh(item, model.mass.mass_kg);
        if let Some(surface) = UpperSurface::of_model(model, SURFACE_PITCH_M) {
            // Where it cannot be held the check says so.
            check.hold(item, &surface).ok();
        }
    }

    /// Whether [`hold`](Self::hold) was called for an item.
    pub fn holds(&self, item: &Item) -> bool {
        self.lock().holds(item)
    }

    /// Forgets an item that will not come again.
    pub fn release(&self, item: &Item) {
        self.lock().release(item);
    }

    /// Says where the item of an arrival lies to be picked; see [`ArmCheck::pick_from`].
    pub fn pick_from(&self, arrival: usize, container_from_item: Option<Isometry3<f64>>) {
        self.lock().pick_from(arrival, container_from_item);
    }

    /// Whether an item can be held and lifted at all.
    ///
    /// # Errors
    /// [`Refusal::Pick`] and [`Refusal::TooHeavy`] where it cannot.
    pub fn lift(&self, item: &Item, resolution: &Resolution) -> Result<(), Refusal> {
        self.lock().lift(item, resolution).map(|_| ())
    }

    /// The cycle that picks and places an item.
    ///
    /// # Errors
    /// [`Refusal`] where there is none: never for what the check has accepted.
    pub fn cycle(
        &self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<Cycle, Refusal> {
        let cycle = self.lock().cycle(input, candidate, resting)?;
        cycle.ok_or(Refusal::Pick(NoPickPoint::Empty))
    }

    /// Why the arm refused most placements of a candidate in the step, by the candidate's arrival; `None` where it
    /// refused none.
    pub fn why(&self, arrival: usize) -> Option<String> {
        self.lock().why(arrival).map(str::to_owned)
    }

    /// What the check was asked since the last call.
    pub fn take_tally(&self) -> Tally {
        self.lock().take_tally()
    }

    fn lock(&self) -> MutexGuard<'_, ArmCheck> {
        // Nothing panics while it is held.
        self.check.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl ValidityCheck for ArmStation {
    fn name(&self) -> &'static str {
        NAME
    }

    fn cost(&self) -> Cost {
        Cost::Motion
    }

    fn rules_out(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
    ) -> Result<bool, StageError> {
        self.lock().rules_out(input, candidate)
    }

    fn is_valid(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<bool, StageError> {
        self.lock().is_valid(input, candidate, resting)
    }
}
