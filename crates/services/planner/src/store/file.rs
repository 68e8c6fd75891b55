//! The files of a session store.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};
use std::{fs, io};

use ppnpack_wire::keys::Cell;
use redb::backends::InMemoryBackend;
use redb::{Builder, Database};

use super::database::{self, Fault};
use super::mark::{self, Mark};

/// Memory for pages of each database.
const CACHE_BYTES: usize = 16 << 20;

/// How the file of a cell ends.
const EXTENSION: &str = "redb";

/// The file of a cell, in a folder beside the store's own file.
pub(super) fn of_cell(store: &Path, cell: &Cell) -> PathBuf {
    folder(store).join(format!("{cell}.{EXTENSION}"))
}

/// The cells that have files.
pub(super) fn cells(store: &Path) -> io::Result<Vec<Cell>> {
    let folder = folder(store);
    if !folder.exists() {
        return Ok(Vec::new());
    }
    let mut cells = Vec::new();
    for entry in fs::read_dir(folder)? {
        let name = entry?.file_name();
        let name = name.to_string_lossy();
        let cell = name
            .strip_suffix(EXTENSION)
            .and_then(|name| name.strip_suffix('.'));
        cells.extend(cell.and_then(|cell| Cell::new(cell).ok()));
    }
    cells.sort();
    Ok(cells)
}

fn folder(store: &Path) -> PathBuf {
    store.with_extension("cells")
}

/// Opens a file, and begins it where there is none; without one, a database in memory.
pub(super) fn open(path: Option<&Path>) -> Result<Database, Fault> {
    let mut builder = Builder::new();
    builder.set_cache_size(CACHE_BYTES);
    let Some(path) = path else {
        return Ok(builder.create_with_backend(InMemoryBackend::new())?);
    };
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    // What another program, or the disk, changed in the file is found here, and not taken for what was written.
    builder.set_check_integrity_on_open(true);
    let opened = catch_unwind(AssertUnwindSafe(|| builder.create(path)));
    Ok(opened.map_err(|_| Fault::Panic)??)
}

/// The database of a cell, with its mark.
pub(super) struct CellFile {
    pub(super) database: Database,
    /// `None` in memory.
    mark: Option<Mark>,
}

impl CellFile {
    /// Opens the file of a cell as [`open`] does.
    pub(super) fn open(path: Option<&Path>) -> Result<Self, Fault> {
        let database = open(path)?;
        let Some(path) = path else {
            return Ok(Self {
                database,
                mark: None,
            });
        };
        let mut mark = Mark::open(path)?;
        let (found, written) = (database::revision(&database)?, mark.read()?);
        if found < written {
            return Err(Fault::RolledBack { found, written });
        }
        Ok(Self {
            database,
            mark: Some(mark),
        })
    }

    /// Notes that this revision is on disk.
    pub(super) fn wrote(&mut self, revision: u64) {
        if let Some(mark) = &mut self.mark {
            mark.write(revision);
        }
    }
}

/// Gives a damaged file another name.
pub(super) fn put_aside(path: &Path, fault: &Fault) -> Result<(), Fault> {
    let aside = free_name(path);
    fs::rename(path, &aside)?;
    mark::remove(path)?;
    tracing::error!(
        store = %path.display(),
        kept_as = %aside.display(),
        %fault,
        "a file of the session store is damaged: it was put aside and a new one begun; the session in it is lost, begin a new one"
    );
    Ok(())
}

fn free_name(path: &Path) -> PathBuf {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH);
    let millis = since_1970.map_or(0, |since_1970| since_1970.as_millis());
    let name = |count: u32| {
        let mut name = path.as_os_str().to_owned();
        name.push(format!(".damaged-{millis}-{count}"));
        PathBuf::from(name)
    };
    let free = (0..1000).map(name).find(|name| !name.exists());
    free.unwrap_or_else(|| name(1000))
}
