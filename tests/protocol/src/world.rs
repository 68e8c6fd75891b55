//! A cell and all who work with it, at one moment.

use std::collections::BTreeSet;
use std::sync::Arc;

use ppnpack_protocol::ledger::{Holds, Ledger};
use ppnpack_protocol::placing::Finding;
use ppnpack_protocol::session::Session;
use ppnpack_wire::v1;

use crate::configuration::{Configuration, Fault};
use crate::driver::Driver;
use crate::people::Person;
use crate::shared::Shared;
use crate::{Action, planner};

const FIRST_STATE: u64 = 1_000;

/// States that nobody ever had are so far apart.
const FRESH_STEP: u64 = 1_000;

/// The items that lie in the container, a bit each.
pub(crate) type Content = u8;

/// A promise that was broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Broken {
    /// A placement was begun twice.
    BegunTwice,
    /// A placement was begun for an item that does not wait any more.
    ItemPlacedTwice,
    /// A placement was begun that had been settled, but not as unknown, or given up.
    BegunAfterItWasSettled,
    /// A placement was begun on another content than the one that its picture showed.
    OtherContent,
    /// A placement was begun while somebody held the cell.
    BegunWhileHeld,
    /// Something was planned by itself after an item was lost or unknown and before anybody looked.
    NobodyLooked,
    /// A session says that an item was packed which was not.
    NotPacked,
    /// A session says that an item was not placed which was, or which the robot still has.
    WasPlaced,
    /// All faults have ended, and the packing does not go on.
    Stuck,
    /// Two ends of the protocol did not understand each other.
    NotUnderstood,
}

/// Where an item really is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Whereabouts {
    Waiting,
    Inside,
    /// Lost in the cell, taken out, or carried off with the container.
    Elsewhere,
}

/// What is known of a decision by who sees everything.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Decided {
    pub(crate) decision: Arc<v1::Decision>,
    pub(crate) item: u8,
    pub(crate) shown: Content,
    /// Whether the bridge was asked for it: the request may still arrive.
    pub(crate) is_sent: bool,
    pub(crate) begun: u8,
    /// As what it counts for the planner: settled, or given up.
    pub(crate) settled: Option<v1::OutcomeKind>,
}

/// The planner's process and its disk, which say the same.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Planner {
    pub(crate) is_up: bool,
    pub(crate) session: Shared<Session>,
    pub(crate) backup: Option<Shared<Session>>,
    /// Carries decisions out in automatic mode.
    pub(crate) driver: Driver,
}

/// What the robot's thread was told, or what came of it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Job {
    Place(usize),
    Placed(Finding),
    Renew,
    Renewed,
}

/// The bridge's process and its disk, which say the same.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Bridge {
    pub(crate) is_up: bool,
    pub(crate) ledger: Shared<Ledger>,
    pub(crate) backup: Option<Shared<Ledger>>,
    pub(crate) job: Option<Job>,
}

/// A motion of the robot, which goes on whether anybody watches it or not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Motion {
    Place(usize),
    Renew,
}

/// A cell and all who work with it.
#[derive(Debug, Clone, PartialEq)]
pub struct World {
    pub(crate) planner: Planner,
    pub(crate) controllers: Vec<Driver>,
    pub(crate) people: Vec<Person>,
    pub(crate) bridge: Bridge,
    pub(crate) motion: Option<Motion>,
    pub(crate) items: Vec<Whereabouts>,
    pub(crate) decided: Vec<Decided>,
    /// Every picture that was made: the state that it is said to show, and what it shows.
    pub(crate) pictures: BTreeSet<(u64, Content)>,
    /// Outcomes that were published, and may be heard at any time.
    pub(crate) published: Vec<Arc<v1::Outcome>>,
    /// A state that no cell ever had.
    pub(crate) fresh: u64,
    /// An item was lost or unknown since somebody looked.
    pub(crate) must_look: bool,
    /// Sessions that were begun.
    pub(crate) sessions: u8,
    pub(crate) happened: [u8; Fault::COUNT],
    /// What broke a promise first.
    pub(crate) broken: Option<Broken>,
}

impl World {
    /// The beginning: an empty container, and all items announced.
    pub fn new(configuration: &Configuration) -> Self {
        let is_automatic = configuration.controllers == 0;
        let items = vec![Whereabouts::Waiting; usize::from(configuration.items)];
        let mut world = Self {
            planner: Planner {
                is_up: true,
                session: Shared::new(planner::begun(0, is_automatic, FIRST_STATE, &items)),
                backup: None,
                driver: Driver::default(),
            },
            controllers: vec![Driver::default(); usize::from(configuration.controllers)],
            people: vec![Person::default(); usize::from(configuration.people)],
            bridge: Bridge {
                is_up: true,
                ledger: Shared::new(begun_ledger()),
                backup: None,
                job: None,
            },
            motion: None,
            items,
            decided: Vec::new(),
            pictures: BTreeSet::new(),
            published: Vec::new(),
            fresh: FIRST_STATE,
            must_look: false,
            sessions: 1,
            happened: [0; Fault::COUNT],
            broken: None,
        };
        world.take_pictures();
        world
    }

    pub(crate) fn break_promise(&mut self, broken: Broken) {
        self.broken.get_or_insert(broken);
    }

    /// The same world after something happened; `None` where that cannot happen in it.
    pub fn after(&self, action: Action, configuration: &Configuration) -> Option<Self> {
        let mut next = self.clone();
        next.happen(action, configuration)?;
        next.take_pictures();
        next.forget(configuration);
        Some(next)
    }

    pub(crate) fn content(&self) -> Content {
        let items = self.items.iter().enumerate();
        let inside = items.filter(|(_, whereabouts)| **whereabouts == Whereabouts::Inside);
        inside.fold(0, |content, (item, _)| content | 1 << item)
    }

    /// The camera shows the cell as the bridge numbers it, but while the robot does what the bridge
    /// told it, or what it did is not written down. A robot whose bridge was killed may move in the
    /// picture.
    fn take_pictures(&mut self) {
        if self.bridge.is_up && self.bridge.job.is_none() {
            let picture = (self.bridge.ledger.head().state_number, self.content());
            self.pictures.insert(picture);
        }
    }

    /// Forgets what nobody can use any more: pictures after the last decision, and backups after
    /// the last restoring.
    fn forget(&mut self, configuration: &Configuration) {
        if self.decided.len() >= usize::from(configuration.decisions) {
            self.pictures.clear();
        }
        if self.happened(Fault::Restore) >= configuration.most(Fault::Restore) {
            (self.planner.backup, self.bridge.backup) = (None, None);
        }
    }

    pub(crate) fn fresh_state(&mut self) -> u64 {
        self.fresh += FRESH_STEP;
        self.fresh
    }

    /// Counts what may only happen so often; `None` where it may not any more.
    pub(crate) fn count(&mut self, fault: Fault, configuration: &Configuration) -> Option<()> {
        let happened = self.happened.get_mut(fault as usize)?;
        needs(*happened < configuration.most(fault))?;
        *happened += 1;
        Some(())
    }

    pub(crate) fn happened(&self, fault: Fault) -> u8 {
        self.happened
            .get(fault as usize)
            .copied()
            .unwrap_or_default()
    }

    pub(crate) fn decision_no(&self, decision_id: &str) -> Option<usize> {
        let mut decided = self.decided.iter();
        decided.position(|decided| decided.decision.decision_id == decision_id)
    }
}

/// Goes on where something is so; what needs it cannot happen otherwise.
pub(crate) fn needs(is_so: bool) -> Option<()> {
    is_so.then_some(())
}

/// The ledger of a cell that somebody looked at when it was started for the first time.
fn begun_ledger() -> Ledger {
    let mut ledger = Ledger::beginning_at(FIRST_STATE - 1);
    if let Some(held) = ledger.recover(false) {
        ledger.apply(held);
    }
    ledger.apply(ledger.held_by(Holds::default(), 0));
    ledger
}
