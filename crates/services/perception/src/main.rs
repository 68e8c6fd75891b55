//! `ppnpack-perception`: the perception service as a process.

use std::process::ExitCode;
use std::sync::Arc;

use anyhow::{Context, Result};
use ppnpack_catalogue::catalogue::{self, Catalogue};
use ppnpack_packing::grid::Resolution;
use ppnpack_perception_service::Settings;
use ppnpack_recognition::library::{Library, LibrarySettings};
use ppnpack_wire::keys::Service;

fn main() -> ExitCode {
    ppnpack_service::main(Service::Perception, |process, settings: Settings| {
        let library = library(&settings)?;
        Ok(Box::new(ppnpack_perception_service::start(
            process,
            &settings,
            library.as_ref(),
        )?))
    })
}

/// The objects that can be recognised, where there are any.
fn library(settings: &Settings) -> Result<Option<Arc<Library>>> {
    let Some(name) = &settings.catalogue else {
        return Ok(None);
    };
    // Objects are recognised by their meshes: the resolution does not matter.
    let resolution = Resolution::reference();
    let loaded = Catalogue::load(
        &ppnpack_household::source(name),
        &catalogue::Settings::default(),
        &resolution,
        &|_, _| {},
    );
    let catalogue = loaded.context("the catalogue cannot be loaded")?;
    let library = Library::new(&catalogue.models(), LibrarySettings::default())?;
    Ok(Some(Arc::new(library)))
}
