//! Where objects come from, and single objects before and while they become models.

use std::path::{Path, PathBuf};

use crate::build::{ModelSettings, Pose, model};
use crate::cache::{Cache, CacheDir, Entry, Key};
use crate::error::{CatalogueError, ObjectError};
use crate::mass::DEFAULT_DENSITY_KG_M3;
use crate::mesh::Mesh;
use crate::reader;
use crate::repair::MeshError;
use crate::table::{self, Listed};
use crate::unit::LengthUnit;

/// Where objects come from.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// Meshes that the program has, in their order; no two have the same name.
    Meshes(Vec<NamedMesh>),
    /// A folder of mesh files, in the order of its `objects.csv` where it has one, else by file name.
    Folder(PathBuf),
}

/// A mesh that is no file.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedMesh {
    /// Unique in its source.
    pub name: String,
    /// The closed surface, in metres.
    pub mesh: Mesh,
    /// Mass over enclosed volume, in kg/m^3.
    pub density_kg_m3: f64,
}

/// How a catalogue is made of meshes.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The unit of mesh files for which `objects.csv` gives none.
    pub unit: LengthUnit,
    /// The density of objects for which `objects.csv` gives no mass, in kg/m^3.
    pub density_kg_m3: f64,
    /// The pose in which objects are packed.
    pub pose: Pose,
    /// Where models are kept between runs.
    pub cache: CacheDir,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            unit: LengthUnit::Metres,
            density_kg_m3: DEFAULT_DENSITY_KG_M3,
            pose: Pose::AsGiven,
            cache: CacheDir::User,
        }
    }
}

/// Where one object comes from.
#[derive(Debug)]
pub(crate) enum Origin<'a> {
    Mesh(&'a NamedMesh),
    File(Listed),
}

impl Source {
    /// The objects, in their order.
    pub(crate) fn origins(&self) -> Result<Vec<Origin<'_>>, CatalogueError> {
        match self {
            Self::Meshes(meshes) => Ok(meshes.iter().map(Origin::Mesh).collect()),
            Self::Folder(folder) => {
                Ok(table::list(folder)?.into_iter().map(Origin::File).collect())
            }
        }
    }
}

impl Origin<'_> {
    pub(crate) fn name(&self) -> &str {
        match self {
            Self::Mesh(given) => &given.name,
            Self::File(listed) => &listed.name,
        }
    }

    /// The file, or the name of a mesh that was given.
    pub(crate) fn path(&self) -> PathBuf {
        match self {
            Self::Mesh(given) => PathBuf::from(&given.name),
            Self::File(listed) => listed.path.clone(),
        }
    }

    /// The model, from the cache if it is there.
    pub(crate) fn model(&self, settings: &Settings, cache: &Cache) -> Result<Entry, ObjectError> {
        let made = match self {
            Self::Mesh(given) => {
                let settings = ModelSettings {
                    unit: LengthUnit::Metres,
                    density_kg_m3: given.density_kg_m3,
                    mass_kg: None,
                    pose: settings.pose,
                };
                let source = postcard::to_stdvec(&given.mesh).unwrap_or_default();
                cached(cache, &Key::new("given", &source, &settings), || {
                    Ok(entry(&given.name, given.mesh.clone(), &settings)?)
                })
            }
            Self::File(listed) => {
                let settings = ModelSettings {
                    unit: listed.unit.unwrap_or(settings.unit),
                    density_kg_m3: settings.density_kg_m3,
                    mass_kg: listed.mass_kg,
                    pose: settings.pose,
                };
                let bytes = reader::read_bytes(&listed.path)?;
                cached(
                    cache,
                    &Key::new(&format(&listed.path), &bytes, &settings),
                    || {
                        let mesh = reader::parse(&listed.path, &bytes, settings.unit)?;
                        Ok(entry(&listed.name, mesh, &settings)?)
                    },
                )
            }
        };
        // The same mesh may be in the cache under another name.
        made.map(|mut entry| {
            entry.model.name = self.name().to_owned();
            entry
        })
    }
}

fn format(path: &Path) -> String {
    path.extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase()
}

fn entry(name: &str, mesh: Mesh, settings: &ModelSettings) -> Result<Entry, MeshError> {
    let (model, repairs) = model(name, mesh, settings)?;
    for repair in &repairs {
        tracing::debug!(object = name, %repair, "mesh repaired");
    }
    Ok(Entry { model, repairs })
}

fn cached(
    cache: &Cache,
    key: &Key,
    make: impl FnOnce() -> Result<Entry, ObjectError>,
) -> Result<Entry, ObjectError> {
    if let Some(entry) = cache.get(key) {
        return Ok(entry);
    }
    let entry = make()?;
    cache.put(key, &entry);
    Ok(entry)
}
