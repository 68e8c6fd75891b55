//! Packing sessions on disk.
//!
//! What was saved is on disk when the call returns. Each cell has a file of its own, so that the
//! damage of one is not another's. A file that is damaged is put aside under a new name, for people
//! to look at, and a new one begun: with its session lost, the next thing that a caller asks is
//! answered with "no session", and nothing is packed twice. So is one that is behind its mark: what
//! was written last is damaged, or somebody put back an older copy. And so is the file of another
//! cell.
//!
//! The file that the settings name says which version wrote the others.

mod database;
mod file;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use ppnpack_protocol::session::{FROM_BACKUP, Session};
use ppnpack_service::database::{DatabaseFile, Kept, forget_mark};
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::{MAX_MESSAGE_BYTES, v1};
use prost::Message;
use redb::Database;

use self::database::{Change, Fault, StoreFault};

/// Why the store did not do what was asked.
#[derive(Debug, thiserror::Error)]
pub(crate) enum StoreError {
    /// It cannot be opened.
    #[error("the session store {path} cannot be opened: {reason}")]
    Open { path: PathBuf, reason: String },
    /// It cannot be read or written.
    #[error("the session store cannot be used: {0}")]
    Unusable(String),
    /// The heightmaps of a session would take too much.
    #[error(
        "the heightmaps that items of this session were announced with would take {bytes} bytes where {most} are possible: announce \
         objects by name, begin a new session, or set shapes_mib"
    )]
    TooManyShapes { bytes: u64, most: u64 },
}

impl From<Fault> for StoreError {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::Own(StoreFault::TooManyShapes { bytes, most }) => {
                Self::TooManyShapes { bytes, most }
            }
            fault => Self::Unusable(fault.to_string()),
        }
    }
}

/// Keeps the sessions of all cells of this planner.
pub(crate) struct Store {
    /// The store's own file; `None` where it is in memory.
    path: Option<PathBuf>,
    /// Says the version; open as long as the store, to keep other processes out. `None` in memory.
    _root: Option<Kept<DatabaseFile>>,
    /// The files that were needed so far.
    cells: Mutex<BTreeMap<Cell, Kept<DatabaseFile>>>,
    /// Maximum bytes of heightmaps in a session, as they are encoded.
    most_shape_bytes: u64,
}

impl Store {
    /// Opens the store of a file, or one in memory. `most_shape_bytes` is the most that the
    /// heightmaps of a session's items may take.
    ///
    /// # Errors
    /// [`StoreError`] where it cannot be read or written, or is of another version.
    pub(crate) fn open(path: Option<&Path>, most_shape_bytes: u64) -> Result<Self, StoreError> {
        let failed = |path: &Path, fault: &Fault| StoreError::Open {
            path: path.to_owned(),
            reason: fault.to_string(),
        };
        let root = path.map(|path| open_root(path).map_err(|fault| failed(path, &fault)));
        Ok(Self {
            path: path.map(Path::to_owned),
            _root: root.transpose()?,
            cells: Mutex::default(),
            most_shape_bytes,
        })
    }

    /// Reads the session of a cell; that before the first one where none is there or readable.
    ///
    /// # Errors
    /// [`StoreError`] where the disk does not serve, or the file is of another version.
    pub(crate) fn session(&self, cell: &Cell) -> Result<Session, StoreError> {
        let session = self.with(cell, |database| database::session(database, cell))?;
        Ok(session.unwrap_or_default())
    }

    /// Reads the heightmaps that an item of a cell's session was announced with; `None` where they
    /// are not there, or others than were written.
    ///
    /// # Errors
    /// [`StoreError`] where they cannot be read.
    pub(crate) fn shape(&self, cell: &Cell, id: ItemId) -> Result<Option<v1::Item>, StoreError> {
        let bytes = self.with(cell, |database| database::shape(database, cell, id))?;
        let read = |bytes: Vec<u8>| ppnpack_wire::decode::<v1::Item>(&bytes, MAX_MESSAGE_BYTES);
        let shape = bytes.and_then(|bytes| read(bytes).ok());
        Ok(shape.filter(|shape| ItemId::of(shape) == id))
    }

    /// Saves the session of a cell, and the heightmaps of items that it newly refers to.
    ///
    /// # Errors
    /// [`StoreError`] where it cannot be written, or has too many heightmaps; nothing is saved then.
    pub(crate) fn save(
        &self,
        cell: &Cell,
        session: &Session,
        shapes: &[v1::Item],
    ) -> Result<(), StoreError> {
        let items = session.items().iter();
        // Nothing is forgotten where nothing is added.
        let used = match shapes {
            [] => BTreeSet::new(),
            _ => items.map(|item| item.shape.clone()).collect(),
        };
        let change = Change::Add {
            shapes,
            used,
            most_bytes: self.most_shape_bytes,
        };
        self.write(cell, session, &change)
    }

    /// Saves a new session of a cell and forgets the heightmaps of the one before.
    ///
    /// # Errors
    /// [`StoreError`] where it cannot be written.
    pub(crate) fn begin(&self, cell: &Cell, session: &Session) -> Result<(), StoreError> {
        self.write(cell, session, &Change::Forget)
    }

    /// Ends the sessions of a store that is a backup, as it is not known what was packed since.
    /// Gives their cells.
    ///
    /// # Errors
    /// [`StoreError`] where there is no such file, or it cannot be read or written.
    pub(crate) fn after_restore(path: &Path) -> Result<Vec<String>, StoreError> {
        let failed = |reason: String| StoreError::Open {
            path: path.to_owned(),
            reason,
        };
        if !path.is_file() {
            return Err(failed("there is no such file".to_owned()));
        }
        let cells = file::cells(path).map_err(|error| failed(error.to_string()))?;
        for cell in &cells {
            forget_mark(&file::of_cell(path, cell)).map_err(|error| failed(error.to_string()))?;
        }
        // No heightmaps are added.
        let store = Self::open(Some(path), 0)?;
        for cell in &cells {
            store.settle(cell, FROM_BACKUP)?;
        }
        Ok(cells.iter().map(ToString::to_string).collect())
    }

    /// Settles the session of a cell of which not all is known any more, for this reason.
    ///
    /// # Errors
    /// [`StoreError`] where it cannot be read or written.
    pub(crate) fn settle(&self, cell: &Cell, reason: &str) -> Result<(), StoreError> {
        let mut session = self.session(cell)?;
        session.restored(reason);
        self.save(cell, &session, &[])
    }

    fn write(&self, cell: &Cell, session: &Session, change: &Change<'_>) -> Result<(), StoreError> {
        let bytes = session.to_message(0).encode_to_vec();
        self.with_file(cell, |file| database::write(file, cell, &bytes, change))
    }

    /// Works with the database of a cell. A damaged one is put aside, and a new one used.
    fn with<T>(
        &self,
        cell: &Cell,
        work: impl Fn(&Database) -> Result<T, Fault>,
    ) -> Result<T, StoreError> {
        self.with_file(cell, |file| work(file))
    }

    fn with_file<T>(
        &self,
        cell: &Cell,
        mut work: impl FnMut(&mut DatabaseFile) -> Result<T, Fault>,
    ) -> Result<T, StoreError> {
        let path = self.file_of(cell);
        // An error leaves no database, and a panic is caught: the guarded value is always whole.
        let mut cells = self.cells.lock().unwrap_or_else(PoisonError::into_inner);
        let file = cells.entry(cell.clone()).or_default();
        let done = file.with(
            || file::open(path.as_deref()),
            |fault| match &path {
                Some(path) => file::put_aside(path, fault),
                // In memory there is nothing to be put aside.
                None => Err(Fault::Panic),
            },
            |file, _| work(file),
        );
        Ok(done?)
    }

    fn file_of(&self, cell: &Cell) -> Option<PathBuf> {
        let path = self.path.as_deref()?;
        Some(file::of_cell(path, cell))
    }
}

/// Opens the file that says the version, and begins it where there is none.
fn open_root(path: &Path) -> Result<Kept<DatabaseFile>, Fault> {
    let mut root = Kept::default();
    root.with(
        || file::open(Some(path)),
        |fault| file::put_aside(path, fault),
        |root, _| database::begin_version(root),
    )?;
    Ok(root)
}

#[cfg(test)]
mod tests;
