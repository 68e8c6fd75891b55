//! Models on disk, so that a catalogue is decomposed once.

use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use ppnpack_files::write_whole;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::build::ModelSettings;
use crate::object::Model;
use crate::repair::Repair;

/// Changes whenever a model made from the same mesh would differ; older entries are then not found.
const VERSION: u32 = 3;

/// Larger entries are not read, in bytes.
const MAX_ENTRY_BYTES: u64 = 1 << 30;

/// Place of models between runs.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum CacheDir {
    /// `$XDG_CACHE_HOME/ppnpack`, else `~/.cache/ppnpack`; nowhere if neither variable is set.
    #[default]
    User,
    /// A directory, made when needed.
    At(PathBuf),
    /// Nowhere.
    Nowhere,
}

impl CacheDir {
    /// The directory; `None` where models are not kept.
    pub fn path(&self) -> Option<PathBuf> {
        let variable = |name| {
            std::env::var_os(name)
                .map(PathBuf::from)
                .filter(|path| path.is_absolute())
        };
        match self {
            Self::At(path) => Some(path.clone()),
            Self::Nowhere => None,
            Self::User => variable("XDG_CACHE_HOME")
                .or_else(|| Some(variable("HOME")?.join(".cache")))
                .map(|path| path.join("ppnpack")),
        }
    }
}

/// Identifies a mesh and how a model is made from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Key(blake3::Hash);

impl Key {
    /// The key of a mesh's source: a format or other tag, the bytes, and the settings.
    pub(crate) fn new(tag: &str, bytes: &[u8], settings: &ModelSettings) -> Self {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&VERSION.to_le_bytes());
        // Lengths keep the parts apart.
        for part in [tag.as_bytes(), format!("{settings:?}").as_bytes(), bytes] {
            hasher.update(&(part.len() as u64).to_le_bytes());
            hasher.update(part);
        }
        Self(hasher.finalize())
    }
}

/// A model, and what was repaired about its mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// The model; in the cache it may have another name.
    pub model: Model,
    /// The repairs.
    pub repairs: Vec<Repair>,
}

/// Models in a directory: one file per key, the checksum of its content before the content.
///
/// Files are written beside and renamed, so that processes that share the directory only ever see
/// whole ones. Nothing that goes wrong here is more than a warning.
#[derive(Debug)]
pub(crate) struct Cache {
    directory: Option<PathBuf>,
}

impl Cache {
    pub(crate) fn new(directory: &CacheDir) -> Self {
        let usable = directory
            .path()
            .filter(|path| match fs::create_dir_all(path) {
                Ok(()) => true,
                Err(error) => {
                    tracing::warn!(path = %path.display(), %error, "models are not cached");
                    false
                }
            });
        Self { directory: usable }
    }

    /// The entry of a key; `None` where there is none or it is damaged.
    pub(crate) fn get(&self, key: &Key) -> Option<Entry> {
        load(&self.path(key)?)
    }

    /// Keeps an entry.
    pub(crate) fn put(&self, key: &Key, entry: &Entry) {
        if let Some(path) = self.path(key) {
            store(&path, entry);
        }
    }

    fn path(&self, key: &Key) -> Option<PathBuf> {
        Some(
            self.directory
                .as_ref()?
                .join(format!("{}.model", key.0.to_hex())),
        )
    }
}

/// Reads a file of the cache; `None` where there is none or it is damaged.
fn load<T: DeserializeOwned>(path: &Path) -> Option<T> {
    match read(path) {
        Ok(bytes) => {
            let content = decoded(&bytes);
            if content.is_none() {
                tracing::warn!(path = %path.display(), "a damaged cache entry is made anew");
            }
            content
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => {
            tracing::warn!(path = %path.display(), %error, "a cache entry cannot be read");
            None
        }
    }
}

/// Keeps it in a file of the cache.
fn store(path: &Path, content: &impl Serialize) {
    let kept = match encoded(content) {
        Ok(bytes) => write_whole(path, &bytes).map_err(|error| error.to_string()),
        Err(error) => Err(error.to_string()),
    };
    if let Err(error) = kept {
        tracing::warn!(path = %path.display(), %error, "a cache entry is not kept");
    }
}

fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    fs::File::open(path)?
        .take(MAX_ENTRY_BYTES)
        .read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn decoded<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    let (checksum, content) = bytes.split_at_checked(blake3::OUT_LEN)?;
    if blake3::hash(content).as_bytes() != checksum {
        return None;
    }
    postcard::from_bytes(content).ok()
}

fn encoded(content: &impl Serialize) -> Result<Vec<u8>, postcard::Error> {
    let content = postcard::to_stdvec(content)?;
    Ok([blake3::hash(&content).as_bytes(), content.as_slice()].concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::model;
    use crate::shapes::cube;
    use crate::unit::LengthUnit;

    fn entry() -> Entry {
        let (model, repairs) = model("cube", cube(0.1), &ModelSettings::default()).unwrap();
        Entry { model, repairs }
    }

    fn cache(directory: &Path) -> (Cache, Key) {
        let cache = Cache::new(&CacheDir::At(directory.join("models")));
        (cache, Key::new("test", b"cube", &ModelSettings::default()))
    }

    #[test]
    fn what_is_kept_comes_back() {
        let directory = tempfile::tempdir().unwrap();
        let (cache, key) = cache(directory.path());
        assert_eq!(cache.get(&key), None);
        cache.put(&key, &entry());
        assert_eq!(cache.get(&key), Some(entry()));
        let settings = ModelSettings {
            unit: LengthUnit::Inches,
            ..ModelSettings::default()
        };
        assert_eq!(cache.get(&Key::new("test", b"cube", &settings)), None);
        let files = fs::read_dir(directory.path().join("models"))
            .unwrap()
            .count();
        assert_eq!(files, 1);
    }

    #[test]
    fn damaged_entries_are_not_used() {
        let directory = tempfile::tempdir().unwrap();
        let (cache, key) = cache(directory.path());
        cache.put(&key, &entry());
        let path = cache.path(&key).unwrap();
        let whole = fs::read(&path).unwrap();
        for cut in [0, 10, blake3::OUT_LEN, whole.len() / 2, whole.len() - 1] {
            fs::write(&path, &whole[..cut]).unwrap();
            assert_eq!(cache.get(&key), None, "cut to {cut}");
        }
        for at in [0, 40, whole.len() - 1] {
            let mut damaged = whole.clone();
            damaged[at] ^= 1;
            fs::write(&path, damaged).unwrap();
            assert_eq!(cache.get(&key), None, "damaged at {at}");
        }
        cache.put(&key, &entry());
        assert_eq!(cache.get(&key), Some(entry()));
    }

    #[test]
    fn a_directory_that_cannot_be_made_is_done_without() {
        let directory = tempfile::tempdir().unwrap();
        fs::write(directory.path().join("models"), "a file").unwrap();
        let (cache, key) = cache(directory.path());
        cache.put(&key, &entry());
        assert_eq!(cache.get(&key), None);
    }
}
