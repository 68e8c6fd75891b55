//! The report on one packed sequence.

mod arm;
mod csv;
mod html;
mod pictures;
mod summary;
pub(crate) mod table;

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use anyhow::Context;
use nalgebra::Isometry3;
use ppnpack_catalogue::object::Model;
use ppnpack_packing::episode::Step;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::metrics::Metrics;
use serde::Serialize;

use crate::fastest::Cost;
use crate::options::{Method, Simulated};
use crate::output::StagedFolder;
use crate::sequence::Sequence;
pub(crate) use arm::{ArmAsked, ArmWork};
pub(crate) use summary::{EndingSummary, Summary, Unplaceable};

/// Everything a packing depended on.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Settings {
    pub(crate) catalogue: String,
    pub(crate) catalogue_hash: String,
    pub(crate) objects: usize,
    pub(crate) sequence: Sequence,
    pub(crate) grid: Grid,
    pub(crate) method: Method,
    /// What each source of proposals was measured to cost, where the fastest was asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) costs: Vec<Cost>,
    pub(crate) threads: u32,
    pub(crate) simulated: Simulated,
}

/// A packed sequence.
#[derive(Debug)]
pub(crate) struct Packing {
    pub(crate) settings: Settings,
    /// The steps in order.
    pub(crate) steps: Vec<Step>,
    /// What became of each placement by the end of its settling phase.
    pub(crate) settled: Vec<Settled>,
    pub(crate) ending: EndingSummary,
    /// The scene at the end.
    pub(crate) scene: Scene,
    pub(crate) metrics: Metrics,
    /// What lies in or on the container, with its place in the sequence of arrivals.
    pub(crate) contents: Vec<(usize, Content)>,
    pub(crate) took: Duration,
    /// The arm's part, where there was one.
    pub(crate) arm: Option<ArmWork>,
}

/// What became of a placement by the end of its settling phase.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Settled {
    pub(crate) slide_m: f64,
    pub(crate) tilt_rad: f64,
    pub(crate) toppled: bool,
    pub(crate) inside: bool,
}

/// Something that lies in or on the container.
#[derive(Debug)]
pub struct Content {
    /// What it is.
    pub model: Arc<Model>,
    /// How it lies.
    pub container_from_item: Isometry3<f64>,
    /// Whether its centre is inside.
    pub inside: bool,
}

/// Writes all files of the report, or none.
pub(crate) fn write(packing: &Packing, summary: &Summary, folder: &Path) -> anyhow::Result<()> {
    let pictures = pictures::draw(packing)?;
    let mut files = StagedFolder::new(folder)?;
    files.add("packed.png", &pictures.packed_png)?;
    files.add("heightmap.png", &pictures.heightmap_png)?;
    files.add("placements.csv", &csv::placements(packing)?)?;
    files.add(
        "report.html",
        html::page(packing, summary, &pictures).as_bytes(),
    )?;
    let json = serde_json::to_vec_pretty(summary).context("the summary cannot be encoded")?;
    files.add("summary.json", &json)?;
    Ok(files.publish()?)
}
