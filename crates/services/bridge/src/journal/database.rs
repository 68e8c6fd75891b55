//! Ledgers as tables.

use std::collections::BTreeMap;
use std::sync::Arc;

use ppnpack_packing::checks::motion::Cycle;
use ppnpack_service::database::{DatabaseFile, OwnFault, is_new, read};
use redb::{
    Database, ReadTransaction, ReadableDatabase, ReadableTable, TableDefinition, WriteTransaction,
};
use serde::Serialize;
use serde::de::DeserializeOwned;

use ppnpack_protocol::ledger::{Change, Ledger, Record};

/// Per cell: its [`Head`]. The names of the tables count the versions of what is in them.
const HEADS: TableDefinition<&str, &[u8]> = TableDefinition::new("heads-4");

/// Per cell and number: its [`Record`]s.
const RECORDS: TableDefinition<(&str, u64), &[u8]> = TableDefinition::new("records-2");

/// Per cell: the number of its last placement with a motion, and the motion.
const CYCLES: TableDefinition<&str, &[u8]> = TableDefinition::new("cycles-1");

/// The version of this program.
const VERSION: u64 = 5;

/// A value that is no part of a ledger.
#[derive(Debug, thiserror::Error)]
#[error("it holds something that is no part of a ledger: {0}")]
pub(super) struct NoLedger(postcard::Error);

impl OwnFault for NoLedger {
    fn is_damage(&self) -> bool {
        true
    }
}

/// An error of the database.
pub(super) type Fault = ppnpack_service::database::Fault<NoLedger>;

/// The cells that have ledgers.
pub(super) fn cells(database: &Database) -> Result<Vec<String>, Fault> {
    let transaction = database.begin_read()?;
    if is_new(&transaction, VERSION)? {
        return Ok(Vec::new());
    }
    let mut cells = Vec::new();
    for entry in transaction.open_table(HEADS)?.iter()? {
        cells.push(entry?.0.value().to_owned());
    }
    Ok(cells)
}

/// The ledger of a cell, if it has one.
pub(super) fn load(database: &Database, cell: &str) -> Result<Option<Ledger>, Fault> {
    let transaction = database.begin_read()?;
    is_new(&transaction, VERSION)?;
    let Some(head) = load_one(&transaction, HEADS, cell)? else {
        return Ok(None);
    };
    let mut records = load_records(&transaction, cell)?;
    if let Some((number, cycle)) = load_one::<(u64, Cycle)>(&transaction, CYCLES, cell)?
        && let Some(Record::Placement {
            placement,
            outcome: None,
        }) = records.get_mut(&number)
    {
        placement.cycle = Some(Arc::new(cycle));
    }
    Ok(Some(Ledger::of(head, records)))
}

/// Reads the value of a cell in a table.
fn load_one<T: DeserializeOwned>(
    transaction: &ReadTransaction,
    table: TableDefinition<'_, &'static str, &'static [u8]>,
    cell: &str,
) -> Result<Option<T>, Fault> {
    read(transaction, table, cell, decode)?.transpose()
}

fn load_records(transaction: &ReadTransaction, cell: &str) -> Result<BTreeMap<u64, Record>, Fault> {
    let table = transaction.open_table(RECORDS)?;
    let mut records = BTreeMap::new();
    let all = (cell, 0)..=(cell, u64::MAX);
    for entry in table.range(all)? {
        let (key, record) = entry?;
        records.insert(key.value().1, decode(record.value())?);
    }
    Ok(records)
}

/// Writes a change of a cell's ledger, after the whole ledger if that is given.
pub(super) fn write(
    database: &mut DatabaseFile,
    cell: &str,
    whole: Option<&Ledger>,
    change: &Change,
) -> Result<(), Fault> {
    database.write(VERSION, |transaction| {
        transaction.set_two_phase_commit(true);
        write_one(transaction, HEADS, cell, &change.head)?;
        write_records(transaction, cell, whole, change)?;
        if let Some((number, Record::Placement { placement, .. })) = &change.written
            && let Some(cycle) = &placement.cycle
        {
            write_one(transaction, CYCLES, cell, &(number, &**cycle))?;
        }
        Ok(())
    })
}

/// Writes the value of a cell in a table.
fn write_one(
    transaction: &WriteTransaction,
    table: TableDefinition<'_, &'static str, &'static [u8]>,
    cell: &str,
    value: &impl Serialize,
) -> Result<(), Fault> {
    let mut table = transaction.open_table(table)?;
    table.insert(cell, encode(value)?.as_slice())?;
    Ok(())
}

fn write_records(
    transaction: &WriteTransaction,
    cell: &str,
    whole: Option<&Ledger>,
    change: &Change,
) -> Result<(), Fault> {
    let mut records = transaction.open_table(RECORDS)?;
    if let Some(ledger) = whole {
        let all = (cell, 0)..=(cell, u64::MAX);
        records.retain_in(all, |_, _| false)?;
        for (number, record) in ledger.records() {
            records.insert((cell, number), encode(record)?.as_slice())?;
        }
    }
    for number in &change.forgotten {
        records.remove((cell, *number))?;
    }
    if let Some((number, record)) = &change.written {
        records.insert((cell, *number), encode(record)?.as_slice())?;
    }
    Ok(())
}

pub(super) fn encode(value: &impl Serialize) -> Result<Vec<u8>, Fault> {
    Ok(postcard::to_stdvec(value).map_err(NoLedger)?)
}

fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Fault> {
    Ok(postcard::from_bytes(bytes).map_err(NoLedger)?)
}
