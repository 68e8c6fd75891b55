//! Sessions as tables.

use std::collections::BTreeSet;

use ppnpack_protocol::session::Session;
use ppnpack_service::database::{DatabaseFile, OwnFault, is_new, read};
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::{MAX_MESSAGE_BYTES, WireError, v1};
use prost::Message;
use redb::{
    Database, ReadTransaction, ReadableDatabase, ReadableTable, TableDefinition, TableError,
    WriteTransaction,
};

/// Per cell: its session.
const SESSIONS: TableDefinition<&str, &[u8]> = TableDefinition::new("sessions");

/// Per cell and id: heightmaps of items that were announced with them.
const SHAPES: TableDefinition<(&str, &[u8]), &[u8]> = TableDefinition::new("shapes");

/// The version of this program.
pub(super) const VERSION: u64 = 2;

/// A fault of a cell's file, beside those of any database.
#[derive(Debug, thiserror::Error)]
pub(super) enum StoreFault {
    /// It is the file of another cell.
    #[error("it is the file of cell {0}, which was put in the place of this one's")]
    OtherCell(String),
    /// It holds no session.
    #[error("what it holds is no session: {0}")]
    NoSession(WireError),
    /// The heightmaps of a session would take too much.
    #[error("heightmaps of {bytes} bytes where {most} are possible")]
    TooManyShapes { bytes: u64, most: u64 },
}

impl OwnFault for StoreFault {
    fn is_damage(&self) -> bool {
        match self {
            Self::OtherCell(_) | Self::NoSession(_) => true,
            Self::TooManyShapes { .. } => false,
        }
    }
}

/// Why the database did not do what was asked.
pub(super) type Fault = ppnpack_service::database::Fault<StoreFault>;

/// A change of the heightmaps when a session is written.
pub(super) enum Change<'a> {
    /// Adds some, where all together have no more bytes than may be; those that no item of the
    /// session refers to any more are forgotten.
    Add {
        shapes: &'a [v1::Item],
        /// The ids of those that items refer to.
        used: BTreeSet<Vec<u8>>,
        most_bytes: u64,
    },
    /// Forgets all.
    Forget,
}

/// Reads the session of a cell; `None` before the first one.
pub(super) fn session(database: &Database, cell: &Cell) -> Result<Option<Session>, Fault> {
    let transaction = database.begin_read()?;
    if is_new(&transaction, VERSION)? {
        return Ok(None);
    }
    let Some(bytes) = read(&transaction, SESSIONS, cell.as_str(), <[u8]>::to_vec)? else {
        return match cells(&transaction)?.pop() {
            Some(other) => Err(StoreFault::OtherCell(other).into()),
            None => Ok(None),
        };
    };
    let message = ppnpack_wire::decode::<v1::Session>(&bytes, MAX_MESSAGE_BYTES);
    let session = message.and_then(Session::from_message);
    Ok(Some(session.map_err(StoreFault::NoSession)?))
}

/// Reads which cells have a session.
fn cells(transaction: &ReadTransaction) -> Result<Vec<String>, Fault> {
    let table = match transaction.open_table(SESSIONS) {
        Err(TableError::TableDoesNotExist(_)) => return Ok(Vec::new()),
        table => table?,
    };
    let mut names = Vec::new();
    for entry in table.iter()? {
        names.push(entry?.0.value().to_owned());
    }
    Ok(names)
}

/// Reads the heightmaps of this id, as they are encoded.
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

/// Writes a session, as it is encoded, and what becomes of the heightmaps.
pub(super) fn write(
    database: &mut DatabaseFile,
    cell: &Cell,
    session: &[u8],
    change: &Change<'_>,
) -> Result<(), Fault> {
    database.write(VERSION, |transaction| {
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
            } => add(transaction, cell, shapes, used, *most_bytes)?,
        }
        Ok(())
    })
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

/// Makes a new file one of this version.
pub(super) fn begin_version(root: &mut DatabaseFile) -> Result<(), Fault> {
    match is_new(&root.begin_read()?, VERSION)? {
        true => root.write(VERSION, |_| Ok(())),
        false => Ok(()),
    }
}
