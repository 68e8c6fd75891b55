//! Options of the method by which placements are found and judged, and of the arm that makes them.

use clap::Args;
use ppnpack_packing::planning::method::{Method, ProposalSource};
use ppnpack_robot::arms;
use ppnpack_robot::station::{ArmStation, StationSettings};
use serde_json::{Map, Value};

use super::proposals::ProposalOptions;
use super::{Conditions, file};
use crate::failure::{Failure, OrInput, OrRun, Outcome};
use crate::output::print_line;

/// The method by which placements are found and judged.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Method")]
pub(crate) struct MethodOptions {
    /// A TOML or JSON file that says more of it: heuristic, order, stability, trial, loads,
    /// weights, scene_value and others, as in the planner's configuration. Options win over it
    #[arg(long, value_name = "FILE", value_parser = parse_method)]
    method: Option<Map<String, Value>>,

    #[command(flatten)]
    pub(crate) proposals: ProposalOptions,

    /// How many placements of an item a step may try in a simulated twin of the cell; the best one
    /// that stays is made. With 0 nothing is tried [default: 40 under robot conditions, 0 under the
    /// reference's]
    #[arg(long, value_name = "COUNT")]
    tries: Option<usize>,

    /// How many items the robot may choose among [default: 5]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..=1000))]
    buffer: Option<u32>,

    /// The seed of everything that is random [default: 0]
    #[arg(long, value_name = "NUMBER")]
    seed: Option<u64>,

    #[command(flatten)]
    pub(crate) arm: ArmOptions,
}

/// Parses the keys of a method's file, which is refused as it stands there, with its line.
fn parse_method(path: &str) -> Result<Map<String, Value>, String> {
    let alone: Method = file::settings(path)?;
    alone.validate().map_err(|error| error.to_string())?;
    file::settings(path)
}

impl MethodOptions {
    /// Gives the method that suits the conditions and items in so many poses, but for what file and
    /// options say; `proposals` are those of the options.
    pub(crate) fn method(
        &self,
        proposals: Option<ProposalSource>,
        conditions: Conditions,
        poses: u32,
    ) -> Outcome<Method> {
        let mut method = conditions.method();
        if let Some(own) = &self.method {
            let usual = serde_json::to_value(&method).or_run()?;
            let mut keys: Map<String, Value> = serde_json::from_value(usual).or_run()?;
            keys.extend(own.clone());
            method = serde_json::from_value(Value::Object(keys)).or_input()?;
        }
        if let Some(proposals) = proposals {
            method.proposals = proposals;
        } else if method.proposals.is_network() {
            return Err(Failure::input(
                "--method: a network needs its weights: give --proposals network, and --model FILE where it is not the one that ships",
            ));
        }
        if let Some(tries) = self.tries {
            method.trial.tries_per_item = tries;
        }
        if let Some(buffer) = self.buffer {
            method.buffer = buffer as usize;
        }
        method.seed = self.seed.unwrap_or(method.seed);
        method.validate().or_input()?;
        Ok(method.for_poses(poses as usize))
    }
}

/// Value of `--arm` that asks for the names.
const LIST: &str = "list";

/// The arm that has to make the placements.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Arm")]
pub(crate) struct ArmOptions {
    /// The arm that has to be able to make the placements: nachi-mz07l, abb-irb1200-5-90, or a TOML
    /// file of its cell, with the keys of the section `arm` in the planner's configuration, see
    /// docs/robot.md; `list` names those that are built in [default: none, placements are not
    /// checked for an arm]
    #[arg(long, value_name = "NAME|FILE")]
    arm: Option<String>,
}

impl ArmOptions {
    /// Prints the names of the arms where that is all that is wanted; says whether it was.
    pub(crate) fn listed(&self) -> Outcome<bool> {
        if self.arm.as_deref() != Some(LIST) {
            return Ok(false);
        }
        for name in arms::names() {
            print_line(name)?;
        }
        Ok(true)
    }

    /// Gives the arm and its cell, as set and at work; `None` where there is no arm.
    pub(crate) fn station(&self) -> Outcome<Option<(StationSettings, ArmStation)>> {
        let Some(arm) = &self.arm else {
            return Ok(None);
        };
        let none = |error: String| {
            let names = arms::names().collect::<Vec<_>>().join(", ");
            let none = format!("--arm {arm} is none of {names}, and no file of a cell: {error}");
            Failure::input(none)
        };
        let settings = match arms::text(arm) {
            None => file::settings(arm).map_err(none)?,
            Some(_) => StationSettings {
                arm: arm.clone(),
                ..StationSettings::default()
            },
        };
        let station = ArmStation::new(&settings).or_input()?;
        Ok(Some((settings, station)))
    }
}
