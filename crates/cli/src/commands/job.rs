//! What `pack` and `up --pack` have in common: how much is kept of a packing, and where it goes.

use std::path::PathBuf;

use clap::Args;

use crate::failure::Outcome;
use crate::options::Conditions;
use crate::output;
use crate::quantity::parse_time;
use crate::report::{self, PAGE_FILE, Packing};

/// Valid placements kept beside each choice, for the report.
pub(super) const ALTERNATIVES: u8 = 3;

/// What becomes of items that fit nowhere.
#[derive(Debug, Args)]
#[command(next_help_heading = "Sequence")]
pub(super) struct SettingAsideOptions {
    /// How many items that fit nowhere may be set aside for the next container; the packing then goes on with the next
    /// ones [default: 20 under robot conditions, 0 under the reference's]
    #[arg(long, value_name = "COUNT")]
    set_aside: Option<u32>,
}

impl SettingAsideOptions {
    /// How many items may be set aside, by default as suits the conditions.
    pub(super) fn limit(&self, conditions: Conditions) -> usize {
        let usual = conditions.set_aside();
        self.set_aside.map_or(usual, |limit| limit as usize)
    }
}

/// Where the results of a packed sequence go.
#[derive(Debug, Args)]
pub(super) struct ResultOptions {
    /// Where the results are written
    #[arg(long, value_name = "DIR", default_value = "out/pack")]
    out: PathBuf,

    /// How long it takes the robot to bring an item into another resting pose, such as 4s: the report adds it up
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    turn_time: Option<f64>,

    /// Print the summary as JSON instead of a table
    #[arg(long)]
    json: bool,
}

impl ResultOptions {
    /// Writes the report and prints the summary.
    pub(super) fn publish(&self, packing: &Packing) -> Outcome {
        let summary = packing.summary(self.turn_time);
        report::write(packing, &summary, &self.out)?;
        let page = self.out.join(PAGE_FILE);
        Ok(output::print(&summary, self.json, || {
            let table = report::table::summary(packing, &summary);
            format!("{table}\nReport: {}", page.display())
        })?)
    }
}
