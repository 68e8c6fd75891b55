//! A bridge's journal and a planner's store, read without the services.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use ppnpack_protocol::ledger::Record;
use ppnpack_protocol::placing::Ending;
use ppnpack_wire::v1;
use prost::Message;
use redb::{Database, ReadableDatabase, TableDefinition};

use crate::packer::Container;

/// The journal's records by cell and number.
const RECORDS: TableDefinition<(&str, u64), &[u8]> = TableDefinition::new("records-2");

/// The number of the first record.
const FIRST: u64 = 1;

/// The sessions by cell, in the store's file of the cell.
const SESSIONS: TableDefinition<&str, &[u8]> = TableDefinition::new("sessions");

#[derive(Debug, Clone)]
pub(crate) struct Files {
    pub(crate) journal: PathBuf,
    /// The planner's store; the files of cells lie in a folder beside it.
    pub(crate) store: PathBuf,
}

impl Files {
    pub(crate) fn in_folder(folder: &Path) -> Self {
        Self {
            journal: folder.join("bridge.redb"),
            store: folder.join("sessions.redb"),
        }
    }

    fn of_cell(&self, cell: &str) -> PathBuf {
        self.store
            .with_extension("cells")
            .join(format!("{cell}.redb"))
    }

    /// Copies the files of killed services to another folder: to open a file mends it, which is
    /// left to the services.
    pub(crate) fn copied(&self, folder: &Path, cells: &[String]) -> Result<Self> {
        let copy = Self::in_folder(folder);
        std::fs::copy(&self.journal, &copy.journal)?;
        for cell in cells {
            let to = copy.of_cell(cell);
            to.parent().map(std::fs::create_dir_all).transpose()?;
            std::fs::copy(self.of_cell(cell), to)?;
        }
        Ok(copy)
    }
}

#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Contents {
    /// The items that were placed into it, in their order.
    pub(crate) placed: Vec<String>,
    /// The items that left the cell.
    pub(crate) lost: BTreeSet<String>,
}

/// A journal's account of a cell.
#[derive(Debug, Clone, Default)]
pub(crate) struct Told {
    /// The containers one after the other, the present one at last.
    pub(crate) containers: Vec<Contents>,
    /// Whether something was under way.
    pub(crate) is_unfinished: bool,
    /// Whether it has forgotten the first records.
    pub(crate) has_forgotten: bool,
}

/// Reads a journal's account of a cell.
///
/// # Errors
/// Where it cannot be read, a placement id was used twice, an item was placed twice into one
/// container or lies nobody knows where, anything but the last has no end, or the numbers of states
/// go back.
pub(crate) fn journal(files: &Files, cell: &str) -> Result<Told> {
    let database = Database::open(&files.journal).context("the journal cannot be opened")?;
    let table = database.begin_read()?.open_table(RECORDS)?;
    let mut told = Told::default();
    let mut present = Contents::default();
    let mut ids = BTreeSet::new();
    let mut last_state = 0;
    let mut first = None;
    for entry in table.range((cell, 0)..=(cell, u64::MAX))? {
        let (key, value) = entry?;
        let number = key.value().1;
        first = first.or(Some(number));
        ensure!(!told.is_unfinished, "what was before {number} has no end");
        let record: Record = postcard::from_bytes(value.value())
            .with_context(|| format!("record {number} cannot be read"))?;
        let state = match record {
            Record::Renewal { state_number, .. } => {
                if state_number.is_some() {
                    told.containers.push(std::mem::take(&mut present));
                }
                state_number
            }
            Record::Placement { placement, outcome } => {
                let id = &placement.placement_id;
                ensure!(ids.insert(id.clone()), "placement {id} was begun twice");
                if let Some(outcome) = &outcome {
                    present.enter(placement.item_id, outcome.finding.ending)?;
                }
                outcome.map(|outcome| outcome.state_number)
            }
        };
        told.is_unfinished = state.is_none();
        let state = state.unwrap_or(last_state);
        ensure!(
            state >= last_state,
            "state {state} comes after {last_state}"
        );
        last_state = state;
    }
    told.containers.push(present);
    told.has_forgotten = first.is_some_and(|first| first > FIRST);
    Ok(told)
}

impl Contents {
    fn enter(&mut self, item: String, ending: Ending) -> Result<()> {
        match ending {
            Ending::Placed => {
                ensure!(!self.placed.contains(&item), "{item} was placed twice");
                self.placed.push(item);
            }
            Ending::Lost => {
                self.lost.insert(item);
            }
            Ending::NotPlaced => {}
            Ending::Unknown => bail!("nobody knows where {item} is"),
        }
        Ok(())
    }

    /// Whether the planner acknowledged just these items.
    pub(crate) fn is_that_of(&self, container: &Container) -> bool {
        let placed: BTreeSet<String> = self.placed.iter().cloned().collect();
        placed == container.placed() && self.lost == container.lost
    }

    /// Whether all that the planner acknowledged is here, and nothing else but the items of its
    /// last decision, of which it may not have the outcome.
    fn agrees_with(&self, container: &Container, decided: &BTreeSet<&str>) -> bool {
        let known = container.placed();
        let placed: BTreeSet<String> = self.placed.iter().cloned().collect();
        let mut unknown = placed
            .difference(&known)
            .chain(self.lost.difference(&container.lost));
        known.is_subset(&placed)
            && container.lost.is_subset(&self.lost)
            && unknown.all(|item| decided.contains(item.as_str()))
    }
}

/// Reads the session of a cell; gives an empty one where none was written.
pub(crate) fn session(files: &Files, cell: &str) -> Result<v1::Session> {
    let path = files.of_cell(cell);
    let database = Database::open(path).context("the store cannot be opened")?;
    let table = database.begin_read()?.open_table(SESSIONS)?;
    let written = table.get(cell)?;
    let session = written.map(|written| v1::Session::decode(written.value()));
    Ok(session.transpose()?.unwrap_or_default())
}

/// Compares the store and the journal of killed services.
///
/// # Errors
/// Where they cannot be read, or the store does not agree with the journal.
pub(crate) fn check_killed(files: &Files, cells: &[String]) -> Result<()> {
    let folder = tempfile::tempdir()?;
    let files = files.copied(folder.path(), cells)?;
    for cell in cells {
        let session = session(&files, cell)?;
        let acknowledged = Container::of(&session);
        let pending = session.pending.iter();
        let decided = pending.map(|decision| decision.item_id.as_str()).collect();
        let told = journal(&files, cell)?;
        let last = told.containers.iter().rev();
        // Where an empty one was brought after the session has ended, it is about the one before.
        let is_empty = |contents: &&Contents| **contents == Contents::default();
        let skipped = usize::from(told.containers.last().as_ref().is_some_and(is_empty));
        let mut both = last.take(1 + skipped);
        ensure!(
            both.any(|contents| contents.agrees_with(&acknowledged, &decided)),
            "{cell}: the store of a planner that was killed does not agree with the journal: {acknowledged:?}, decided \
             {decided:?}; {:?}",
            told.containers.last()
        );
    }
    Ok(())
}

/// Compares the containers that the planner acknowledged with journal and store; the last ones,
/// where the journal has forgotten the first.
///
/// # Errors
/// Where they cannot be read, or disagree.
pub(crate) fn check_ended(files: &Files, cell: &str, acknowledged: &[Container]) -> Result<()> {
    let journal = journal(files, cell)?;
    ensure!(!journal.is_unfinished, "{cell}: something has no end");
    let told = journal.containers.iter();
    let told = told.filter(|contents| !contents.placed.is_empty());
    let told: Vec<&Contents> = told.collect();
    let acknowledged = acknowledged.iter();
    let acknowledged = acknowledged.filter(|container| !container.placed().is_empty());
    let acknowledged: Vec<&Container> = acknowledged.collect();
    // Of the first that is left only a part may be known.
    let known = told.len() - usize::from(journal.has_forgotten && !told.is_empty());
    let is_as_many = journal.has_forgotten || known == acknowledged.len();
    let mut pairs = told.iter().rev().zip(acknowledged.iter().rev()).take(known);
    ensure!(
        known > 0 && is_as_many && pairs.all(|(told, by_planner)| told.is_that_of(by_planner)),
        "{cell}: the journal does not say what was acknowledged"
    );
    let stored = Container::of(&session(files, cell)?);
    let last = told.last().is_some_and(|told| told.is_that_of(&stored));
    ensure!(
        last || stored.placed().is_empty(),
        "{cell}: what the store says is packed is not what the journal says: {:?}",
        stored.placed()
    );
    Ok(())
}
