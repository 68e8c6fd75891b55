//! A clock that can be set, for the processes of a stack alone: libfaketime does it.
//!
//! Only the time of day steps: it is what an administrator or a time service sets.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::Result;

/// The places of the library in Debian and others.
const LIBRARIES: [&str; 3] = [
    "/usr/lib/x86_64-linux-gnu/faketime/libfaketimeMT.so.1",
    "/usr/lib/aarch64-linux-gnu/faketime/libfaketimeMT.so.1",
    "/usr/lib/faketime/libfaketimeMT.so.1",
];

/// The folder in which the library keeps a file or two for each process.
const SHARED: &str = "/dev/shm";

/// Steps from the true time that tests make.
pub(crate) const STEPS: [&str; 4] = ["+1h", "-2h", "+400d", "-400d"];

/// The true time.
pub(crate) const TRUE: &str = "+0";

/// The clock of the processes that have its environment.
#[derive(Debug)]
pub(crate) struct Clock {
    library: &'static Path,
    file: PathBuf,
}

impl Clock {
    /// A clock that says the true time and is kept in a folder; `None` where the library is not
    /// there.
    pub(crate) fn new(folder: &Path) -> Result<Option<Self>> {
        let mut libraries = LIBRARIES.iter().map(Path::new);
        let Some(library) = libraries.find(|path| path.is_file()) else {
            return Ok(None);
        };
        let file = folder.join("clock");
        let clock = Self { library, file };
        clock.step(TRUE)?;
        Ok(Some(clock))
    }

    /// Steps it to this far from the true time, such as `+1h`.
    pub(crate) fn step(&self, to: &str) -> Result<()> {
        // Whole or not at all: processes read it at any time.
        let next = self.file.with_extension("next");
        std::fs::write(&next, format!("{to}\n"))?;
        Ok(std::fs::rename(next, &self.file)?)
    }

    pub(crate) fn environment(&self) -> Vec<(String, String)> {
        let variables = [
            ("LD_PRELOAD", self.library.display().to_string()),
            ("FAKETIME_TIMESTAMP_FILE", self.file.display().to_string()),
            ("FAKETIME_NO_CACHE", "1".to_owned()),
            ("FAKETIME_DONT_FAKE_MONOTONIC", "1".to_owned()),
        ];
        let variables = variables.into_iter();
        variables
            .map(|(name, value)| (name.to_owned(), value))
            .collect()
    }
}

impl Drop for Clock {
    /// A process that was killed leaves its files behind.
    fn drop(&mut self) {
        let Ok(entries) = std::fs::read_dir(SHARED) else {
            return;
        };
        let paths = entries.flatten().map(|entry| entry.path());
        for path in paths.filter(|path| path.file_name().is_some_and(is_left)) {
            drop(std::fs::remove_file(path));
        }
    }
}

/// Whether this is a file that the library made for a process that is no more.
fn is_left(name: &OsStr) -> bool {
    let name = name.to_string_lossy();
    let id = ["faketime_shm_", "sem.faketime_sem_"]
        .iter()
        .find_map(|prefix| name.strip_prefix(prefix));
    let is_number = |id: &&str| id.bytes().all(|byte| byte.is_ascii_digit());
    id.filter(is_number)
        .is_some_and(|id| !Path::new("/proc").join(id).exists())
}
