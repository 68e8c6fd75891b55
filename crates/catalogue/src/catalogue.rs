//! Catalogues: the objects that a cell packs, ready at one resolution.

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use ppnpack_packing::grid::Resolution;
use ppnpack_packing::item::Item;
use rayon::prelude::*;

use crate::build::Pose;
use crate::cache::{Cache, CacheDir};
use crate::mass::DEFAULT_DENSITY_KG_M3;
use crate::object::{CatalogueObject, Model};
use crate::origin::origins;
use crate::reader::ReadError;
use crate::repair::MeshError;
use crate::unit::LengthUnit;
use crate::views::{self, ViewError};

/// Where objects come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Source {
    /// The household set that is built in.
    Builtin,
    /// A folder of mesh files, in the order of its `objects.csv` where it has one, else by file name.
    Folder(PathBuf),
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

/// Why a file is no object that can be packed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ObjectError {
    /// It cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// Its mesh is no solid.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// It cannot be packed at the resolution.
    #[error(transparent)]
    View(#[from] ViewError),
}

/// A file that is no object that can be packed, and why.
#[derive(Debug, thiserror::Error)]
#[error("{} {error}", path.display())]
pub struct BadObject {
    /// The file, or the name of a built-in object.
    pub path: PathBuf,
    /// What is wrong with it.
    pub error: ObjectError,
}

/// Why a catalogue could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CatalogueError {
    /// The folder does not exist.
    #[error("{} is no folder: give the folder that holds the mesh files", folder.display())]
    MissingFolder {
        /// The folder given.
        folder: PathBuf,
    },
    /// The folder has no mesh file.
    #[error("{} holds no .ply, .obj or .stl file", folder.display())]
    EmptyFolder {
        /// The folder given.
        folder: PathBuf,
    },
    /// The folder or its table cannot be read.
    #[error("{} cannot be read: {source}", folder.display())]
    Folder {
        /// The folder or the table.
        folder: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A line of `objects.csv` is wrong.
    #[error("{}:{line}: {reason}", path.display())]
    Table {
        /// The table.
        path: PathBuf,
        /// The line, counted from 1.
        line: u64,
        /// What is wrong, and what to do.
        reason: String,
    },
    /// Two objects have the same name.
    #[error(
        "the name '{name}' stands for both {} and {}: rename one",
        first.display(),
        second.display()
    )]
    DuplicateName {
        /// The name.
        name: String,
        /// One file.
        first: PathBuf,
        /// The other file.
        second: PathBuf,
    },
    /// Some files are no objects that can be packed.
    #[error("{}", Lines(bad))]
    Objects {
        /// Each such file, in the catalogue's order.
        bad: Vec<BadObject>,
    },
}

/// One file a line.
struct Lines<'a>(&'a [BadObject]);

impl fmt::Display for Lines<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, bad) in self.0.iter().enumerate() {
            let line_break = if index > 0 { "\n" } else { "" };
            write!(formatter, "{line_break}{bad}")?;
        }
        Ok(())
    }
}

/// Objects ready to be packed at one resolution; sequences refer to them by index.
#[derive(Debug, Clone)]
pub struct Catalogue {
    /// The objects, in the order of their indices.
    pub objects: Vec<CatalogueObject>,
    /// What their items are made for.
    pub resolution: Resolution,
}

impl Catalogue {
    /// Loads the objects of a source, in parallel.
    ///
    /// `progress` is called with the number of objects done and their total, from any thread.
    ///
    /// # Errors
    /// [`CatalogueError`] where the folder or its table is wrong; where files are, it names them all.
    pub fn load(
        source: &Source,
        settings: &Settings,
        resolution: &Resolution,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Self, CatalogueError> {
        let origins = origins(source)?;
        let cache = Cache::new(&settings.cache);
        let done = AtomicUsize::new(0);
        let loaded: Vec<Result<CatalogueObject, BadObject>> = origins
            .par_iter()
            .map(|origin| {
                let object = origin
                    .model(settings, &cache)
                    .and_then(|entry| packable(entry.model, resolution));
                progress(done.fetch_add(1, Ordering::Relaxed) + 1, origins.len());
                object.map_err(|error| BadObject {
                    path: origin.path(),
                    error,
                })
            })
            .collect();
        let (mut objects, mut bad) = (Vec::with_capacity(loaded.len()), Vec::new());
        for result in loaded {
            match result {
                Ok(object) => objects.push(object),
                Err(error) => bad.push(error),
            }
        }
        if !bad.is_empty() {
            return Err(CatalogueError::Objects { bad });
        }
        Ok(Self {
            objects,
            resolution: resolution.clone(),
        })
    }

    /// The object with an index.
    pub fn get(&self, index: usize) -> Option<&CatalogueObject> {
        self.objects.get(index)
    }

    /// The object with a name, and its index.
    pub fn find(&self, name: &str) -> Option<(usize, &CatalogueObject)> {
        self.objects
            .iter()
            .enumerate()
            .find(|(_, object)| object.model.name == name)
    }

    /// The items of all objects, by index.
    pub fn items(&self) -> Vec<Arc<Item>> {
        self.objects
            .iter()
            .map(|object| object.item.clone())
            .collect()
    }

    /// The geometry of all objects, by index.
    pub fn models(&self) -> Vec<Arc<Model>> {
        let objects = self.objects.iter();
        objects.map(|object| Arc::clone(&object.model)).collect()
    }

    /// How many objects there are.
    pub fn len(&self) -> usize {
        self.objects.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.objects.is_empty()
    }

    /// A digest of all objects, their order and the resolution, in hexadecimal.
    ///
    /// Results of two runs compare only where it is the same.
    pub fn content_hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        let mut update = |bytes: Vec<u8>| {
            hasher.update(&(bytes.len() as u64).to_le_bytes());
            hasher.update(&bytes);
        };
        // Only a format that cannot hold the types fails to encode, and postcard holds these.
        update(postcard::to_stdvec(&self.resolution).unwrap_or_default());
        for object in &self.objects {
            update(postcard::to_stdvec(&*object.model).unwrap_or_default());
        }
        hasher.finalize().to_hex().to_string()
    }
}

/// An object ready to be packed.
fn packable(model: Model, resolution: &Resolution) -> Result<CatalogueObject, ObjectError> {
    let item = views::item(&model, resolution)?;
    Ok(CatalogueObject {
        model: Arc::new(model),
        item: Arc::new(item),
    })
}
