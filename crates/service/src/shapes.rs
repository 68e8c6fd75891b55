//! The items and solids that records of planned steps name, asked of the planner that published
//! them.

use std::collections::BTreeSet;
use std::time::Instant;

use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;

use crate::rpc::{CallError, Client};

const MOST_ASKED: usize = 256;

/// Gives the ids of all items and solids that a record names.
pub fn named(record: &v1::PlanningRecord) -> BTreeSet<Vec<u8>> {
    let candidates = record.candidates.iter();
    let candidates = candidates.flat_map(|held| [&held.item, &held.solid]);
    let containers = record.containers.iter();
    let contents = containers.filter_map(|at| at.content.as_ref());
    let bodies = contents.flat_map(|content| &content.bodies);
    let bodies = bodies.map(|body| &body.solid);
    let ids = candidates.chain(bodies);
    ids.filter(|id| !id.is_empty()).cloned().collect()
}

/// Asks a cell's planner for these and hands each over as it comes; gives the number of those that
/// the planner does not have.
///
/// # Errors
/// [`CallError`] where it does not answer in time, or refuses.
pub fn fetch(
    client: &Client,
    cell: &Cell,
    ids: impl IntoIterator<Item = Vec<u8>>,
    deadline: Instant,
    mut keep: impl FnMut(v1::Shape),
) -> Result<usize, CallError> {
    let mut missing: BTreeSet<Vec<u8>> = ids.into_iter().collect();
    let mut unknown = 0;
    while !missing.is_empty() {
        let request = v1::ShapesRequest {
            ids: missing.iter().take(MOST_ASKED).cloned().collect(),
            ..v1::ShapesRequest::default()
        };
        let reply = client.call(cell, request, deadline)?;
        let before = missing.len();
        for id in &reply.unknown {
            unknown += usize::from(missing.remove(id));
        }
        for shape in reply.shapes {
            if missing.remove(&shape.id) {
                keep(shape);
            }
        }
        // A planner that answers with nothing that was asked for would be asked for ever.
        if missing.len() == before {
            break;
        }
    }
    Ok(unknown + missing.len())
}
