//! Reports of each object of a source, good or bad.

use std::path::PathBuf;

use rayon::prelude::*;

use crate::cache::Cache;
use crate::error::{CatalogueError, ObjectError};
use crate::source::{Settings, Source};

pub use crate::cache::Entry;

/// A file of a source, and the object in it or why there is none.
#[derive(Debug)]
pub struct ObjectReport {
    /// The file, or the name of a mesh that was given.
    pub path: PathBuf,
    /// Its object, or the reason that there is none.
    pub outcome: Result<Entry, ObjectError>,
}

/// Looks at every object of a source, in its order, whether others are bad or not.
pub fn inspect(source: &Source, settings: &Settings) -> Result<Vec<ObjectReport>, CatalogueError> {
    let origins = source.origins(settings)?;
    let cache = Cache::new(&settings.cache);
    let reports = origins.par_iter().map(|origin| ObjectReport {
        path: origin.path.clone(),
        outcome: origin.model(&cache),
    });
    Ok(reports.collect())
}
