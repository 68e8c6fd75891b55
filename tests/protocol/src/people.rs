//! People: they hold the cell, reach into it, look, and let it go on. They do what docs/protocol.md and the texts of the software
//! ask of them, and no more.

use ppnpack_protocol::ledger::RenewalVerdict;
use ppnpack_wire::v1;

use crate::bridge::item_id;
use crate::configuration::{Configuration, Fault, Sabotage};
use crate::planner;
use crate::shared::Shared;
use crate::world::{Whereabouts, World};

/// Why somebody holds the cell.
const REASON: &str = "a door is open";

impl World {
    pub(crate) fn hold(&mut self, configuration: &Configuration) -> Option<()> {
        if !self.bridge.is_up || self.bridge.ledger.head().hold.is_some() {
            return None;
        }
        self.count(Fault::Hold, configuration)?;
        let change = self.bridge.ledger.hold(REASON);
        self.bridge.ledger.apply(change);
        Some(())
    }

    pub(crate) fn take_out(&mut self, item: u8, configuration: &Configuration) -> Option<()> {
        let ledger = &self.bridge.ledger;
        let is_held = self.bridge.is_up && ledger.head().hold.is_some();
        let stands = ledger.under_way().is_none() && self.motion.is_none();
        let item = usize::from(item);
        if !is_held || !stands || self.items.get(item)? != &Whereabouts::Inside {
            return None;
        }
        self.count(Fault::Hand, configuration)?;
        let change = self.bridge.ledger.change_by_hand(&[item_id(item)]);
        *self.items.get_mut(item)? = Whereabouts::Elsewhere;
        self.bridge.ledger.apply(change);
        Some(())
    }

    /// Who held the cell lets it go on. Where the software held it, somebody waits until the robot stands, and says what the
    /// container holds.
    pub(crate) fn resume(&mut self, configuration: &Configuration) -> Option<()> {
        let reason = self.bridge.ledger.head().hold.clone()?;
        if !self.bridge.is_up {
            return None;
        }
        if reason != REASON {
            if self.motion.is_some() || self.bridge.ledger.under_way().is_some() {
                return None;
            }
            let bodies = self.bridge.ledger.head().bodies.iter();
            let missing = bodies.filter(|body| {
                let item = self.item_no(&body.item_id);
                let whereabouts = item.and_then(|item| self.items.get(usize::from(item)));
                whereabouts != Some(&Whereabouts::Inside)
            });
            let missing: Vec<String> = missing.map(|body| body.item_id.clone()).collect();
            let change = self.bridge.ledger.change_by_hand(&missing);
            self.bridge.ledger.apply(change);
        }
        let mut change = self.bridge.ledger.resume();
        if configuration.lacks(Sabotage::SameStateAfterHold) {
            change.head.state_number = self.bridge.ledger.head().state_number;
        }
        self.bridge.ledger.apply(change);
        Some(())
    }

    /// What was decided before begins no more, as the planner has the bridge count the state up; `None` where it cannot.
    fn void_decisions(&mut self, configuration: &Configuration) -> Option<u64> {
        let ledger = &self.bridge.ledger;
        if configuration.lacks(Sabotage::NothingIsVoided) {
            return Some(0);
        }
        if !self.bridge.is_up || ledger.under_way().is_some() {
            return None;
        }
        let change = ledger.change_by_hand(&[]);
        self.bridge.ledger.apply(change);
        Some(self.bridge.ledger.head().state_number)
    }

    /// Somebody looks where everything is, takes out of the session what does not wait any more, and switches on again.
    pub(crate) fn acknowledge(&mut self, configuration: &Configuration) -> Option<()> {
        let session = &self.planner.session;
        let is_due = match self.controllers.is_empty() {
            true => session.has_failed(),
            false => self.must_look,
        };
        if !self.planner.is_up || !is_due || self.motion.is_some() {
            return None;
        }
        let voided = self.void_decisions(configuration)?;
        let gone = self.items_not_waiting();
        let session = &mut self.planner.session;
        for item in gone {
            if session.waiting(&item).is_ok() {
                session.withdraw(&item).ok()?;
            }
        }
        session.goes_on_at("", Some(voided));
        if session.is_automatic() {
            session.set_automatic(true).ok()?;
        }
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
        if !self.planner.is_up || !is_lost || self.motion.is_some() {
            return None;
        }
        self.begin(0, configuration)
    }

    /// Where an empty container was brought, a session begins with it.
    pub(crate) fn begin_next(&mut self, configuration: &Configuration) -> Option<()> {
        let state_number = self.renewed_at()?;
        let is_begun = self.planner.session.least_state_number("") >= state_number;
        if !self.planner.is_up || is_begun || self.planner.session.pending().is_some() {
            return None;
        }
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
