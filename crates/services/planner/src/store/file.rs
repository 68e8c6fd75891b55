//! The files of a session store.

use std::path::{Path, PathBuf};
use std::{fs, io};

use ppnpack_wire::keys::Cell;
use redb::Database;

use super::database::{self, Fault, StoreFault};
use super::mark::{self, Mark};

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
    match path {
        Some(path) => ppnpack_service::database::open(path),
        None => ppnpack_service::database::in_memory(),
    }
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
            return Err(StoreFault::RolledBack { found, written }.into());
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
    let aside = ppnpack_service::database::put_aside(path)?;
    mark::remove(path)?;
    tracing::error!(
        store = %path.display(),
        kept_as = %aside.display(),
        %fault,
        "a file of the session store is damaged: it was put aside and a new one begun; the session in it is lost, begin a new one"
    );
    Ok(())
}
