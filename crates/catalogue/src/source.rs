//! Sources of objects, and single objects before and while they become models.

use std::path::PathBuf;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::build::{ModelSettings, Pose, model};
use crate::cache::{Cache, CacheDir, Entry, Key};
use crate::error::{CatalogueError, ObjectError};
use crate::mass::DEFAULT_DENSITY_KG_M3;
use crate::mesh::Mesh;
use crate::reader;
use crate::table;
use crate::unit::LengthUnit;

/// Source of objects.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// Meshes that the program has, in their order; no two have the same name.
    Meshes(Arc<[NamedMesh]>),
    /// A folder of mesh files, in the order of its `objects.csv` where it has one, else by file
    /// name.
    Folder(PathBuf),
}

/// A mesh that is no file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NamedMesh {
    /// Unique in its source.
    pub name: String,
    /// The closed surface, in metres.
    pub mesh: Mesh,
    /// Mass over enclosed volume, in kg/m^3.
    pub density_kg_m3: f64,
}

/// Settings by which a catalogue is made of meshes.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The unit of mesh files for which `objects.csv` gives none.
    pub unit: LengthUnit,
    /// The density of objects for which `objects.csv` gives no mass, in kg/m^3.
    pub density_kg_m3: f64,
    /// The pose in which objects are packed; with several, the first of them.
    pub pose: Pose,
    /// Whether files that cannot be used are left out with a warning; the objects after them have
    /// lower indices.
    pub skip_unusable: bool,
    /// Maximum number of resting poses in which an object may be packed; it always may in the
    /// first.
    pub poses: usize,
    /// Place of models between runs.
    pub cache: CacheDir,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            unit: LengthUnit::Metres,
            density_kg_m3: DEFAULT_DENSITY_KG_M3,
            pose: Pose::AsGiven,
            skip_unusable: false,
            poses: 1,
            cache: CacheDir::User,
        }
    }
}

/// Origin of one object.
#[derive(Debug)]
pub(crate) struct Origin<'a> {
    pub(crate) name: String,
    /// The file, or the name of a mesh that was given.
    pub(crate) path: PathBuf,
    /// Settings by which its mesh becomes a model.
    settings: ModelSettings,
    /// The mesh that was given.
    given: Option<&'a Mesh>,
}

impl Source {
    /// The objects, in their order.
    pub(crate) fn origins(&self, settings: &Settings) -> Result<Vec<Origin<'_>>, CatalogueError> {
        let usual = ModelSettings {
            unit: settings.unit,
            density_kg_m3: settings.density_kg_m3,
            mass_kg: None,
            carries_kg: None,
            pose: settings.pose,
        };
        let origins = match self {
            Self::Meshes(meshes) => meshes
                .iter()
                .map(|given| Origin {
                    name: given.name.clone(),
                    path: PathBuf::from(&given.name),
                    settings: ModelSettings {
                        unit: LengthUnit::Metres,
                        density_kg_m3: given.density_kg_m3,
                        ..usual
                    },
                    given: Some(&given.mesh),
                })
                .collect(),
            Self::Folder(folder) => table::list(folder)?
                .into_iter()
                .map(|listed| Origin {
                    settings: ModelSettings {
                        unit: listed
                            .unit
                            .or_else(|| reader::own_unit(&listed.path))
                            .unwrap_or(usual.unit),
                        mass_kg: listed.mass_kg,
                        carries_kg: listed.carries_kg,
                        ..usual
                    },
                    name: listed.name,
                    path: listed.path,
                    given: None,
                })
                .collect(),
        };
        Ok(origins)
    }
}

impl Origin<'_> {
    /// The model, from the cache if it is there.
    pub(crate) fn model(&self, cache: &Cache) -> Result<Entry, ObjectError> {
        let (tag, content) = match self.given {
            Some(mesh) => {
                let content = postcard::to_stdvec(mesh).unwrap_or_default();
                ("given".to_owned(), content)
            }
            None => (reader::ending(&self.path), reader::read_bytes(&self.path)?),
        };
        let key = Key::new(&tag, &content, &self.settings);
        if let Some(mut entry) = cache.get(&key) {
            // The same mesh may be in the cache under another name.
            entry.model.name.clone_from(&self.name);
            return Ok(entry);
        }
        let mesh = match self.given {
            Some(mesh) => mesh.clone(),
            None => reader::parse(&self.path, &content, self.settings.unit)?,
        };
        let (model, repairs) = model(&self.name, mesh, &self.settings)?;
        for repair in &repairs {
            tracing::debug!(object = self.name, %repair, "mesh repaired");
        }
        let entry = Entry { model, repairs };
        cache.put(&key, &entry);
        Ok(entry)
    }

    /// Logs what should be looked at before the object is packed.
    pub(crate) fn warn(&self, entry: &Entry) {
        for doubt in entry.repairs.iter().filter(|repair| repair.is_doubt()) {
            tracing::warn!(object = self.name, "{doubt}");
        }
    }
}
