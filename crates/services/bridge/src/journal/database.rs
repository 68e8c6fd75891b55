//! Ledgers as tables.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use nalgebra::Isometry3;
use ppnpack_packing::motion::Cycle;
use ppnpack_service::database::{FORMAT, OwnFault, VERSION_KEY, read, version};
use redb::{
    Database, ReadTransaction, ReadableDatabase, ReadableTable, Table, TableDefinition, TableError,
    WriteTransaction,
};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::robot::{Body, KnownPose};
use ppnpack_protocol::ledger::{Change, Head, Ledger, Record};

/// Per cell: its [`Head`]. The names of the tables count the versions of what is in them.
const HEADS: TableDefinition<&str, &[u8]> = TableDefinition::new("heads-3");

/// Per cell: its [`SecondHead`], of which a new one is made where there is none.
const SECOND_HEADS: TableDefinition<&str, &[u8]> = TableDefinition::new("heads-2");

/// Per cell: its [`FirstHead`], of which a new one is made where there is neither.
const FIRST_HEADS: TableDefinition<&str, &[u8]> = TableDefinition::new("heads-1");

/// Per cell and number: its [`Record`]s.
const RECORDS: TableDefinition<(&str, u64), &[u8]> = TableDefinition::new("records-1");

/// Per cell: the number of its last placement with a motion, and the motion.
const CYCLES: TableDefinition<&str, &[u8]> = TableDefinition::new("cycles-1");

/// The newest version that this program knows, which it writes.
const VERSION: u64 = 3;

/// What it holds is not what was written.
#[derive(Debug, thiserror::Error)]
#[error("it holds something that is no part of a ledger: {0}")]
pub(super) struct NoLedger(postcard::Error);

impl OwnFault for NoLedger {
    fn is_damage(&self) -> bool {
        true
    }
}

/// Why the database did not do what was asked.
pub(super) type Fault = ppnpack_service::database::Fault<NoLedger>;

/// A body as it was written before it said how its pose is known: item, object, pose, and whether
/// it is inside.
type FirstBody = (String, String, Isometry3<f64>, bool);

/// A head as it was written before bodies said how their poses are known.
#[derive(Deserialize)]
struct SecondHead {
    state_number: u64,
    first_state_number: u64,
    hold: Option<String>,
    next: u64,
    bodies: Vec<FirstBody>,
}

/// A head as it was written before there were holds.
#[derive(Deserialize)]
struct FirstHead {
    state_number: u64,
    next: u64,
    bodies: Vec<FirstBody>,
}

impl From<SecondHead> for Head {
    fn from(second: SecondHead) -> Self {
        let bodies = second.bodies.into_iter();
        let bodies = bodies.map(|(item_id, object, pose, is_inside)| Body {
            item_id,
            object,
            container_from_item: KnownPose::Assumed(pose),
            is_inside,
        });
        Self {
            state_number: second.state_number,
            first_state_number: second.first_state_number,
            hold: second.hold,
            next: second.next,
            bodies: bodies.collect(),
        }
    }
}

impl From<FirstHead> for SecondHead {
    /// What was forgotten before is not known: all is from now on.
    fn from(first: FirstHead) -> Self {
        Self {
            state_number: first.state_number,
            first_state_number: first.state_number,
            hold: None,
            next: first.next,
            bodies: first.bodies,
        }
    }
}

/// The cells that have ledgers.
pub(super) fn cells(database: &Database) -> Result<Vec<String>, Fault> {
    let transaction = database.begin_read()?;
    let mut cells = BTreeSet::new();
    for table in [HEADS, SECOND_HEADS, FIRST_HEADS] {
        let table = match transaction.open_table(table) {
            Err(TableError::TableDoesNotExist(_)) => continue,
            table => table?,
        };
        for entry in table.iter()? {
            cells.insert(entry?.0.value().to_owned());
        }
    }
    Ok(cells.into_iter().collect())
}

/// The ledger of a cell, if it has one.
pub(super) fn load(database: &Database, cell: &str) -> Result<Option<Ledger>, Fault> {
    let transaction = database.begin_read()?;
    version(&transaction, VERSION)?;
    let Some(head) = load_head(&transaction, cell)? else {
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

/// The head of a cell, of whichever version it is.
fn load_head(transaction: &ReadTransaction, cell: &str) -> Result<Option<Head>, Fault> {
    if let Some(head) = load_one::<Head>(transaction, HEADS, cell)? {
        return Ok(Some(head));
    }
    let second = match load_one::<SecondHead>(transaction, SECOND_HEADS, cell)? {
        Some(second) => Some(second),
        None => load_one::<FirstHead>(transaction, FIRST_HEADS, cell)?.map(SecondHead::from),
    };
    Ok(second.map(Head::from))
}

/// What a table has for a cell.
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

/// Writes a change of a cell's ledger; the whole ledger before it, where one is given.
pub(super) fn write(
    database: &Database,
    cell: &str,
    whole: Option<&Ledger>,
    change: &Change,
) -> Result<(), Fault> {
    let mut transaction = database.begin_write()?;
    transaction.set_two_phase_commit(true);
    transaction
        .open_table(FORMAT)?
        .insert(VERSION_KEY, VERSION)?;
    write_one(&transaction, HEADS, cell, &change.head)?;
    // Whoever reads these alone must not go on from a state that is past.
    for table in [SECOND_HEADS, FIRST_HEADS] {
        transaction.open_table(table)?.remove(cell)?;
    }
    write_records(&transaction, cell, whole, change)?;
    if let Some((number, Record::Placement { placement, .. })) = &change.written
        && let Some(cycle) = &placement.cycle
    {
        write_one(&transaction, CYCLES, cell, &(number, &**cycle))?;
    }
    transaction.commit()?;
    Ok(())
}

/// Writes what a table has for a cell.
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
            insert(&mut records, cell, number, record)?;
        }
    }
    for number in &change.forgotten {
        records.remove((cell, *number))?;
    }
    match &change.written {
        Some((number, record)) => insert(&mut records, cell, *number, record),
        None => Ok(()),
    }
}

fn insert(
    records: &mut Table<'_, (&'static str, u64), &'static [u8]>,
    cell: &str,
    number: u64,
    record: &Record,
) -> Result<(), Fault> {
    records.insert((cell, number), encode(record)?.as_slice())?;
    Ok(())
}

fn encode(value: &impl Serialize) -> Result<Vec<u8>, Fault> {
    Ok(postcard::to_stdvec(value).map_err(NoLedger)?)
}

fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Fault> {
    Ok(postcard::from_bytes(bytes).map_err(NoLedger)?)
}
