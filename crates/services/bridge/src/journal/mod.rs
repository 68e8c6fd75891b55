//! The ledgers of all cells of a process on disk.
//!
//! A write is on disk when the call returns. After an error nothing is taken for granted: the next
//! write opens the file anew, and every cell then writes its whole ledger. So the disk has all that
//! the process knows, whatever became of the write that failed.
//!
//! A damaged file is put aside under a new name, for people to look at, and a new one begun; so is
//! an older copy that somebody put back. The record of executed placements goes with it. So that
//! none is executed again, a cell without a ledger begins at a state number that no placement was
//! planned on (see [`ledger`](ppnpack_protocol::ledger)). The container of a simulated cell is
//! empty then; a real one has to be seen again. Commits have two phases: otherwise damage could be
//! taken for a crash, after which the commit before the last counts.
//!
//! A file that was moved, deleted or replaced while it is open is not written to: a restart would
//! not find the requests that were acknowledged.

mod database;

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use ppnpack_service::database::{DatabaseFile, Kept, forget_mark, open};
use ppnpack_service::sync::lock;
use ppnpack_service::{Health, HealthLatch};
use ppnpack_wire::keys::Cell;

use self::database::Fault;
use ppnpack_protocol::ledger::{Change, FROM_BACKUP, Ledger};

/// Opens the database: the file, or a test's own storage.
type Open = Box<dyn Fn() -> Result<DatabaseFile, Fault> + Send + Sync>;

/// An error of writing or reading the journal.
#[derive(Debug, Clone, thiserror::Error)]
#[error("the journal {} cannot be used: {reason}; it needs a disk with space that can be written to, and no other process that uses it", path.display())]
pub(crate) struct JournalError {
    path: PathBuf,
    reason: String,
    /// Whether the path does not lead to the journal any more.
    is_moved: bool,
}

impl JournalError {
    /// Says what to do where the path does not lead to the journal any more.
    pub(crate) fn moved(&self) -> Option<&str> {
        self.is_moved.then_some(self.reason.as_str())
    }
}

/// The journal of a process.
pub(crate) struct Journal {
    path: PathBuf,
    open: Open,
    health: HealthLatch,
    database: Mutex<Kept<DatabaseFile>>,
}

/// The part of a journal that is one cell's. Without a journal all is forgotten with the process.
pub(crate) struct CellJournal {
    journal: Option<Arc<Journal>>,
    cell: Cell,
    /// The generation of the database that has this cell's ledger.
    generation: u64,
}

impl Journal {
    /// The journal in a file, opened when it is first needed. The health check says whether it can
    /// be written.
    pub(crate) fn new(path: &Path, health: HealthLatch) -> Self {
        let file = path.to_owned();
        Self::with_open(path, health, Box::new(move || open(&file)))
    }

    fn with_open(path: &Path, health: HealthLatch, open: Open) -> Self {
        Self {
            path: path.to_owned(),
            open,
            health,
            database: Mutex::default(),
        }
    }

    /// Works on the database, as [`Kept::with`] does.
    fn with<T>(
        &self,
        work: impl FnMut(&mut DatabaseFile, u64) -> Result<T, Fault>,
    ) -> Result<T, JournalError> {
        // An error leaves no database, and a panic is caught: it is whole at any time.
        let mut database = lock(&self.database);
        let result = database.with(&self.open, |fault| put_aside(&self.path, fault), work);
        match result {
            Ok(done) => {
                self.health.pass();
                Ok(done)
            }
            Err(fault) => {
                let error = JournalError {
                    path: self.path.clone(),
                    reason: fault.to_string(),
                    is_moved: matches!(fault, Fault::Moved(_)),
                };
                self.health.fail(error.to_string());
                Err(error)
            }
        }
    }
}

impl CellJournal {
    pub(crate) fn new(journal: Option<Arc<Journal>>, cell: Cell) -> Self {
        Self {
            journal,
            cell,
            generation: 0,
        }
    }

    /// Reads the ledger of the cell; gives a new one where there is none.
    pub(crate) fn load(&mut self) -> Result<Ledger, JournalError> {
        let Some(journal) = &self.journal else {
            return Ok(Ledger::without_past());
        };
        let (known, generation) = journal.with(|database, generation| {
            let known = database::load(database, self.cell.as_str())?;
            Ok((known, generation))
        })?;
        self.generation = generation;
        Ok(known.unwrap_or_else(|| {
            tracing::info!(cell = %self.cell, "the journal knows nothing of the cell: it begins empty");
            Ledger::without_past()
        }))
    }

    /// Writes down a change of a ledger that is about to be made.
    pub(crate) fn write(&mut self, ledger: &Ledger, change: &Change) -> Result<(), JournalError> {
        let Some(journal) = &self.journal else {
            return Ok(());
        };
        let cell = self.cell.as_str();
        self.generation = journal.with(|database, generation| {
            let whole = (generation != self.generation).then_some(ledger);
            database::write(database, cell, whole, change)?;
            Ok(generation)
        })?;
        Ok(())
    }
}

/// Gives a damaged journal another name.
fn put_aside(path: &Path, fault: &Fault) -> Result<(), Fault> {
    let aside = ppnpack_service::database::put_aside(path)?;
    tracing::error!(
        journal = %path.display(),
        kept_as = %aside.display(),
        %fault,
        "the journal is damaged: it was put aside and a new one begun; cells that it is needed for begin empty, and \
         what was planned for them is stale"
    );
    Ok(())
}

/// Settles the ledgers of a restored backup, as later work is not known. Gives the cells, which are
/// held.
///
/// # Errors
/// [`JournalError`] where there is no such file, or it cannot be read or written.
pub(crate) fn after_restore(path: &Path) -> Result<Vec<String>, JournalError> {
    let unusable = |reason: &str| JournalError {
        path: path.to_owned(),
        reason: reason.to_owned(),
        is_moved: false,
    };
    if !path.is_file() {
        return Err(unusable("there is no such file"));
    }
    forget_mark(path).map_err(|error| unusable(&error.to_string()))?;
    let journal = Journal::new(path, Health::default().check("journal"));
    let cells = journal.with(|database, _| {
        let cells = database::cells(database)?;
        for cell in &cells {
            if let Some(ledger) = database::load(database, cell)? {
                database::write(database, cell, None, &ledger.restored(FROM_BACKUP))?;
            }
        }
        Ok(cells)
    })?;
    match cells.is_empty() {
        true => Err(unusable("it has no cell, or was damaged and put aside")),
        false => Ok(cells),
    }
}

#[cfg(test)]
mod tests;
