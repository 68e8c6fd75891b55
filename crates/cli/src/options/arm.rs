//! The option of the arm that has to make the placements.

use clap::Args;
use ppnpack_robot::arms;
use ppnpack_robot::station::{ArmStation, StationSettings};

use super::file;
use crate::failure::{Failure, OrInput, Outcome};
use crate::output::print_line;

/// What `--arm` takes for a wish to see the names.
const LIST: &str = "list";

/// The arm that has to make the placements.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Arm")]
pub(crate) struct ArmOptions {
    /// The arm that has to be able to make the placements: nachi-mz07l, abb-irb1200-5-90, or a TOML file of its cell,
    /// with the keys of the section `arm` in the planner's configuration, see docs/robot.md; `list` names those that
    /// are built in [default: none, placements are not checked for an arm]
    #[arg(long, value_name = "NAME|FILE")]
    arm: Option<String>,
}

impl ArmOptions {
    /// Prints the names of the arms where that is all that is wanted; says whether it was.
    ///
    /// # Errors
    /// That they cannot be written.
    pub(crate) fn listed(&self) -> Outcome<bool> {
        if self.arm.as_deref() != Some(LIST) {
            return Ok(false);
        }
        for name in arms::names() {
            print_line(name)?;
        }
        Ok(true)
    }

    /// The arm and its cell, as set and at work; `None` where there is no arm.
    ///
    /// # Errors
    /// What is wrong with the name, or with the file.
    pub(crate) fn station(&self) -> Outcome<Option<(StationSettings, ArmStation)>> {
        let Some(arm) = &self.arm else {
            return Ok(None);
        };
        let settings = if arms::text(arm).is_some() {
            StationSettings {
                arm: arm.clone(),
                ..StationSettings::default()
            }
        } else {
            file::settings(arm).map_err(|error| {
                let names: Vec<&str> = arms::names().collect();
                let names = names.join(", ");
                Failure::input(format_args!(
                    "--arm {arm} is none of {names}, and no file of a cell: {error}"
                ))
            })?
        };
        let station = ArmStation::new(&settings).or_input()?;
        Ok(Some((settings, station)))
    }
}
