//! People: they hold the cell, reach into it, look, and let it go on. They do what docs/protocol.md
//! and the texts of the software ask of them, and no more.

use ppnpack_protocol::ledger::{BRIDGE, Hold, RenewalVerdict};
use ppnpack_wire::v1;

use crate::bridge::item_id;
use crate::configuration::{Configuration, Fault, Sabotage};
use crate::planner;
use crate::shared::Shared;
use crate::world::{Whereabouts, World, needs};

/// Somebody, and what they asked for last: each request may arrive late, or never, or once more.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Person {
    /// Whether they hold the cell, by what they know: their hold was answered, and they did not ask
    /// that it ends.
    pub(crate) holds: bool,
    pub(crate) hold: String,
    pub(crate) ended: Vec<String>,
    /// The failure that they acknowledged.
    pub(crate) failure: String,
}

impl World {
    /// Whether somebody relies on that nothing begins.
    pub(crate) fn is_held_by_somebody(&self) -> bool {
        self.people.iter().any(|person| person.holds)
    }

    fn person(&self, person: u8) -> Option<&Person> {
        self.people.get(usize::from(person))
    }

    fn person_mut(&mut self, person: u8) -> Option<&mut Person> {
        self.people.get_mut(usize::from(person))
    }

    /// Somebody holds the cell, and gets the answer.
    pub(crate) fn hold(&mut self, person: u8, configuration: &Configuration) -> Option<()> {
        needs(self.bridge.is_up && !self.person(person)?.holds)?;
        let id = format!("h{}", self.happened(Fault::Hold));
        self.count(Fault::Hold, configuration)?;
        let own = self.person_mut(person)?;
        own.holds = true;
        own.hold.clone_from(&id);
        self.note_hold(&id, configuration);
        Some(())
    }

    /// The same request once more, which may be late.
    pub(crate) fn hold_again(&mut self, person: u8, configuration: &Configuration) -> Option<()> {
        let id = self.person(person)?.hold.clone();
        let holds = &self.bridge.ledger.head().holds;
        let is_known = holds.iter().any(|hold| hold.id == id);
        needs(self.bridge.is_up && !id.is_empty() && !is_known)?;
        self.count(Fault::TimeOut, configuration)?;
        self.note_hold(&id, configuration);
        Some(())
    }

    fn note_hold(&mut self, id: &str, configuration: &Configuration) {
        let ledger = &self.bridge.ledger;
        if ledger.is_held() && configuration.lacks(Sabotage::FirstHoldStays) {
            return;
        }
        let change = ledger.hold(Hold::new(id, "", ""));
        self.bridge.ledger.apply(change);
    }

    pub(crate) fn take_out(&mut self, item: u8, configuration: &Configuration) -> Option<()> {
        let ledger = &self.bridge.ledger;
        let is_held = self.bridge.is_up && self.is_held_by_somebody();
        let stands = ledger.under_way().is_none() && self.motion.is_none();
        let item = usize::from(item);
        needs(is_held && stands && self.items.get(item)? == &Whereabouts::Inside)?;
        self.count(Fault::Hand, configuration)?;
        let change = self.bridge.ledger.change_by_hand(&[item_id(item)]);
        *self.items.get_mut(item)? = Whereabouts::Elsewhere;
        self.bridge.ledger.apply(change);
        Some(())
    }

    /// Somebody asks that their own hold ends, those that nobody relies on, such as of a backup,
    /// and those of the software: for these they wait until the robot stands and nobody else holds
    /// the cell, and say what the container holds. From now on they rely on nothing.
    pub(crate) fn resume(&mut self, person: u8) -> Option<()> {
        let mut is_changed = self.person(person)?.holds;
        needs(self.bridge.is_up)?;
        let ledger = &self.bridge.ledger;
        let stands = self.motion.is_none() && ledger.under_way().is_none();
        let others = self.people.iter().enumerate();
        let others = others.filter(|(other, it)| *other != usize::from(person) && it.holds);
        let relied_on: Vec<&str> = others.map(|(_, other)| other.hold.as_str()).collect();
        let has_looked = stands && relied_on.is_empty();
        let seen = ledger
            .head()
            .holds
            .iter()
            .filter(|hold| match hold.holder == BRIDGE {
                true => has_looked,
                false => !relied_on.contains(&hold.id.as_str()),
            });
        let seen: Vec<String> = seen.map(|hold| hold.id.clone()).collect();
        if has_looked && self.bridge.ledger.is_held() {
            let missing = self.missing_bodies();
            if !missing.is_empty() {
                let change = self.bridge.ledger.change_by_hand(&missing);
                self.bridge.ledger.apply(change);
                is_changed = true;
            }
        }
        let own = self.person_mut(person)?;
        own.holds = false;
        if !seen.is_empty() && seen != own.ended {
            own.ended = seen;
            is_changed = true;
        }
        is_changed.then_some(())
    }

    /// What the bridge knows to lie in the container, and does not.
    fn missing_bodies(&self) -> Vec<String> {
        let bodies = self.bridge.ledger.head().bodies.iter();
        let missing = bodies.filter(|body| {
            let item = self.item_no(&body.item_id);
            let whereabouts = item.and_then(|item| self.items.get(usize::from(item)));
            whereabouts != Some(&Whereabouts::Inside)
        });
        missing.map(|body| body.item_id.clone()).collect()
    }

    /// The request arrives: in time, late, or once more.
    pub(crate) fn resumed(&mut self, person: u8, configuration: &Configuration) -> Option<()> {
        let mut ended = self.person(person)?.ended.clone();
        let ledger = &self.bridge.ledger;
        needs(self.bridge.is_up && !ended.is_empty() && ledger.is_held())?;
        if configuration.lacks(Sabotage::AnyResume) {
            let all = ledger.head().holds.iter();
            ended = all.map(|hold| hold.id.clone()).collect();
        }
        let mut change = ledger.resume(&ended, 0)?;
        if configuration.lacks(Sabotage::SameStateAfterHold) {
            change.head.state_number = ledger.head().state_number;
        }
        self.bridge.ledger.apply(change);
        Some(())
    }

    /// What was decided before begins no more, as the planner has the bridge count the state up;
    /// `None` where it cannot.
    fn void_decisions(&mut self, configuration: &Configuration) -> Option<u64> {
        let ledger = &self.bridge.ledger;
        if configuration.lacks(Sabotage::NothingIsVoided) {
            return Some(0);
        }
        needs(self.bridge.is_up && ledger.under_way().is_none())?;
        let change = ledger.change_by_hand(&[]);
        self.bridge.ledger.apply(change);
        Some(self.bridge.ledger.head().state_number)
    }

    /// Somebody sees that the session has failed, and asks that it goes on. Who drives it by a
    /// controller looks, and goes on.
    pub(crate) fn acknowledge(&mut self, person: u8, configuration: &Configuration) -> Option<()> {
        needs(self.planner.is_up)?;
        if !self.controllers.is_empty() {
            needs(self.must_look)?;
            return self.look(configuration);
        }
        let failure = self.planner.session.failure_id()?;
        let own = self.person_mut(person)?;
        needs(own.failure != failure)?;
        own.failure = failure;
        Some(())
    }

    /// The request arrives: in time, late, or once more. Who asked for it looks until it does.
    pub(crate) fn acknowledged(&mut self, person: u8, configuration: &Configuration) -> Option<()> {
        let mut failure = self.person(person)?.failure.clone();
        let session = &self.planner.session;
        let failed = session.failure_id()?;
        needs(self.planner.is_up && !failure.is_empty())?;
        if failure == failed {
            self.look(configuration)?;
        } else if configuration.lacks(Sabotage::AnyFailure) {
            failure = failed;
        }
        self.planner.session.set_automatic(true, &failure).ok()
    }

    /// Somebody looks where everything is, and takes out of the session what does not wait any
    /// more.
    fn look(&mut self, configuration: &Configuration) -> Option<()> {
        needs(self.motion.is_none())?;
        let voided = self.void_decisions(configuration)?;
        let gone = self.items_not_waiting();
        let session = &mut self.planner.session;
        for item in gone {
            if session.waiting(&item).is_ok() {
                session.withdraw(&item).ok()?;
            }
        }
        session.goes_on_at("", Some(voided));
        self.must_look = false;
        Some(())
    }

    fn items_not_waiting(&self) -> Vec<String> {
        let items = self.items.iter().enumerate();
        let gone = items.filter(|(_, whereabouts)| **whereabouts != Whereabouts::Waiting);
        gone.map(|(item, _)| item_id(item)).collect()
    }

    /// Where the planner knows nothing, somebody announces what still waits.
    pub(crate) fn begin_anew(&mut self, configuration: &Configuration) -> Option<()> {
        let is_lost = self.planner.session.id().is_empty();
        needs(self.planner.is_up && is_lost && self.motion.is_none())?;
        self.begin(0, configuration)
    }

    /// Where an empty container was brought, a session begins with it.
    pub(crate) fn begin_next(&mut self, configuration: &Configuration) -> Option<()> {
        let state_number = self.renewed_at()?;
        let is_begun = self.planner.session.least_state_number("") >= state_number;
        needs(self.planner.is_up && !is_begun && self.planner.session.pending().is_none())?;
        self.begin(state_number, configuration)
    }

    fn begin(&mut self, least_state_number: u64, configuration: &Configuration) -> Option<()> {
        let least_state_number = match self.planner.session.is_settled() {
            true => least_state_number,
            false => least_state_number.max(self.void_decisions(configuration)?),
        };
        let is_automatic = self.controllers.is_empty();
        let next = planner::begun(self.sessions, is_automatic, least_state_number, &self.items);
        let next = self.planner.session.followed_by(next, false).ok()?;
        self.planner.session = Shared::new(next);
        self.sessions += 1;
        self.must_look = false;
        for decided in &mut self.decided {
            decided.settled.get_or_insert(v1::OutcomeKind::Unspecified);
        }
        Some(())
    }

    /// The state after the last renewal.
    fn renewed_at(&self) -> Option<u64> {
        let last = self.happened(Fault::Renew).checked_sub(1)?;
        match self.bridge.ledger.judge_renewal(&format!("r{last}")) {
            RenewalVerdict::Done(state_number) => Some(state_number),
            _ => None,
        }
    }
}
