//! Databases in files that have to stay where they are.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::ops::Deref;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use redb::backends::{FileBackend, InMemoryBackend};
use redb::{Database, ReadableDatabase, ReadableTable, WriteTransaction};

use super::mark::Mark;
use super::{FORMAT, Fault, OwnFault, REVISION_KEY, VERSION_KEY, builder, guarded, read};

/// A database with its file.
pub struct DatabaseFile {
    database: Database,
    /// `None` in memory.
    place: Option<Place>,
}

struct Place {
    path: PathBuf,
    /// The device, and its number for the file.
    file: (u64, u64),
    mark: Mark,
}

impl Place {
    fn of(path: &Path, file: &File) -> io::Result<Self> {
        Ok(Self {
            path: path.to_owned(),
            file: identity(&file.metadata()?),
            mark: Mark::open(path)?,
        })
    }

    /// Says whether the path still leads to the file that is open.
    fn is_kept(&self) -> bool {
        let there = fs::metadata(&self.path);
        there.is_ok_and(|there| identity(&there) == self.file)
    }
}

fn identity(metadata: &fs::Metadata) -> (u64, u64) {
    (metadata.dev(), metadata.ino())
}

/// Opens a file, and begins it where there is none. A change of it by another program, or the disk,
/// is found here; so is an older copy of it.
///
/// # Errors
/// [`Fault`]
pub fn open<Own: OwnFault>(path: &Path) -> Result<DatabaseFile, Fault<Own>> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let mut options = OpenOptions::new();
    options.read(true).write(true).create(true).truncate(false);
    let file = options.open(path)?;
    let mut place = Place::of(path, &file)?;
    let database = guarded::<Database, Own>(|| {
        let mut builder = builder();
        builder.set_check_integrity_on_open(true);
        Ok(builder.create_with_backend(FileBackend::new(file)?)?)
    })?;
    let found = read(&database.begin_read()?, FORMAT, REVISION_KEY, |found| found)?;
    let (found, written) = (found.unwrap_or_default(), place.mark.read()?);
    if found < written {
        return Err(Fault::RolledBack { found, written });
    }
    Ok(DatabaseFile {
        database,
        place: Some(place),
    })
}

/// Makes a database in memory, which is lost with the process.
///
/// # Errors
/// [`Fault`]
pub fn in_memory<Own: OwnFault>() -> Result<DatabaseFile, Fault<Own>> {
    let database = builder().create_with_backend(InMemoryBackend::new())?;
    Ok(database.into())
}

impl From<Database> for DatabaseFile {
    fn from(database: Database) -> Self {
        Self {
            database,
            place: None,
        }
    }
}

impl Deref for DatabaseFile {
    type Target = Database;

    fn deref(&self) -> &Database {
        &self.database
    }
}

impl DatabaseFile {
    /// Writes the changes of the work, as this version, and counts the revision up. They are on
    /// disk when this returns.
    ///
    /// # Errors
    /// [`Fault::Moved`] where the path does not lead to the file any more; that of the work, or of
    /// the disk.
    pub fn write<Own: OwnFault>(
        &mut self,
        version: u64,
        work: impl FnOnce(&mut WriteTransaction) -> Result<(), Fault<Own>>,
    ) -> Result<(), Fault<Own>> {
        if let Some(place) = self.place.as_ref().filter(|place| !place.is_kept()) {
            return Err(Fault::Moved(place.path.clone()));
        }
        let mut transaction = self.database.begin_write()?;
        let mut format = transaction.open_table(FORMAT)?;
        let before = format.get(REVISION_KEY)?.map(|found| found.value());
        let revision = before.unwrap_or_default().saturating_add(1);
        format.insert(REVISION_KEY, revision)?;
        format.insert(VERSION_KEY, version)?;
        drop(format);
        work(&mut transaction)?;
        transaction.commit()?;
        if let Some(place) = &mut self.place {
            place.mark.write(revision);
        }
        Ok(())
    }
}
