//! An arm at work in a cell, made of settings.

use std::sync::Arc;

use ppnpack_numbers::{settings, within};

use crate::arm::Arm;
use crate::arms;
use crate::cell::CellSettings;
use crate::cycle::{CycleSettings, PickPlace};
use crate::error::ParameterError;
use crate::feasibility::{ArmCheck, REFUSED_CYCLES_PER_ITEM};
use crate::motion::PlacePlanner;
use crate::parameters::{ArmParameters, BaseParameters, GripperParameters};

/// Maximum size of a parameter file, in bytes.
const MAX_FILE_BYTES: u64 = 1 << 20;

settings! {
    /// An arm with its stand, its gripper and its surroundings.
    ///
    /// The paper's kind of arm beside the reference container.
    pub struct StationSettings {
        /// The name of a built-in arm, or the path of a parameter file.
        pub arm: String = "nachi-mz07l".to_owned(),
        /// Its stand, if not that of the parameter file.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub base: Option<BaseParameters> = None,
        /// Its gripper, if not that of the parameter file.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub gripper: Option<GripperParameters> = None,
        /// The place where items are picked.
        pub pick: PickPlace = PickPlace::default(),
        /// Settings that cycles depend on beside the arm.
        pub cycle: CycleSettings = CycleSettings::default(),
        /// Surroundings of the arm, and its care in moving.
        pub cell: CellSettings = CellSettings::default(),
        /// An item of which so many placements were refused for their cycles alone in a step, and
        /// none accepted, is left out of the step.
        pub refused_cycles_per_item: usize = REFUSED_CYCLES_PER_ITEM,
    }
}

impl StationSettings {
    /// Gives the arm's parameters, with the base and the gripper of these settings.
    ///
    /// # Errors
    /// [`ParameterError`] where there is no such arm, or its file cannot be read.
    pub fn parameters(&self) -> Result<ArmParameters, ParameterError> {
        let mut parameters = ArmParameters::from_toml(&match arms::text(&self.arm) {
            Some(text) => text.to_owned(),
            None => file(&self.arm)?,
        })?;
        parameters.base = self.base.unwrap_or(parameters.base);
        parameters.gripper = self.gripper.unwrap_or(parameters.gripper);
        Ok(parameters)
    }
}

/// Reads a parameter file; what looks like no file is taken for a name.
fn file(path: &str) -> Result<String, ParameterError> {
    let unreadable = |reason: String| ParameterError::File {
        path: path.to_owned(),
        reason,
    };
    let too_large = || format!("it is larger than {MAX_FILE_BYTES} bytes");
    match std::fs::metadata(path) {
        Ok(found) if found.len() > MAX_FILE_BYTES => Err(unreadable(too_large())),
        Err(_) if !path.ends_with(".toml") => Err(arms::unknown(path)),
        _ => std::fs::read_to_string(path).map_err(|error| unreadable(error.to_string())),
    }
}

/// An arm at work: it makes the check that planners ask, each of which has its own.
#[derive(Debug, Clone)]
pub struct ArmStation {
    parameters: ArmParameters,
    check: ArmCheck,
}

impl ArmStation {
    /// Makes the arm of settings.
    ///
    /// # Errors
    /// [`ParameterError`] names the first thing that is not possible.
    pub fn new(settings: &StationSettings) -> Result<Self, ParameterError> {
        let parameters = settings.parameters()?;
        settings.pick.validate()?;
        settings.cycle.validate()?;
        let refused = settings.refused_cycles_per_item;
        within("1 to 1000000", 1.0..=1e6)("refused_cycles_per_item", refused as f64)?;
        let arm = Arc::new(Arm::new(&parameters)?);
        let planner = PlacePlanner::new(arm, settings.cell.clone())?;
        let check = ArmCheck::new(planner)
            .with_cycles(settings.pick, settings.cycle)
            .with_refused_cycles_per_item(refused);
        Ok(Self { parameters, check })
    }

    /// Gives the arm's parameters, its stand and its gripper among them.
    pub fn parameters(&self) -> &ArmParameters {
        &self.parameters
    }

    /// Makes a check for a planner.
    pub fn check(&self) -> ArmCheck {
        self.check.clone()
    }
}
