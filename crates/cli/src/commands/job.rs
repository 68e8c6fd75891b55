//! What `pack` and `up --pack` have in common: how much is kept of a packing, and where it goes.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use ppnpack_files::StagedFolder;

use crate::failure::Outcome;
use crate::options::Conditions;
use crate::output;
use crate::quantity::parse_time;
use crate::report::{
    self, ContainerLine, PAGE_FILE, Packing, SUMMARY_FILE, Settings, SeveralSummary, Unplaceable,
    container_folder, page_of_several,
};

/// Valid placements kept beside each choice, for the report.
pub(super) const ALTERNATIVES: u8 = 3;

/// Why a folder of results is not that of this run alone.
const LEFT_OVER: &str = "what an earlier run left in the folder of results cannot be removed";

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
    /// Writes a report of each container, one of all of them, and prints a summary.
    pub(super) fn publish_several(
        &self,
        packings: &[Packing],
        unplaceable: Vec<Unplaceable>,
        open: u8,
        settings: &Settings,
    ) -> Outcome {
        let mut containers = Vec::new();
        for (number, packing) in packings.iter().enumerate() {
            let summary = packing.summary(self.turn_time);
            let folder = container_folder(number + 1);
            report::write(packing, &summary, &self.out.join(&folder))?;
            containers.push(ContainerLine::new(folder, &summary));
        }
        let all = SeveralSummary::new(open, containers, packings, unplaceable, settings);
        let page = page_of_several(&all);
        let mut files = StagedFolder::new(&self.out).map_err(anyhow::Error::from)?;
        let json = serde_json::to_vec_pretty(&all).context("the summary cannot be encoded")?;
        for (name, content) in [(SUMMARY_FILE, json), (PAGE_FILE, page.into_bytes())] {
            files.add(name, &content).map_err(anyhow::Error::from)?;
        }
        files.publish().map_err(anyhow::Error::from)?;
        report::remove_further(&self.out, packings.len()).context(LEFT_OVER)?;
        report::remove_of_one(&self.out).context(LEFT_OVER)?;
        let page = self.out.join(PAGE_FILE);
        Ok(output::print(&all, self.json, || {
            format!("{}\nReport: {}", all.table(), page.display())
        })?)
    }

    /// Writes the report and prints the summary.
    pub(super) fn publish(&self, packing: &Packing) -> Outcome {
        let summary = packing.summary(self.turn_time);
        report::write(packing, &summary, &self.out)?;
        report::remove_further(&self.out, 0).context(LEFT_OVER)?;
        let page = self.out.join(PAGE_FILE);
        Ok(output::print(&summary, self.json, || {
            let table = report::table::summary(packing, &summary);
            format!("{table}\nReport: {}", page.display())
        })?)
    }
}
