//! Automatic packing, container after container.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow, ensure};
use ppnpack_service::sync::lock;
use ppnpack_wire::keys::{Stream, every_cell};
use ppnpack_wire::v1::{self, InspectionKind, ItemState, SessionEnd};
use ppnpack_wire::{MAX_MESSAGE_BYTES, decode};
use zenoh::Wait;

use crate::cell::CellClient;
use crate::mix::Kind;
use crate::stack::Stack;

/// The time between two looks at a session.
const LOOK: Duration = Duration::from_millis(200);

/// The maximum time for one container.
const CONTAINER_LIMIT: Duration = Duration::from_secs(600);

#[derive(Debug, Clone, Copy)]
pub(crate) struct Decided {
    pub(crate) at: Duration,
    /// The time from the heightmap to the decision on disk.
    pub(crate) took: Duration,
    /// Whether it was planned in another way than was asked for.
    pub(crate) is_degraded: bool,
}

/// Notes every decision of the stack, with the time since `start`.
pub(crate) fn note_decisions(stack: &Stack, start: Instant) -> Result<Arc<Mutex<Vec<Decided>>>> {
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
            lock(&noted).push(decided(&decision, start.elapsed()));
        })
        .background()
        .wait()
        .map_err(|error| anyhow!("{error}"))?;
    Ok(decisions)
}

/// Notes a decision, without the stage `prepare`, which mostly waits for robot and perception.
fn decided(decision: &v1::Decision, at: Duration) -> Decided {
    let stages = decision.stages.iter();
    let planning = stages.filter(|stage| stage.stage != "prepare");
    Decided {
        at,
        took: Duration::from_nanos(planning.map(|stage| stage.duration_ns).sum()),
        is_degraded: !decision.degraded.is_empty(),
    }
}

/// The end of one container, by the planner.
#[derive(Debug, Clone, Default)]
pub(crate) struct Container {
    /// The items that lie in it.
    pub(crate) packed: BTreeSet<String>,
    /// The items that were placed, and that the inspection did not find.
    pub(crate) missing: BTreeSet<String>,
    /// The items that left the cell.
    pub(crate) lost: BTreeSet<String>,
    /// The number of items that were set aside, as nothing was possible with them.
    pub(crate) set_aside: usize,
    /// The number of failures of the automatic mode that were acknowledged.
    pub(crate) acknowledged: usize,
}

impl Container {
    /// The end by the items of a session.
    pub(crate) fn of(session: &v1::Session) -> Self {
        let of = |is_one: &dyn Fn(&v1::SessionItem) -> bool| -> BTreeSet<String> {
            let items = session.items.iter().filter(|item| is_one(item));
            items.map(|item| item.item_id.clone()).collect()
        };
        let is = |item: &v1::SessionItem, state: ItemState| item.state() == state;
        Self {
            packed: of(&|item| is(item, ItemState::Packed)),
            missing: of(&|item| is(item, ItemState::Gone) && is_missing(item)),
            lost: of(&|item| is(item, ItemState::Gone) && !is_missing(item)),
            set_aside: of(&|item| is(item, ItemState::SetAside)).len(),
            ..Self::default()
        }
    }

    /// All that was placed into it.
    pub(crate) fn placed(&self) -> BTreeSet<String> {
        self.packed.union(&self.missing).cloned().collect()
    }

    fn gone(&self) -> usize {
        self.missing.len() + self.lost.len()
    }
}

/// Whether an item was looked for in the container, and was not there.
fn is_missing(item: &v1::SessionItem) -> bool {
    let inspection = item.inspection.as_ref();
    inspection.is_some_and(|inspection| inspection.kind() == InspectionKind::Missing)
}

/// A cell that is packed again and again.
pub(crate) struct Packer {
    cell: CellClient,
    kind: Kind,
}

impl Packer {
    pub(crate) fn new(cell: CellClient, kind: Kind) -> Self {
        Self { cell, kind }
    }

    /// Packs one container in automatic mode, then has an empty one brought.
    ///
    /// # Errors
    /// Where the automatic mode failed without an item that is gone, or in a cell where none may
    /// be, or the container holds other items than the planner acknowledged.
    pub(crate) fn pack(&self, session_id: &str, objects: &[&str]) -> Result<Container> {
        let cell = &self.cell;
        cell.patiently(|cell| cell.begin(session_id, objects, true))?;
        let container = self
            .until_the_end()
            .with_context(|| session_id.to_owned())?;
        cell.patiently(CellClient::check_consistent)
            .with_context(|| session_id.to_owned())?;
        cell.patiently(CellClient::renew)
            .context("no new container")?;
        Ok(container)
    }

    fn until_the_end(&self) -> Result<Container> {
        let until = Instant::now() + CONTAINER_LIMIT;
        let mut acknowledged = 0;
        let mut gone = 0;
        loop {
            ensure!(Instant::now() < until, "it does not come to an end");
            let session = self.cell.patiently(CellClient::session)?;
            let container = Container::of(&session);
            match session.end() {
                SessionEnd::Failed => {
                    let is_allowed = self.kind.may_lose() && container.gone() > gone;
                    ensure!(is_allowed, "it failed: {}", session.failure);
                    gone = container.gone();
                    acknowledged += 1;
                    self.cell.patiently(CellClient::check_consistent)?;
                    self.cell.patiently(CellClient::acknowledge)?;
                }
                SessionEnd::Unspecified => {}
                _ => {
                    return Ok(Container {
                        acknowledged,
                        ..container
                    });
                }
            }
            std::thread::sleep(LOOK);
        }
    }
}
