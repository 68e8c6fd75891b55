//! Automatic packing, container after container, for a long time: what it costs at the start and at the end.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow, ensure};
use ppnpack_wire::keys::{Stream, every_cell};
use ppnpack_wire::v1::{self, ItemState, SessionEnd};
use ppnpack_wire::{MAX_MESSAGE_BYTES, decode};
use zenoh::Wait;

use crate::Stack;
use crate::cell::CellClient;

/// How often a session is looked at.
const LOOK: Duration = Duration::from_millis(200);

/// How long one container may take.
const CONTAINER_LIMIT: Duration = Duration::from_secs(600);

/// A decision that was made meanwhile.
#[derive(Debug, Clone, Copy)]
pub struct Decided {
    /// Since the start.
    pub at: Duration,
    /// From the heightmap to the decision on disk.
    pub took: Duration,
    /// Whether it was planned in another way than was asked for.
    pub is_degraded: bool,
}

/// Notes every decision of the stack, with the time since `start`.
///
/// # Errors
/// Where the stream cannot be subscribed.
pub fn note_decisions(stack: &Stack, start: Instant) -> Result<Arc<Mutex<Vec<Decided>>>> {
    let decisions = Arc::new(Mutex::new(Vec::new()));
    let noted = Arc::clone(&decisions);
    stack
        .session()
        .declare_subscriber(every_cell(Stream::Plan))
        .callback(move |sample| {
            let payload = sample.payload().to_bytes();
            let Ok(decision) = decode::<v1::Decision>(&payload, MAX_MESSAGE_BYTES) else {
                return;
            };
            let mut noted = noted.lock().unwrap_or_else(PoisonError::into_inner);
            noted.push(decided(&decision, start.elapsed()));
        })
        .background()
        .wait()
        .map_err(|error| anyhow!("{error}"))?;
    Ok(decisions)
}

/// The stage `prepare` is left out: most of it is waiting for the robot and for perception.
fn decided(decision: &v1::Decision, at: Duration) -> Decided {
    let stages = decision.stages.iter();
    let planning = stages.filter(|stage| stage.stage != "prepare");
    Decided {
        at,
        took: Duration::from_nanos(planning.map(|stage| stage.duration_ns).sum()),
        is_degraded: !decision.degraded.is_empty(),
    }
}

/// Packs one container in automatic mode, then has an empty one brought; gives the items that were packed.
///
/// # Errors
/// Where the automatic mode failed, or what the planner acknowledged is not what lies in the container.
pub fn pack_container(
    cell: &CellClient,
    session_id: &str,
    objects: &[&str],
) -> Result<BTreeSet<String>> {
    cell.patiently(|cell| cell.begin(session_id, objects, true))?;
    let until = Instant::now() + CONTAINER_LIMIT;
    let session = loop {
        let session = cell.patiently(CellClient::session)?;
        if session.end() != SessionEnd::Unspecified {
            break session;
        }
        ensure!(
            Instant::now() < until,
            "{session_id} does not come to an end"
        );
        std::thread::sleep(LOOK);
    };
    ensure!(
        session.end() != SessionEnd::Failed,
        "{session_id} failed: {}",
        session.failure
    );
    cell.patiently(CellClient::check_consistent)
        .with_context(|| session_id.to_owned())?;
    let is_packed = |item: &&v1::SessionItem| item.state() == ItemState::Packed;
    let packed = session.items.iter().filter(is_packed);
    let packed = packed.map(|item| item.item_id.clone()).collect();
    cell.patiently(CellClient::renew)
        .context("no new container")?;
    Ok(packed)
}
