//! `ppnpack-planner`: the planner service as a process.

use std::process::ExitCode;
use std::sync::Arc;

use anyhow::{Context, Result};
use ppnpack_catalogue::catalogue::{self, Catalogue};
use ppnpack_packing::kernel::grid::Resolution;
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

/// The catalogue on the grid of each cell, in as many poses as any cell of that grid may use.
fn catalogues(settings: &Settings) -> Result<Vec<Arc<Catalogue>>> {
    let usual = catalogue::Settings::default();
    let source = ppnpack_household::source(&settings.catalogue);
    let mut resolutions: Vec<(Resolution, usize)> = Vec::new();
    for cell in settings.cells.values() {
        let resolution = cell.grid.resolution()?;
        match resolutions
            .iter_mut()
            .find(|(known, _)| *known == resolution)
        {
            Some((_, poses)) => *poses = cell.poses.max(*poses),
            None => resolutions.push((resolution, cell.poses)),
        }
    }
    let load = |(resolution, poses): &(Resolution, usize)| {
        let settings = catalogue::Settings {
            poses: *poses,
            ..usual.clone()
        };
        let loaded = Catalogue::load(&source, &settings, resolution, &|_, _| {});
        loaded
            .map(Arc::new)
            .context("the catalogue cannot be loaded")
    };
    resolutions.iter().map(load).collect()
}
