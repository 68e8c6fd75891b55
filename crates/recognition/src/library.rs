//! The objects that can be recognised.

use std::sync::Arc;

use ppnpack_catalogue::object::Model;
use rayon::prelude::*;

use crate::twins::twins;

pub use crate::object::{LibraryObject, LibrarySettings, PoseTemplate, Twin};

/// Objects that can be recognised, by index.
#[derive(Debug, Clone)]
pub struct Library {
    /// The objects.
    pub objects: Vec<LibraryObject>,
    /// Settings that they were prepared with.
    pub settings: LibrarySettings,
}

/// An object that cannot be recognised.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{name}' has no surface, or no pose in which it rests")]
pub struct NotRecognisable {
    /// Its name.
    pub name: String,
}

impl Library {
    /// Prepares models, in parallel; indices are those of the models.
    ///
    /// # Errors
    /// [`NotRecognisable`] for the first model without a surface.
    pub fn new(models: &[Arc<Model>], settings: LibrarySettings) -> Result<Self, NotRecognisable> {
        let prepare = |model: &Arc<Model>| {
            LibraryObject::new(model, &settings).ok_or_else(|| NotRecognisable {
                name: model.name.clone(),
            })
        };
        let mut objects: Vec<LibraryObject> =
            models.par_iter().map(prepare).collect::<Result<_, _>>()?;
        let found: Vec<Vec<Twin>> = objects
            .par_iter()
            .map(|object| twins(&objects, object, &settings.same_surface))
            .collect();
        for (object, twins) in objects.iter_mut().zip(found) {
            object.twins = twins;
        }
        Ok(Self { objects, settings })
    }

    /// Gives the index of an object that lies in this library.
    pub(crate) fn index_of(&self, object: &LibraryObject) -> Option<usize> {
        let mut objects = self.objects.iter();
        objects.position(|other| std::ptr::eq(other, object))
    }

    /// Says whether two objects are the same or twins.
    pub fn are_alike(&self, one: usize, other: usize) -> bool {
        let is_twin = |object: &LibraryObject| object.twins.iter().any(|twin| twin.object == other);
        let object = self.objects.get(one);
        object.is_some_and(|object| one == other || is_twin(object))
    }
}
