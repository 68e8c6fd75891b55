//! The objects that can be recognised.
//!
//! To compare them with each other takes seconds. Heightmaps do not wait for that: without them
//! nothing is packed.

use std::sync::{Arc, OnceLock};

use ppnpack_recognition::library::Library;
use ppnpack_service::health::HealthLatch;
use ppnpack_service::process::thread;
use ppnpack_service::{Process, ServiceError};

/// Refusal of requests until the objects are there.
pub(crate) const PREPARING: &str = "the objects that can be recognised are still being prepared; the health check `objects` says more";

/// The objects that can be recognised, now or soon. Clones share them.
#[derive(Clone)]
pub struct Objects {
    library: Arc<OnceLock<Arc<Library>>>,
    /// Held, as a health check fails when nobody holds it.
    _health: Option<HealthLatch>,
}

impl Objects {
    /// Gives objects that are there.
    pub fn of(library: Arc<Library>) -> Self {
        Self {
            library: Arc::new(OnceLock::from(library)),
            _health: None,
        }
    }

    /// Has a thread prepare objects. The health check `objects` fails until they are there, and
    /// says why where they never are.
    ///
    /// # Errors
    /// [`ServiceError::System`] where there can be no more threads.
    pub fn preparing<E: std::fmt::Display>(
        process: &Process,
        prepare: impl FnOnce() -> Result<Library, E> + Send + 'static,
    ) -> Result<Self, ServiceError> {
        let health = process.health().check("objects");
        let objects = Self {
            library: Arc::default(),
            _health: Some(health.clone()),
        };
        let library = Arc::clone(&objects.library);
        thread("objects", move || match prepare() {
            Ok(prepared) => {
                library.get_or_init(|| Arc::new(prepared));
                health.pass();
            }
            Err(error) => health.fail(error.to_string()),
        })?;
        Ok(objects)
    }

    pub(crate) fn get(&self) -> Option<&Arc<Library>> {
        self.library.get()
    }
}
