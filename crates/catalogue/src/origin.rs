//! Single objects of a source, before and while they become models.

use std::path::{Path, PathBuf};

use crate::build::{ModelSettings, model};
use crate::cache::{Cache, Entry, Key};
use crate::catalogue::{CatalogueError, ObjectError, Settings, Source};
use crate::household::{self, HouseholdObject};
use crate::reader;
use crate::table::{self, Listed};
use crate::unit::LengthUnit;

/// Where one object comes from.
#[derive(Debug)]
pub(crate) enum Origin {
    Builtin(HouseholdObject),
    File(Listed),
}

/// The objects of a source, in its order.
pub(crate) fn origins(source: &Source) -> Result<Vec<Origin>, CatalogueError> {
    match source {
        Source::Builtin => Ok(household::objects()
            .into_iter()
            .map(Origin::Builtin)
            .collect()),
        Source::Folder(folder) => Ok(table::list(folder)?.into_iter().map(Origin::File).collect()),
    }
}

impl Origin {
    pub(crate) fn name(&self) -> &str {
        match self {
            Self::Builtin(object) => object.name,
            Self::File(listed) => &listed.name,
        }
    }

    /// The file, or the name of a built-in object.
    pub(crate) fn path(&self) -> PathBuf {
        match self {
            Self::Builtin(object) => PathBuf::from(object.name),
            Self::File(listed) => listed.path.clone(),
        }
    }

    /// The model, from the cache if it is there.
    pub(crate) fn model(&self, settings: &Settings, cache: &Cache) -> Result<Entry, ObjectError> {
        let made = match self {
            Self::Builtin(object) => {
                // The set is made in metres and in the pose in which it is packed.
                let settings = ModelSettings {
                    unit: LengthUnit::Metres,
                    density_kg_m3: object.density_kg_m3,
                    mass_kg: None,
                    pose: settings.pose,
                };
                let source = postcard::to_stdvec(&object.mesh).unwrap_or_default();
                cached(cache, &Key::new("builtin", &source, &settings), || {
                    Ok(entry(object.name, object.mesh.clone(), &settings)?)
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

fn entry(
    name: &str,
    mesh: crate::mesh::Mesh,
    settings: &ModelSettings,
) -> Result<Entry, crate::repair::MeshError> {
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
