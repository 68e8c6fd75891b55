//! The files of a session store.

use std::path::{Path, PathBuf};
use std::{fs, io};

use ppnpack_service::database::DatabaseFile;
use ppnpack_wire::keys::Cell;

use super::database::Fault;

/// The extension of a cell's file.
const EXTENSION: &str = "redb";

/// Gives the file of a cell, in a folder beside the store's own file.
pub(super) fn of_cell(store: &Path, cell: &Cell) -> PathBuf {
    folder(store).join(format!("{cell}.{EXTENSION}"))
}

/// Finds the cells that have files.
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
pub(super) fn open(path: Option<&Path>) -> Result<DatabaseFile, Fault> {
    match path {
        Some(path) => ppnpack_service::database::open(path),
        None => ppnpack_service::database::in_memory(),
    }
}

/// Gives a damaged file another name.
pub(super) fn put_aside(path: &Path, fault: &Fault) -> Result<(), Fault> {
    let aside = ppnpack_service::database::put_aside(path)?;
    tracing::error!(
        store = %path.display(),
        kept_as = %aside.display(),
        %fault,
        "a file of the session store is damaged: it was put aside and a new one begun; the session in it is lost, begin a new one"
    );
    Ok(())
}
