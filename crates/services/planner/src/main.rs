//! `ppnpack-planner`: the planner service as a process.

use std::process::ExitCode;
use std::sync::Arc;

use anyhow::{Context, Result};
use ppnpack_catalogue::catalogue::{self, Catalogue};
use ppnpack_packing::grid::Resolution;
use ppnpack_planner::Settings;
use ppnpack_service as run;
use ppnpack_wire::keys::Service;

fn main() -> ExitCode {
    run::main(Service::Planner, |process, settings: Settings| {
        let catalogues = catalogues(&settings)?;
        Ok(Box::new(ppnpack_planner::start(
            process,
            &settings,
            &catalogues,
        )?))
    })
}

/// The catalogue on the grid of each cell.
fn catalogues(settings: &Settings) -> Result<Vec<Arc<Catalogue>>> {
    let source = ppnpack_household::source(&settings.catalogue);
    let mut resolutions: Vec<Resolution> = Vec::new();
    for cell in settings.cells.values() {
        let resolution = cell.grid.resolution()?;
        if !resolutions.contains(&resolution) {
            resolutions.push(resolution);
        }
    }
    let load = |resolution: &Resolution| {
        let settings = catalogue::Settings::default();
        let loaded = Catalogue::load(&source, &settings, resolution, &|_, _| {});
        loaded
            .map(Arc::new)
            .context("the catalogue cannot be loaded")
    };
    resolutions.iter().map(load).collect()
}
