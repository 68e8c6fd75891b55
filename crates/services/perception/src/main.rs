//! `ppnpack-perception`: the perception service as a process.

use std::process::ExitCode;

use anyhow::{Context, Result};
use ppnpack_catalogue::catalogue::{self, Catalogue};
use ppnpack_packing::kernel::grid::Resolution;
use ppnpack_perception_service::{Objects, Settings};
use ppnpack_recognition::library::{Library, LibrarySettings};
use ppnpack_service::Process;
use ppnpack_wire::keys::Service;

fn main() -> ExitCode {
    ppnpack_service::main(Service::Perception, |process, settings: Settings| {
        let objects = objects(process, &settings)?;
        Ok(Box::new(ppnpack_perception_service::start(
            process,
            &settings,
            objects.as_ref(),
        )?))
    })
}

/// Gives the objects that can be recognised, where there are any.
fn objects(process: &Process, settings: &Settings) -> Result<Option<Objects>> {
    let Some(name) = &settings.catalogue else {
        return Ok(None);
    };
    // Objects are recognised by their meshes: the resolution does not matter.
    let resolution = Resolution::reference();
    let (source, settings) = (
        ppnpack_household::source(name),
        catalogue::Settings::default(),
    );
    let loaded = Catalogue::load(&source, &settings, &resolution, &|_, _| {});
    let models = loaded.context("the catalogue cannot be loaded")?.models();
    let prepare = move || Library::new(&models, LibrarySettings::default());
    Ok(Some(Objects::preparing(process, prepare)?))
}
