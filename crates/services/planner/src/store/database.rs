//! Sessions as tables.

use std::collections::BTreeSet;

use ppnpack_service::database::{FORMAT, OwnFault, VERSION_KEY, read, version};
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;
use prost::Message;
use redb::{
    Database, ReadTransaction, ReadableDatabase, ReadableTable, TableDefinition, TableError,
    WriteTransaction,
};

/// Per cell: its session.
const SESSIONS: TableDefinition<&str, &[u8]> = TableDefinition::new("sessions");

/// Per cell and id: heightmaps of items that were announced with them.
const SHAPES: TableDefinition<(&str, &[u8]), &[u8]> = TableDefinition::new("shapes");

/// Beside the version in [`FORMAT`]: how many times the file was written.
const REVISION_KEY: &str = "revision";

/// The newest version that this program knows, which it writes. The first had one file for all cells.
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

/// An id and the heightmaps of that id, as they are encoded.
type Shape = (Vec<u8>, Vec<u8>);

/// What is kept of a cell.
pub(super) struct Kept {
    pub(super) cell: Cell,
    session: Vec<u8>,
    shapes: Vec<Shape>,
}

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
    version(&transaction, VERSION)?;
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

/// What is in the file of a store of the first version; nothing in one of this version, or in a new file.
pub(super) fn first_version(root: &Database) -> Result<Vec<Kept>, Fault> {
    let transaction = root.begin_read()?;
    if version(&transaction, VERSION)?.is_some() {
        return Ok(Vec::new());
    }
    let table = match transaction.open_table(SESSIONS) {
        Err(TableError::TableDoesNotExist(_)) => return Ok(Vec::new()),
        table => table?,
    };
    let mut kept = Vec::new();
    for entry in table.iter()? {
        let (cell, session) = entry?;
        if let Ok(cell) = Cell::new(cell.value()) {
            kept.push(Kept {
                shapes: shapes_of(&transaction, &cell)?,
                session: session.value().to_vec(),
                cell,
            });
        }
    }
    Ok(kept)
}

fn shapes_of(transaction: &ReadTransaction, cell: &Cell) -> Result<Vec<Shape>, Fault> {
    let mut shapes = Vec::new();
    for entry in transaction.open_table(SHAPES)?.iter()? {
        let (key, shape) = entry?;
        let (of, id) = key.value();
        if of == cell.as_str() {
            shapes.push((id.to_vec(), shape.value().to_vec()));
        }
    }
    Ok(shapes)
}

/// Writes what a store of the first version had of a cell into the file of that cell. Gives the revision.
pub(super) fn write_kept(database: &Database, kept: &Kept) -> Result<u64, Fault> {
    let (transaction, revision) = begin_write(database)?;
    {
        let cell = kept.cell.as_str();
        let mut sessions = transaction.open_table(SESSIONS)?;
        sessions.insert(cell, kept.session.as_slice())?;
        let mut shapes = transaction.open_table(SHAPES)?;
        for (id, shape) in &kept.shapes {
            shapes.insert((cell, id.as_slice()), shape.as_slice())?;
        }
    }
    transaction.commit()?;
    Ok(revision)
}

/// Makes the file of a store one of this version: what it said before is in the files of the cells. It has no mark: the commit is
/// in two phases, so that damage is never taken for a crash, after which the sessions of the first version would count again.
pub(super) fn begin_version(root: &Database) -> Result<(), Fault> {
    if version(&root.begin_read()?, VERSION)? == Some(VERSION) {
        return Ok(());
    }
    let (mut transaction, _) = begin_write(root)?;
    transaction.set_two_phase_commit(true);
    transaction.delete_table(SESSIONS)?;
    transaction.delete_table(SHAPES)?;
    transaction.commit()?;
    Ok(())
}

/// How many times the file was written; zero in a new one, and in one of a program that did not count.
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
