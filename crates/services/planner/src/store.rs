//! Packing sessions on disk.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::{MAX_MESSAGE_BYTES, v1};
use prost::Message;
use redb::backends::InMemoryBackend;
use redb::{
    Database, DatabaseError, ReadableDatabase, ReadableTable, StorageError, TableDefinition,
};

use ppnpack_protocol::session::{FROM_BACKUP, Session};

/// Per cell: its session.
const SESSIONS: TableDefinition<&str, &[u8]> = TableDefinition::new("sessions");

/// Per cell and id: heightmaps of items that were announced with them.
const SHAPES: TableDefinition<(&str, &[u8]), &[u8]> = TableDefinition::new("shapes");

/// Under [`VERSION_KEY`]: the version of all that is in the file, where it is one after the first.
const FORMAT: TableDefinition<&str, u64> = TableDefinition::new("format");

/// The only key of [`FORMAT`].
const VERSION_KEY: &str = "version";

/// The newest version that this program knows.
const VERSION: u64 = 1;

type Shapes<'a> = redb::Table<'a, (&'static str, &'static [u8]), &'static [u8]>;

/// Why the store did not do what was asked.
#[derive(Debug, thiserror::Error)]
pub(crate) enum StoreError {
    /// It cannot be opened.
    #[error("the session store {path} cannot be opened: {reason}")]
    Open { path: PathBuf, reason: String },
    /// It cannot be read or written.
    #[error("the session store cannot be used: {0}")]
    Disk(String),
    /// It is of a newer program, which alone knows what it says.
    #[error(
        "the session store was written by a newer version of this program (format {0}, where up to {VERSION} are known): run that \
         version, or put back a backup of this one's"
    )]
    Newer(u64),
    /// What it holds is no session.
    #[error("the session store holds something unreadable for cell {cell}: {reason}")]
    Content { cell: String, reason: String },
}

/// Keeps the sessions of all cells of this planner. What was saved is on disk when the call returns.
pub(crate) struct Store {
    file: Option<PathBuf>,
    /// `None` after an error of the disk, until it can be opened again.
    database: Mutex<Option<Database>>,
}

impl Store {
    /// Opens the store of a file, or one in memory. A file that is damaged is put aside under a new name: with the
    /// sessions lost, the next thing that a caller asks is answered with "no session", and nothing is packed twice.
    pub(crate) fn open(file: Option<&Path>) -> Result<Self, StoreError> {
        let database = match file {
            None => Database::builder()
                .create_with_backend(InMemoryBackend::new())
                .map_err(|error| StoreError::Disk(error.to_string()))?,
            Some(path) => open_or_put_aside(path)?,
        };
        check_version(&database)?;
        Ok(Self {
            file: file.map(Path::to_owned),
            database: Mutex::new(Some(database)),
        })
    }

    /// The session of a cell; that of a cell before its first one where there is none.
    pub(crate) fn session(&self, cell: &Cell) -> Result<Session, StoreError> {
        let Some(bytes) = self.read(SESSIONS, cell.as_str())? else {
            return Ok(Session::default());
        };
        let content = |reason: String| StoreError::Content {
            cell: cell.to_string(),
            reason,
        };
        let message: v1::Session = ppnpack_wire::decode(&bytes, MAX_MESSAGE_BYTES)
            .map_err(|error| content(error.to_string()))?;
        Session::from_message(message).map_err(|error| content(error.to_string()))
    }

    /// The heightmaps of an item of a cell's session that was announced with them.
    pub(crate) fn shape(&self, cell: &Cell, id: ItemId) -> Result<Option<v1::Item>, StoreError> {
        let id = id.to_bytes();
        let bytes = self.read(SHAPES, (cell.as_str(), id.as_slice()))?;
        Ok(bytes.and_then(|bytes| ppnpack_wire::decode(&bytes, MAX_MESSAGE_BYTES).ok()))
    }

    /// Saves the session of a cell, and the heightmaps of items that it newly refers to.
    pub(crate) fn save(
        &self,
        cell: &Cell,
        session: &Session,
        shapes: &[v1::Item],
    ) -> Result<(), StoreError> {
        self.write(cell, session, |table| {
            for shape in shapes {
                let id = ItemId::of(shape).to_bytes();
                let key = (cell.as_str(), id.as_slice());
                table.insert(key, shape.encode_to_vec().as_slice())?;
            }
            Ok(())
        })
    }

    /// Saves a new session of a cell and forgets the heightmaps of the one before.
    pub(crate) fn begin(&self, cell: &Cell, session: &Session) -> Result<(), StoreError> {
        self.write(cell, session, |table| {
            table.retain(|(of, _), _| of != cell.as_str())?;
            Ok(())
        })
    }

    /// Ends the sessions of a store that is a backup, as it is not known what was packed since. Gives their cells.
    ///
    /// # Errors
    /// [`StoreError`] where there is no such file, or it cannot be read or written.
    pub(crate) fn after_restore(path: &Path) -> Result<Vec<String>, StoreError> {
        if !path.is_file() {
            return Err(StoreError::Open {
                path: path.to_owned(),
                reason: "there is no such file".to_owned(),
            });
        }
        let store = Self::open(Some(path))?;
        let cells = store.cells()?;
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

    /// The cells that have sessions.
    fn cells(&self) -> Result<Vec<Cell>, StoreError> {
        self.with(|database| {
            let table = match database.begin_read()?.open_table(SESSIONS) {
                Err(redb::TableError::TableDoesNotExist(_)) => return Ok(Vec::new()),
                table => table?,
            };
            let mut cells = Vec::new();
            for entry in table.iter()? {
                cells.extend(Cell::new(entry?.0.value()).ok());
            }
            Ok(cells)
        })
    }

    /// The value of a key; `None` where nothing was written to its table yet.
    fn read<K: redb::Key + 'static>(
        &self,
        table: TableDefinition<'static, K, &'static [u8]>,
        key: K::SelfType<'_>,
    ) -> Result<Option<Vec<u8>>, StoreError> {
        self.with(|database| {
            let table = match database.begin_read()?.open_table(table) {
                Err(redb::TableError::TableDoesNotExist(_)) => return Ok(None),
                table => table?,
            };
            let found = table.get(key)?;
            Ok(found.map(|value| value.value().to_vec()))
        })
    }

    fn write(
        &self,
        cell: &Cell,
        session: &Session,
        change: impl FnOnce(&mut Shapes<'_>) -> Result<(), redb::Error>,
    ) -> Result<(), StoreError> {
        let bytes = session.to_message(0).encode_to_vec();
        self.with(|database| {
            let transaction = database.begin_write()?;
            {
                let mut sessions = transaction.open_table(SESSIONS)?;
                sessions.insert(cell.as_str(), bytes.as_slice())?;
                change(&mut transaction.open_table(SHAPES)?)?;
            }
            transaction.commit()?;
            Ok(())
        })
    }

    /// Works with the database; after an error it is opened anew the next time, so that a disk that recovered serves
    /// again.
    fn with<T>(
        &self,
        work: impl FnOnce(&Database) -> Result<T, redb::Error>,
    ) -> Result<T, StoreError> {
        // The guarded value is whole at any time: a panic elsewhere does not make it unusable.
        let mut database = self.database.lock().unwrap_or_else(PoisonError::into_inner);
        let open = match database.take() {
            Some(open) => open,
            None => self.reopen()?,
        };
        match work(&open) {
            Ok(done) => {
                *database = Some(open);
                Ok(done)
            }
            Err(error) => {
                if self.file.is_none() {
                    *database = Some(open);
                }
                Err(StoreError::Disk(error.to_string()))
            }
        }
    }

    fn reopen(&self) -> Result<Database, StoreError> {
        match &self.file {
            Some(path) => Database::create(path).map_err(|error| StoreError::Open {
                path: path.clone(),
                reason: error.to_string(),
            }),
            None => Err(StoreError::Disk("the store in memory is gone".to_owned())),
        }
    }
}

/// Whether this program knows what the store says.
fn check_version(database: &Database) -> Result<(), StoreError> {
    let read = || -> Result<Option<u64>, redb::Error> {
        let table = match database.begin_read()?.open_table(FORMAT) {
            Err(redb::TableError::TableDoesNotExist(_)) => return Ok(None),
            table => table?,
        };
        Ok(table.get(VERSION_KEY)?.map(|found| found.value()))
    };
    match read().map_err(|error| StoreError::Disk(error.to_string()))? {
        Some(version) if version > VERSION => Err(StoreError::Newer(version)),
        _ => Ok(()),
    }
}

fn open_or_put_aside(path: &Path) -> Result<Database, StoreError> {
    let failed = |reason: String| StoreError::Open {
        path: path.to_owned(),
        reason,
    };
    let error = match Database::create(path) {
        Ok(database) => return Ok(database),
        Err(error) => error,
    };
    if !is_damage(&error) {
        return Err(failed(error.to_string()));
    }
    let aside = path.with_extension(format!("damaged-{:08x}", rand::random::<u32>()));
    std::fs::rename(path, &aside).map_err(|error| failed(error.to_string()))?;
    tracing::error!(
        store = %path.display(),
        kept_as = %aside.display(),
        %error,
        "the session store is damaged: its sessions are lost, begin new ones"
    );
    Database::create(path).map_err(|error| failed(error.to_string()))
}

fn is_damage(error: &DatabaseError) -> bool {
    match error {
        DatabaseError::Storage(StorageError::Corrupted(_)) | DatabaseError::RepairAborted => true,
        // A file with other content is told as an input error.
        DatabaseError::Storage(StorageError::Io(error)) => {
            let kind = error.kind();
            matches!(kind, ErrorKind::InvalidData | ErrorKind::UnexpectedEof)
        }
        _ => false,
    }
}
