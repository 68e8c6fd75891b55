//! The report on one packed sequence.

mod arm;
mod csv;
mod html;
mod motion;
mod playback;
mod simplified;
mod summary;

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use anyhow::Context;
use nalgebra::Isometry3;
use ppnpack_catalogue::object::Model;
use ppnpack_files::StagedFolder;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::planning::method::Method;
use ppnpack_packing::scene::Scene;
use ppnpack_packing::streams::episode::{Episode, Step};
use ppnpack_packing::streams::metrics::Metrics;
use ppnpack_physics::moves::Moves;
use ppnpack_physics::outcome::{self, BodyState};
use ppnpack_physics::packing_cell::{Placed, SimulatedPackingCell};
use ppnpack_picture::Size;
use ppnpack_robot::station::StationSettings;
use serde::Serialize;

use crate::drawing;
use crate::options::Simulated;
use crate::sequence::Sequence;
pub(crate) use arm::{ArmAsked, ArmWork};
pub(crate) use summary::{EndingSummary, Summary, Unplaceable};

/// Kind of unsteadiness of an item that neither toppled nor fell out.
const SLID: &str = "slid by more than 2 cm";

/// The page about it.
pub(crate) const PAGE_FILE: &str = "report.html";

/// Everything a packing depended on.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Settings {
    pub(crate) catalogue: String,
    pub(crate) catalogue_hash: String,
    pub(crate) objects: usize,
    /// The most poses in which an object might be packed.
    pub(crate) poses: u32,
    pub(crate) sequence: Sequence,
    /// The most items that might be set aside for the next container.
    pub(crate) set_aside: usize,
    pub(crate) grid: Grid,
    pub(crate) method: MethodWithArm,
    pub(crate) simulated: Simulated,
}

/// A method, and the arm that has to make the placements, if any.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct MethodWithArm {
    #[serde(flatten)]
    pub(crate) method: Method,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) arm: Option<StationSettings>,
}

/// A packed sequence.
#[derive(Debug)]
pub(crate) struct Packing {
    pub(crate) settings: Settings,
    /// The steps in order.
    pub(crate) steps: Vec<Step>,
    /// The outcome of each placement by the end of its settling phase.
    pub(crate) settled: Vec<Settled>,
    /// The changes by each step of how everything lies.
    pub(crate) moves: Vec<Moves>,
    pub(crate) ending: EndingSummary,
    /// Items that were set aside for the next container.
    pub(crate) set_aside: Vec<Unplaceable>,
    /// The scene at the end.
    pub(crate) scene: Scene,
    pub(crate) metrics: Metrics,
    /// The content in or on the container, with its places in the sequence of arrivals.
    pub(crate) contents: Vec<(usize, Content)>,
    /// The content that lay there before the first step, as it lies at the end.
    pub(crate) preloaded: Vec<Content>,
    pub(crate) took: Duration,
    /// The arm's part, where there was one.
    pub(crate) arm: Option<ArmWork>,
}

/// The outcome of a placement by the end of its settling phase.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Settled {
    pub(crate) slide_m: f64,
    pub(crate) tilt_rad: f64,
    pub(crate) toppled: bool,
    pub(crate) inside: bool,
}

impl Settled {
    /// Says whether it did not stay where it was placed.
    pub(crate) fn is_unsteady(&self) -> bool {
        outcome::is_unsteady(self.toppled, self.slide_m, self.inside)
    }

    /// Says how it did not stay, where it did not.
    pub(crate) fn unsteadiness(&self) -> Option<String> {
        Some(match self.kind_of_unsteadiness()? {
            SLID => format!("slid by {:.1} cm", self.slide_m * 100.0),
            other => other.to_owned(),
        })
    }

    /// Gives the kind of that.
    fn kind_of_unsteadiness(&self) -> Option<&'static str> {
        match self {
            _ if !self.is_unsteady() => None,
            Self { inside: false, .. } => Some("fell out"),
            Self { toppled: true, .. } => Some("toppled"),
            Self { .. } => Some(SLID),
        }
    }
}

/// Something that lies in or on the container.
#[derive(Debug)]
pub struct Content {
    /// Its model.
    pub model: Arc<Model>,
    /// Its pose.
    pub container_from_item: Isometry3<f64>,
    /// Whether its centre is inside.
    pub inside: bool,
}

impl From<BodyState> for Content {
    fn from(body: BodyState) -> Self {
        Self {
            model: body.model,
            container_from_item: body.container_from_item,
            inside: body.inside,
        }
    }
}

impl From<&Placed> for Settled {
    fn from(placed: &Placed) -> Self {
        Self {
            slide_m: placed.report.slide_m,
            tilt_rad: placed.report.tilt_rad,
            toppled: placed.report.toppled,
            inside: placed.report.inside,
        }
    }
}

impl Packing {
    /// Makes it of an episode and the simulated cell that was packed.
    pub(crate) fn of(
        settings: Settings,
        episode: Episode,
        cell: &SimulatedPackingCell,
        took: Duration,
    ) -> Self {
        let placed = cell.placed().iter();
        let contents = cell.contents().into_iter();
        let contents = contents.map(|(arrival, body)| (arrival, body.into()));
        Self {
            settings,
            ending: EndingSummary::new(&episode.ending),
            set_aside: episode.set_aside.iter().map(Unplaceable::from).collect(),
            steps: episode.steps,
            scene: episode.scene,
            metrics: episode.metrics,
            settled: placed.clone().map(Settled::from).collect(),
            moves: placed.map(|placed| placed.moves.clone()).collect(),
            contents: contents.collect(),
            preloaded: cell.preloaded().map(Content::from).collect(),
            took,
            arm: None,
        }
    }

    /// Gives the item of an arrival as it lies at the end, where it lies in or on the container.
    fn lies(&self, arrival: usize) -> Option<&Content> {
        let mut contents = self.contents.iter();
        let found = contents.find(|(other, _)| *other == arrival);
        found.map(|(_, content)| content)
    }

    /// Gives the place that a step planned for the lower corner of an item's box, in centimetres.
    fn planned_cm(&self, step: &Step) -> [f64; 3] {
        let resolution = self.settings.grid.resolution();
        let at = step.choice.resting;
        let cell_cm = resolution.cell_m() * 100.0;
        let [x_cm, y_cm] = [at.placement.x, at.placement.y].map(|cells| cells as f64 * cell_cm);
        let unit_cm = resolution.height_unit_m() * 100.0;
        [x_cm, y_cm, f64::from(at.resting_height) * unit_cm]
    }

    /// Gives the yaw of a step's placement.
    fn yaw_rad(&self, step: &Step) -> Option<f64> {
        let yaws = self.settings.grid.resolution().yaws().radians();
        yaws.get(step.choice.resting.placement.yaw).copied()
    }
}

/// Writes all files of the report, and a further one, or none.
pub(crate) fn write(
    packing: &Packing,
    summary: &Summary,
    folder: &Path,
    further: Option<(&str, &[u8])>,
) -> anyhow::Result<()> {
    let grid = &packing.settings.grid;
    let taken = &packing.settings.simulated.cell.taken;
    let size = Size::new(1600, 1200)?;
    let packed = drawing::packed(
        grid,
        taken,
        &packing.preloaded,
        packing.contents.iter(),
        size,
    );
    let packed = packed.and_then(|image| image.to_png());
    let packed = packed.context("packed.png cannot be drawn")?;
    let title = "Heightmap of the packed container";
    let heights = drawing::heights(title, grid, packing.scene.heightmap(), None);
    let heights = heights.context("heightmap.png cannot be drawn")?;
    let mut files = StagedFolder::new(folder)?;
    files.add("packed.png", &packed)?;
    files.add("heightmap.png", &heights)?;
    files.add("placements.csv", &csv::placements(packing)?)?;
    let page = html::page(packing, summary, [&packed, &heights])?;
    files.add(PAGE_FILE, page.as_bytes())?;
    files.add("summary.json", &serde_json::to_vec_pretty(summary)?)?;
    if let Some((name, content)) = further {
        files.add(name, content)?;
    }
    Ok(files.publish()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_did_not_stay_is_said_once() {
        for (slide_m, toppled, inside, said) in [
            (0.001, false, true, None),
            (0.031, false, true, Some("slid by 3.1 cm")),
            (0.031, true, true, Some("toppled")),
            (0.031, true, false, Some("fell out")),
        ] {
            let settled = Settled {
                slide_m,
                tilt_rad: 0.0,
                toppled,
                inside,
            };
            assert_eq!(settled.unsteadiness().as_deref(), said);
        }
    }
}
