//! Databases of services, each a file of its own: damage is found, and never taken for content.
//!
//! A service has faults of its own beside those of any database, as where a value cannot be read.
//! It says of them whether the file is damaged ([`OwnFault`]), and puts a damaged one aside
//! ([`put_aside`]), for people to look at.

mod file;
mod mark;

use std::fs;
use std::io::{self, ErrorKind};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use redb::{Builder, Key, ReadTransaction, TableDefinition, TableError, Value};

pub use file::{DatabaseFile, in_memory, open};
pub use mark::remove as forget_mark;

use crate::clock::now_ns;

/// The table of numbers about a file itself.
pub const FORMAT: TableDefinition<'_, &str, u64> = TableDefinition::new("format");

/// The key of the version in [`FORMAT`].
pub const VERSION_KEY: &str = "version";

/// The key of the number of writes in [`FORMAT`].
const REVISION_KEY: &str = "revision";

/// Maximum memory for pages of a database.
const CACHE_BYTES: usize = 16 << 20;

/// The reason for which a database failed.
#[derive(Debug, thiserror::Error)]
pub enum Fault<Own: OwnFault> {
    /// The database failed.
    #[error(transparent)]
    Database(redb::Error),
    /// The disk failed.
    #[error(transparent)]
    Disk(#[from] io::Error),
    /// Another version of the program wrote the file, and alone can read it.
    #[error(
        "it was written by another version of this program (format {found}, where {known} is \
         read): run that version, put back a backup of this one's, or move the file away"
    )]
    OtherVersion {
        /// The version of the file.
        found: u64,
        /// The version of this program.
        known: u64,
    },
    /// The file is older than the last one that was written.
    #[error("it holds revision {found}, and revision {written} was written")]
    RolledBack {
        /// The revision of the file.
        found: u64,
        /// The revision of its mark.
        written: u64,
    },
    /// The path leads to another file than the one that is open, or to none.
    #[error(
        "{} was moved, deleted or replaced while it was open: put that file back; where it is \
         lost, look what the cell holds, and restart this service", .0.display()
    )]
    Moved(PathBuf),
    /// The database panicked.
    #[error("the database gave up on its file")]
    Panic,
    /// The service has a fault of its own.
    #[error(transparent)]
    Own(Own),
}

/// A fault of a service's own with its file.
pub trait OwnFault: std::error::Error + 'static {
    /// Says whether the file is of no use any more.
    fn is_damage(&self) -> bool;
}

impl<Own: OwnFault> From<Own> for Fault<Own> {
    fn from(own: Own) -> Self {
        Self::Own(own)
    }
}

/// Makes faults of the errors of the database's calls.
macro_rules! faults {
    ($($error:ident)*) => {
        $(impl<Own: OwnFault> From<redb::$error> for Fault<Own> {
            fn from(error: redb::$error) -> Self {
                Self::Database(error.into())
            }
        })*
    };
}

faults! { CommitError DatabaseError StorageError TableError TransactionError }

impl<Own: OwnFault> Fault<Own> {
    /// Says whether the file is of no use any more. Everything else may pass.
    pub fn is_damage(&self) -> bool {
        match self {
            Self::Database(redb::Error::Corrupted(_) | redb::Error::RepairAborted)
            | Self::RolledBack { .. }
            | Self::Panic => true,
            // A file that was cut off, or is no database at all.
            Self::Database(redb::Error::Io(error)) => {
                let kind = error.kind();
                matches!(kind, ErrorKind::InvalidData | ErrorKind::UnexpectedEof)
            }
            // The file of another version is left as it is.
            Self::Database(_) | Self::Disk(_) | Self::OtherVersion { .. } | Self::Moved(_) => false,
            Self::Own(own) => own.is_damage(),
        }
    }
}

fn builder() -> Builder {
    let mut builder = Builder::new();
    builder.set_cache_size(CACHE_BYTES);
    builder
}

/// Works with a database, which may panic on a file that something else wrote to.
///
/// # Errors
/// That of the work; [`Fault::Panic`] where it panics.
pub fn guarded<T, Own: OwnFault>(
    work: impl FnOnce() -> Result<T, Fault<Own>>,
) -> Result<T, Fault<Own>> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or(Err(Fault::Panic))
}

/// A database that is opened when it is needed, and again after an error, so that a disk that
/// recovered serves again.
#[derive(Debug)]
pub struct Kept<Opened> {
    opened: Option<Opened>,
    /// The number of times that it was opened.
    generation: u64,
}

impl<Opened> Default for Kept<Opened> {
    fn default() -> Self {
        Self {
            opened: None,
            generation: 0,
        }
    }
}

impl<Opened> Kept<Opened> {
    /// Works with the database, and the number of times that it was opened. A damaged one is put
    /// aside, and the work done with a new one.
    ///
    /// # Errors
    /// That of opening, of putting aside or of the work.
    pub fn with<T, Own: OwnFault>(
        &mut self,
        open: impl Fn() -> Result<Opened, Fault<Own>>,
        put_aside: impl FnOnce(&Fault<Own>) -> Result<(), Fault<Own>>,
        mut work: impl FnMut(&mut Opened, u64) -> Result<T, Fault<Own>>,
    ) -> Result<T, Fault<Own>> {
        match self.attempt(&open, &mut work) {
            Err(fault) if fault.is_damage() => {
                put_aside(&fault)?;
                self.attempt(&open, &mut work)
            }
            result => result,
        }
    }

    fn attempt<T, Own: OwnFault>(
        &mut self,
        open: &impl Fn() -> Result<Opened, Fault<Own>>,
        work: &mut impl FnMut(&mut Opened, u64) -> Result<T, Fault<Own>>,
    ) -> Result<T, Fault<Own>> {
        let mut opened = match self.opened.take() {
            Some(opened) => opened,
            None => {
                let opened = open()?;
                self.generation += 1;
                opened
            }
        };
        let generation = self.generation;
        let result = guarded(|| work(&mut opened, generation));
        // After a refusal of the service's own the file is as good as before. One that was moved
        // may be put back.
        let is_good = match &result {
            Ok(_) | Err(Fault::Moved(_)) => true,
            Err(Fault::Own(own)) => !own.is_damage(),
            Err(_) => false,
        };
        self.opened = is_good.then_some(opened);
        result
    }

    /// Closes it until it is needed again.
    pub fn close(&mut self) {
        self.opened = None;
    }
}

/// Gives a damaged file another name, which is returned. Its mark is forgotten.
///
/// # Errors
/// Those of the system.
pub fn put_aside(path: &Path) -> io::Result<PathBuf> {
    let millis = now_ns() / 1_000_000;
    let name = |count: u32| {
        let mut name = path.as_os_str().to_owned();
        name.push(format!(".damaged-{millis}-{count}"));
        PathBuf::from(name)
    };
    let free = (0..1000).map(name).find(|name| !name.exists());
    let aside = free.unwrap_or_else(|| name(1000));
    fs::rename(path, &aside)?;
    forget_mark(path)?;
    Ok(aside)
}

/// Checks that a file is of this version, or new; says whether it is new.
///
/// # Errors
/// [`Fault::OtherVersion`] where another one wrote it.
pub fn is_new<Own: OwnFault>(
    transaction: &ReadTransaction,
    known: u64,
) -> Result<bool, Fault<Own>> {
    let found = match read(transaction, FORMAT, VERSION_KEY, |found| found)? {
        Some(found) => found,
        None if transaction.list_tables()?.next().is_none() => return Ok(true),
        // The first did not say so.
        None => 1,
    };
    match found == known {
        true => Ok(false),
        false => Err(Fault::OtherVersion { found, known }),
    }
}

/// Reads the value of a key from a table; `None` where nothing was written to it yet.
///
/// # Errors
/// [`Fault`]
pub fn read<K: Key + 'static, V: Value + 'static, T, Own: OwnFault>(
    transaction: &ReadTransaction,
    table: TableDefinition<'_, K, V>,
    key: K::SelfType<'_>,
    take: impl FnOnce(V::SelfType<'_>) -> T,
) -> Result<Option<T>, Fault<Own>> {
    let table = match transaction.open_table(table) {
        Err(TableError::TableDoesNotExist(_)) => return Ok(None),
        table => table?,
    };
    let found = table.get(key)?;
    Ok(found.map(|found| take(found.value())))
}
