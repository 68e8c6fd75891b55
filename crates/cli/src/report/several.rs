//! The report on several containers: what each came to, and where its own report is.

use std::fs;
use std::io;
use std::path::Path;

use serde::Serialize;

use super::html::{document, escape};
use super::summary::{EndingSummary, Spread, Summary, Unplaceable};
use super::table::{duration, percent};
use super::{Packing, SUMMARY_FILE, Settings};
use crate::output;

/// What the folders of containers are named by, before their number.
const CONTAINER: &str = "container-";

/// The folder of a container's report, in that of all; containers are numbered from 1.
pub(crate) fn container_folder(number: usize) -> String {
    format!("{CONTAINER}{number:03}")
}

/// Takes away what an earlier run left in a folder of results: the reports of containers numbered above `count`.
///
/// # Errors
/// What the system says.
pub(crate) fn remove_further(folder: &Path, count: usize) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let number = name.to_str().and_then(container_number);
        // What else has such a name is not of here.
        let is_report = || entry.path().join(SUMMARY_FILE).is_file();
        if number.is_some_and(|number| number > count) && is_report() {
            fs::remove_dir_all(entry.path())?;
        }
    }
    Ok(())
}

/// The number of the container whose folder has this name.
fn container_number(name: &str) -> Option<usize> {
    let number = name.strip_prefix(CONTAINER)?.parse().ok()?;
    (container_folder(number) == name).then_some(number)
}

/// What `summary.json` holds of several containers.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct SeveralSummary {
    pub(crate) version: &'static str,
    /// How many were open at the same time.
    pub(crate) open: u8,
    pub(crate) items_in_sequence: usize,
    pub(crate) items_placed: usize,
    pub(crate) items_unsteady: usize,
    /// Volume of the items' meshes in a container that was closed, in cubic metres; absent where none was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) closed_meshes_m3: Option<f64>,
    pub(crate) decision_s: Spread,
    /// In the order in which they were opened; those that stayed empty are left out.
    pub(crate) containers: Vec<ContainerLine>,
    /// Items that fit into no container.
    pub(crate) unplaceable: Vec<Unplaceable>,
    pub(crate) settings: Settings,
}

/// What one container came to.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct ContainerLine {
    /// Where its report is.
    pub(crate) folder: String,
    pub(crate) items: usize,
    pub(crate) items_unsteady: usize,
    pub(crate) meshes_m3: f64,
    /// Mesh volume over that of the container.
    pub(crate) utilisation: f64,
    /// Why it was closed; absent where it was open at the end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) closed_because: Option<String>,
}

impl ContainerLine {
    /// Of a container with a report there.
    pub(crate) fn new(folder: String, summary: &Summary) -> Self {
        Self {
            folder,
            items: summary.metrics.packed.items,
            items_unsteady: summary.items_unsteady,
            meshes_m3: summary.metrics.packed.meshes_m3,
            utilisation: summary.metrics.utilisation,
            closed_because: match &summary.ending {
                EndingSummary::Closed { why } => Some(why.clone()),
                _ => None,
            },
        }
    }

    fn end(&self) -> &str {
        self.closed_because.as_deref().unwrap_or("open at the end")
    }
}

impl SeveralSummary {
    /// Of all of these.
    pub(crate) fn new(
        open: u8,
        containers: Vec<ContainerLine>,
        packings: &[Packing],
        unplaceable: Vec<Unplaceable>,
        settings: &Settings,
    ) -> Self {
        let closed = containers
            .iter()
            .filter(|line| line.closed_because.is_some());
        let closed: Vec<f64> = closed.map(|line| line.meshes_m3).collect();
        let steps = packings.iter().flat_map(|packing| &packing.steps);
        Self {
            version: env!("CARGO_PKG_VERSION"),
            open,
            items_in_sequence: settings.sequence.objects.len(),
            items_placed: steps.clone().count(),
            items_unsteady: containers.iter().map(|line| line.items_unsteady).sum(),
            closed_meshes_m3: (!closed.is_empty())
                .then(|| closed.iter().sum::<f64>() / closed.len() as f64),
            decision_s: Spread::of(steps.map(|step| step.timings.total())),
            containers,
            unplaceable,
            settings: settings.clone(),
        }
    }

    fn figures(&self) -> Vec<(&'static str, String)> {
        let closed = match self.closed_meshes_m3 {
            Some(volume_m3) => format!("{:.0} cm³", volume_m3 * 1e6),
            None => "none was closed".to_owned(),
        };
        vec![
            (
                "Packed",
                format!("{} of {} items", self.items_placed, self.items_in_sequence),
            ),
            ("Containers", self.containers.len().to_string()),
            ("Open at the same time", self.open.to_string()),
            ("In a closed container", closed),
            (
                "Unsteady when placed",
                format!("{} of {} items", self.items_unsteady, self.items_placed),
            ),
            (
                "Decision per item",
                format!(
                    "{} mean, {} at most",
                    duration(self.decision_s.mean),
                    duration(self.decision_s.max)
                ),
            ),
            (
                "Fit into no container",
                format!("{} items", self.unplaceable.len()),
            ),
        ]
    }

    /// How many items went into how many containers, and what did not stay or fit.
    fn answer(&self) -> String {
        let unsteady = match self.items_unsteady {
            0 => "every item stayed where it was placed".to_owned(),
            count => format!("{count} toppled, slid by more than 2 cm or fell out"),
        };
        let left = match self.unplaceable.len() {
            0 => String::new(),
            1 => "; one fits into no container".to_owned(),
            count => format!("; {count} fit into no container"),
        };
        let containers = match self.containers.len() {
            1 => "one container".to_owned(),
            count => format!("{count} containers"),
        };
        format!(
            "{} of {} items were placed into {containers}; {unsteady}{left}.",
            self.items_placed, self.items_in_sequence
        )
    }

    /// A table for the terminal.
    pub(crate) fn table(&self) -> String {
        let mut table = output::table();
        table.set_header(["Container", "Items", "Filled", "Unsteady", "Closed because"]);
        for line in &self.containers {
            table.add_row([
                line.folder.clone(),
                line.items.to_string(),
                percent(line.utilisation),
                line.items_unsteady.to_string(),
                line.end().to_owned(),
            ]);
        }
        format!("{table}\n{}", output::rows(self.figures()))
    }
}

/// `report.html` of several containers: what each came to, with its picture, and a link to its report.
pub(crate) fn page_of_several(all: &SeveralSummary) -> String {
    let mut body = format!(
        "<h1>Packing report</h1><p class=said>{}</p><table>",
        all.answer()
    );
    for (name, value) in all.figures() {
        body += &format!("<tr><th>{name}<td>{}</tr>", escape(&value));
    }
    body += "</table><h2>Containers</h2><div class=tiles>";
    for line in &all.containers {
        let folder = escape(&line.folder);
        body += &format!(
            "<div class=tile><a href=\"{folder}/report.html\"><img alt=\"The content of {folder}\" src=\"{folder}/packed.png\">\
             <b>{folder}</b></a><span>{} items, {} filled, {} unsteady; {}</span></div>",
            line.items,
            percent(line.utilisation),
            line.items_unsteady,
            escape(line.end())
        );
    }
    body += "</div>";
    if !all.unplaceable.is_empty() {
        body += "<h2>What fits into no container</h2><ul>";
        for item in &all.unplaceable {
            body += &format!("<li>{}: {}</li>", escape(&item.item), escape(&item.reason));
        }
        body += "</ul>";
    }
    document("Packing report", &body)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_reports_of_further_containers_are_taken_away() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["container-001", "container-002", "container-0003", "other"] {
            fs::create_dir(at(name)).unwrap();
            fs::write(at(name).join(SUMMARY_FILE), b"{}").unwrap();
        }
        fs::create_dir(at("container-004")).unwrap();
        remove_further(folder.path(), 1).unwrap();
        let is_left = |name: &str| at(name).is_dir();
        assert!(!is_left("container-002"));
        for name in ["container-001", "container-0003", "container-004", "other"] {
            assert!(is_left(name), "{name}");
        }
    }
}
