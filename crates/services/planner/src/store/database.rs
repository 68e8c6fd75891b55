//! Sessions as tables.

use std::collections::BTreeSet;

use ppnpack_service::database::{FORMAT, OwnFault, VERSION_KEY, is_new, read};
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;
use prost::Message;
use redb::{Database, ReadableDatabase, ReadableTable, TableDefinition, WriteTransaction};

/// Per cell: its session.
const SESSIONS: TableDefinition<&str, &[u8]> = TableDefinition::new("sessions");

/// Per cell and id: heightmaps of items that were announced with them.
const SHAPES: TableDefinition<(&str, &[u8]), &[u8]> = TableDefinition::new("shapes");

/// Beside the version in [`FORMAT`]: how many times the file was written.
const REVISION_KEY: &str = "revision";

/// The version of this program.
pub(super) const VERSION: u64 = 2;

/// What else can be wrong with the file of a cell.
#[derive(Debug, thiserror::Error)]
pub(super) enum StoreFault {
    /// It is not what was written last.
    #[error("it holds revision {found}, and revision {written} was written")]
    RolledBack { found: u64, written: u64 },
    /// The heightmaps of a session would take too much.
    #[error("heightmaps of {bytes} bytes where {most} are possible")]
    TooManyShapes { bytes: u64, most: u64 },
}

impl OwnFault for StoreFault {
    fn is_damage(&self) -> bool {
        match self {
            Self::RolledBack { .. } => true,
            Self::TooManyShapes { .. } => false,
        }
    }
}

/// Why the database did not do what was asked.
pub(super) type Fault = ppnpack_service::database::Fault<StoreFault>;

/// What becomes of the heightmaps when a session is written.
pub(super) enum Change<'a> {
    /// Some are added, where all together then have no more bytes than may be; those that no item of the session refers to any more
    /// are forgotten.
    Add {
        shapes: &'a [v1::Item],
        /// The ids of those that items refer to.
        used: BTreeSet<Vec<u8>>,
        most_bytes: u64,
    },
    /// All are forgotten.
    Forget,
}

/// The session of a cell, as it is encoded.
pub(super) fn session(database: &Database, cell: &Cell) -> Result<Option<Vec<u8>>, Fault> {
    let transaction = database.begin_read()?;
    is_new(&transaction, VERSION)?;
    read(&transaction, SESSIONS, cell.as_str(), <[u8]>::to_vec)
}

/// The heightmaps of this id, as they are encoded.
pub(super) fn shape(
    database: &Database,
    cell: &Cell,
    id: ItemId,
) -> Result<Option<Vec<u8>>, Fault> {
    let key = (cell.as_str(), id.to_bytes());
    let transaction = database.begin_read()?;
    read(
        &transaction,
        SHAPES,
        (key.0, key.1.as_slice()),
        <[u8]>::to_vec,
    )
}

/// Writes a session, as it is encoded, and what becomes of the heightmaps. Gives the revision.
pub(super) fn write(
    database: &Database,
    cell: &Cell,
    session: &[u8],
    change: &Change<'_>,
) -> Result<u64, Fault> {
    let (transaction, revision) = begin_write(database)?;
    transaction
        .open_table(SESSIONS)?
        .insert(cell.as_str(), session)?;
    match change {
        Change::Forget => transaction
            .open_table(SHAPES)?
            .retain(|(of, _), _| of != cell.as_str())?,
        Change::Add { shapes: [], .. } => {}
        Change::Add {
            shapes,
            used,
            most_bytes,
        } => add(&transaction, cell, shapes, used, *most_bytes)?,
    }
    transaction.commit()?;
    Ok(revision)
}

/// Adds heightmaps. Those that are there already stay as they are.
fn add(
    transaction: &WriteTransaction,
    cell: &Cell,
    shapes: &[v1::Item],
    used: &BTreeSet<Vec<u8>>,
    most: u64,
) -> Result<(), Fault> {
    let mut table = transaction.open_table(SHAPES)?;
    table.retain(|(of, id), _| of != cell.as_str() || used.contains(id))?;
    let mut bytes = 0;
    for entry in table.iter()? {
        bytes += entry?.1.value().len() as u64;
    }
    for shape in shapes {
        let id = ItemId::of(shape).to_bytes();
        let key = (cell.as_str(), id.as_slice());
        if table.get(key)?.is_some() {
            continue;
        }
        bytes += shape.encoded_len() as u64;
        if bytes > most {
            return Err(StoreFault::TooManyShapes { bytes, most }.into());
        }
        table.insert(key, shape.encode_to_vec().as_slice())?;
    }
    Ok(())
}

/// Makes a new file one of this version. It has no mark: the commit is in two phases, so that damage is never taken for a crash.
pub(super) fn begin_version(root: &Database) -> Result<(), Fault> {
    if is_new(&root.begin_read()?, VERSION)? {
        let (mut transaction, _) = begin_write(root)?;
        transaction.set_two_phase_commit(true);
        transaction.commit()?;
    }
    Ok(())
}

/// How many times the file was written; zero in a new one.
pub(super) fn revision(database: &Database) -> Result<u64, Fault> {
    let revision = read(&database.begin_read()?, FORMAT, REVISION_KEY, |found| found)?;
    Ok(revision.unwrap_or_default())
}

/// Begins to write, with the version and the revision that it will be.
fn begin_write(database: &Database) -> Result<(WriteTransaction, u64), Fault> {
    let transaction = database.begin_write()?;
    let mut format = transaction.open_table(FORMAT)?;
    let before = format.get(REVISION_KEY)?.map(|found| found.value());
    let revision = before.unwrap_or_default().saturating_add(1);
    format.insert(REVISION_KEY, revision)?;
    format.insert(VERSION_KEY, VERSION)?;
    drop(format);
    Ok((transaction, revision))
}
