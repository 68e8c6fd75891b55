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

/// The longest parameter file, in bytes.
const MAX_FILE_BYTES: u64 = 1 << 20;

settings! {
    /// An arm, where it stands, what it holds items with, and what is around it.
    ///
    /// The paper's kind of arm beside the reference container.
    pub struct StationSettings {
        /// The name of a built-in arm, or the path of a parameter file.
        pub arm: String = "nachi-mz07l".to_owned(),
        /// Where it stands, if not where the parameter file says.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub base: Option<BaseParameters> = None,
        /// Its gripper, if not that of the parameter file.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub gripper: Option<GripperParameters> = None,
        /// Where items are picked.
        pub pick: PickPlace = PickPlace::default(),
        /// What cycles depend on beside the arm.
        pub cycle: CycleSettings = CycleSettings::default(),
        /// What is around the arm, and how carefully it moves.
        pub cell: CellSettings = CellSettings::default(),
        /// An item of which so many placements were refused for their cycles alone in a step, and
        /// none accepted, is left out of the step.
        pub refused_cycles_per_item: usize = REFUSED_CYCLES_PER_ITEM,
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

/// An arm at work: it makes the check that planners ask, each of which has its own.
#[derive(Debug, Clone)]
pub struct ArmStation {
    parameters: ArmParameters,
    check: ArmCheck,
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
        let count = within("1 to 1000000", 1.0..=1e6);
        count(
            "refused_cycles_per_item",
            settings.refused_cycles_per_item as f64,
        )?;
        let arm = Arc::new(Arm::new(&parameters)?);
        let planner = PlacePlanner::new(arm, settings.cell.clone())?;
        let check = ArmCheck::new(planner)
            .with_cycles(settings.pick, settings.cycle)
            .with_refused_cycles_per_item(settings.refused_cycles_per_item);
        Ok(Self { parameters, check })
    }

    /// The arm's parameters, where it stands and its gripper among them.
    pub fn parameters(&self) -> &ArmParameters {
        &self.parameters
    }

    /// A check for a planner.
    pub fn check(&self) -> ArmCheck {
        self.check.clone()
    }
}
