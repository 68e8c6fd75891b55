//! Catalogues: the objects that a cell packs, ready at one resolution.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use ppnpack_packing::kernel::grid::Resolution;
use ppnpack_packing::kernel::item::Item;
use rayon::iter::Either;
use rayon::prelude::*;

use crate::cache::Cache;
use crate::object::{CatalogueObject, Model};
use crate::poses;
use crate::shape_class::ShapeClass;
use crate::source::Origin;
use crate::views;

pub use crate::error::{CatalogueError, ObjectError};
pub use crate::source::{NamedMesh, Settings, Source};

/// Objects ready to be packed at one resolution; sequences refer to them by index.
#[derive(Debug, Clone)]
pub struct Catalogue {
    /// The objects, in the order of their indices.
    pub objects: Vec<CatalogueObject>,
    /// Resolution of their items.
    pub resolution: Resolution,
}

impl Catalogue {
    /// Loads the objects of a source, in parallel.
    ///
    /// `progress` is called with the number of objects done and their total, from any thread.
    ///
    /// # Errors
    /// [`CatalogueError`] where the folder or its table is wrong; where files are, it names them
    /// all.
    pub fn load(
        source: &Source,
        settings: &Settings,
        resolution: &Resolution,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Self, CatalogueError> {
        Self::load_only(source, settings, &[], resolution, progress)
    }

    /// Loads the objects of these names alone, or all where there are none. Their indices are those
    /// among them.
    pub fn load_only(
        source: &Source,
        settings: &Settings,
        names: &[String],
        resolution: &Resolution,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Self, CatalogueError> {
        let mut origins = source.origins(settings)?;
        origins.retain(|origin| names.is_empty() || names.contains(&origin.name));
        let cache = Cache::new(&settings.cache);
        let done = AtomicUsize::new(0);
        let load = |origin: &Origin<'_>| {
            let entry = origin.model(&cache).inspect(|entry| origin.warn(entry));
            let object = entry.and_then(|entry| packable(entry.model, settings.poses, resolution));
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, origins.len());
            match object {
                Ok(object) => Either::Left(object),
                Err(error) => Either::Right(format!("{} {error}", origin.path.display())),
            }
        };
        let (objects, bad): (Vec<_>, Vec<String>) = origins.par_iter().partition_map(load);
        if settings.skip_unusable && !objects.is_empty() {
            for bad in &bad {
                tracing::warn!("left out: {bad}");
            }
        } else if !bad.is_empty() {
            return Err(CatalogueError(bad.join("\n")));
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

    /// The objects of one class alone, in the same order; their indices are others.
    #[must_use]
    pub fn of_class(&self, class: ShapeClass) -> Self {
        let objects = self.objects.iter();
        let of_class = objects.filter(|object| ShapeClass::of(&object.model) == class);
        Self {
            objects: of_class.cloned().collect(),
            resolution: self.resolution.clone(),
        }
    }

    /// The items of all objects, by index, each in its first pose.
    pub fn items(&self) -> Vec<Arc<Item>> {
        self.objects
            .iter()
            .map(|object| object.item.clone())
            .collect()
    }

    /// The geometry of all objects, by index, each in its first pose.
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

    /// A digest of all objects, their poses, their order and the resolution, in hexadecimal.
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
            for posed in &object.poses {
                update(postcard::to_stdvec(&posed.rotation).unwrap_or_default());
            }
        }
        hasher.finalize().to_hex().to_string()
    }
}

/// An object ready to be packed in at most so many poses, at least one.
fn packable(
    model: Model,
    poses: usize,
    resolution: &Resolution,
) -> Result<CatalogueObject, ObjectError> {
    let item = views::item(&model, resolution)?;
    Ok(CatalogueObject {
        poses: poses::further(&model, &item, poses.saturating_sub(1), resolution),
        model: Arc::new(model),
        item: Arc::new(item),
    })
}
