//! What is to be said of each object of a source, good or bad.

use std::path::PathBuf;

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::cache::{Cache, Entry};
use crate::error::{CatalogueError, ObjectError};
use crate::repair::Repair;
use crate::source::{Settings, Source};

/// A file of a source, and the object in it or why there is none.
#[derive(Debug)]
pub struct ObjectReport {
    /// Its place in the source.
    pub index: usize,
    /// Its name.
    pub name: String,
    /// The file, or the name of a mesh that was given.
    pub path: PathBuf,
    /// What is in it.
    pub outcome: Result<ObjectSummary, ObjectError>,
}

/// An object in numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectSummary {
    /// Triangles after repair.
    pub triangles: usize,
    /// Enclosed volume, in cubic metres.
    pub volume_m3: f64,
    /// Mass, in kilograms.
    pub mass_kg: f64,
    /// Edges of the bounding box, in metres.
    pub extents_m: Vector3<f64>,
    /// What was repaired.
    pub repairs: Vec<Repair>,
    /// Convex pieces.
    pub pieces: usize,
    /// Resting poses.
    pub resting_poses: usize,
}

/// Looks at every object of a source, whether others are bad or not.
///
/// # Errors
/// [`CatalogueError`] where the folder or its table is wrong.
pub fn inspect(source: &Source, settings: &Settings) -> Result<Vec<ObjectReport>, CatalogueError> {
    let origins = source.origins()?;
    let cache = Cache::new(&settings.cache);
    let reports = origins
        .par_iter()
        .enumerate()
        .map(|(index, origin)| ObjectReport {
            index,
            name: origin.name().to_owned(),
            path: origin.path(),
            outcome: origin.model(settings, &cache).map(summary),
        });
    Ok(reports.collect())
}

fn summary(entry: Entry) -> ObjectSummary {
    let model = entry.model;
    ObjectSummary {
        triangles: model.mesh.triangles.len(),
        volume_m3: model.volume_m3,
        mass_kg: model.mass.mass_kg,
        extents_m: model
            .mesh
            .bounds()
            .map_or_else(Vector3::zeros, |bounds| bounds.extents_m()),
        repairs: entry.repairs,
        pieces: model.pieces.len(),
        resting_poses: model.resting_poses.len(),
    }
}
