//! What a bridge's journal says of a cell, read by itself: neither the bridge nor the planner takes part.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use ppnpack_protocol::ledger::Record;
use ppnpack_protocol::placing::Ending;
use redb::{ReadableDatabase, TableDefinition};

/// Per cell and number: its records.
const RECORDS: TableDefinition<(&str, u64), &[u8]> = TableDefinition::new("records-1");

/// What was placed into one container, in its order.
pub type Contents = Vec<String>;

/// What was placed into each container of a cell, one after the other; containers into which nothing was placed are left out.
///
/// # Errors
/// Where the journal cannot be read, where a placement id was used twice, an item was placed twice into one container, something
/// has no end, or the numbers of states go back.
pub fn containers(journal: &Path, cell: &str) -> Result<Vec<Contents>> {
    let database = redb::Database::open(journal).context("the journal cannot be opened")?;
    let table = database.begin_read()?.open_table(RECORDS)?;
    let mut containers = Vec::new();
    let mut placed = Contents::new();
    let mut ids = BTreeSet::new();
    let mut last_state = 0;
    for entry in table.range((cell, 0)..=(cell, u64::MAX))? {
        let (key, value) = entry?;
        let number = key.value().1;
        let record: Record = postcard::from_bytes(value.value())
            .with_context(|| format!("record {number} cannot be read"))?;
        let state = match record {
            Record::Renewal { state_number, .. } => {
                containers.push(std::mem::take(&mut placed));
                state_number
            }
            Record::Placement { placement, outcome } => {
                let id = &placement.placement_id;
                ensure!(ids.insert(id.clone()), "placement {id} was begun twice");
                let ending = outcome.as_ref().map(|outcome| outcome.finding.ending);
                if ending == Some(Ending::Placed) {
                    let item = placement.item_id;
                    ensure!(!placed.contains(&item), "{item} was placed twice");
                    placed.push(item);
                }
                outcome.map(|outcome| outcome.state_number)
            }
        };
        let state = state.with_context(|| format!("record {number} has no end"))?;
        ensure!(
            state >= last_state,
            "state {state} comes after {last_state}"
        );
        last_state = state;
    }
    containers.push(placed);
    containers.retain(|placed| !placed.is_empty());
    Ok(containers)
}
