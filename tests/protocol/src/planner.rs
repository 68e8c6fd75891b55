//! The planner: its session, and the automatic mode.

use std::sync::Arc;

use nalgebra::Isometry3;
use ppnpack_packing::kernel::grid::Units;
use ppnpack_packing::kernel::placement::{Placement, RestingPlacement};
use ppnpack_protocol::session::{End, FROM_BACKUP, Session, open_container};
use ppnpack_wire::convert;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::v1::{self, OutcomeKind};

use crate::action::Who;
use crate::bridge::item_id;
use crate::configuration::{Configuration, Fault, Sabotage};
use crate::driver::{Driver, Settled};
use crate::shared::Shared;
use crate::world::{Broken, Decided, Motion, Whereabouts, World, needs};

/// A session in which all items are announced that wait.
pub(crate) fn begun(
    number: u8,
    is_automatic: bool,
    least_state_number: u64,
    items: &[Whereabouts],
) -> Session {
    let id = format!("s{number}");
    let container = open_container(String::new(), Vec::new(), least_state_number);
    let mut session = Session::begin(id, vec![container], is_automatic, 0);
    let waiting = items.iter().enumerate();
    let waiting = waiting.filter(|(_, whereabouts)| **whereabouts == Whereabouts::Waiting);
    let announced = waiting.map(|(item, _)| v1::SessionItem {
        item_id: item_id(item),
        object: "box".to_owned(),
        shape: ItemId::of(&v1::Item::default()).to_bytes(),
        ..v1::SessionItem::default()
    });
    // A session that has just begun takes any item.
    session.announce(announced.collect()).ok();
    session
}

impl World {
    /// Whether the planner goes on by itself.
    fn is_on(&self) -> bool {
        let session = &self.planner.session;
        let has_more = session.is_automatic() && !session.has_ended();
        self.planner.is_up && has_more && !session.items().is_empty()
    }

    pub(crate) fn decide(
        &mut self,
        who: Who,
        state_number: u64,
        shown: u8,
        configuration: &Configuration,
    ) -> Option<()> {
        let is_idle = match who {
            Who::Planner => self.is_on() && !self.planner.driver.is_held,
            // A controller stops where somebody has to look first.
            Who::Controller(_) => !self.must_look,
        };
        let driver = self.driver(who)?;
        let is_free = driver.call.is_none() && driver.outcome.is_none();
        let is_free = is_free && (who == Who::Planner || driver.decision.is_none());
        let session = &self.planner.session;
        let may = self.planner.is_up && is_idle && is_free && session.pending().is_none();
        let has_room = self.decided.len() < usize::from(configuration.decisions);
        needs(may && has_room && state_number >= session.least_state_number(""))?;
        let item = session.buffer(1).next()?;
        let item_id = item.item_id.clone();
        let number = self.decided.len();
        let decision = v1::Decision {
            decision_id: format!("d{number}"),
            session_id: session.id().to_owned(),
            step: session.step(),
            object: item.object.clone(),
            placement: Some(convert::placement::write_resting(&somewhere())),
            container_from_item: Some(convert::pose::write(&Isometry3::identity())),
            state_number,
            item_id,
            ..v1::Decision::default()
        };
        let item = self.item_no(&decision.item_id)?;
        self.planner.session.decide(decision.clone()).ok()?;
        if who == Who::Planner && self.must_look {
            self.break_promise(Broken::NobodyLooked);
        }
        self.decided.push(Decided {
            decision: Arc::new(decision),
            item,
            shown,
            is_sent: false,
            begun: 0,
            settled: None,
        });
        if let Who::Controller(_) = who {
            let driver = self.driver_mut(who)?;
            *driver = driver.going_on_with(Some(number));
        }
        Some(())
    }

    pub(crate) fn take_up(&mut self, controller: u8) -> Option<()> {
        let who = Who::Controller(controller);
        let is_free = self.driver(who)?.decision.is_none();
        needs(self.planner.is_up && is_free && !self.must_look)?;
        let pending = self.planner.session.pending()?;
        let decision = self.decision_no(&pending.decision_id)?;
        let driver = self.driver_mut(who)?;
        *driver = driver.going_on_with(Some(decision));
        Some(())
    }

    pub(crate) fn finish(&mut self) -> Option<()> {
        let session = &self.planner.session;
        let waits = session.pending().is_some() || session.buffer(1).next().is_some();
        needs(self.is_on() && !waits && self.planner.driver.call.is_none())?;
        let end = session.end_of_items();
        self.planner.session.end(end);
        Some(())
    }

    /// What a driver asks next; the planner's pursues what its session has pending.
    pub(crate) fn ask(&mut self, who: Who) -> Option<()> {
        if who == Who::Planner {
            needs(self.is_on())?;
            let pending = self.planner.session.pending();
            let pending = pending.and_then(|decision| self.decision_no(&decision.decision_id));
            let driver = &mut self.planner.driver;
            if driver.decision != pending && driver.call.is_none() {
                *driver = driver.going_on_with(pending);
            }
        }
        let ask = self.driver(who)?.next_ask()?;
        self.send(who, ask)
    }

    pub(crate) fn receive(&mut self, who: Who) -> Option<()> {
        let driver = self.driver(who)?;
        let decision = driver.decision.and_then(|number| self.decided.get(number));
        let decision = decision.map(|decided| decided.decision.clone());
        let gives_up = self.driver_mut(who)?.receive(decision.as_deref())?;
        if gives_up {
            // The bridge refuses only what it cannot understand or contradicts what it was asked
            // before.
            self.break_promise(Broken::NotUnderstood);
            self.planner.session.end(End::Failed("refused".to_owned()));
        }
        if who == Who::Planner
            && let Some(Settled(outcome)) = self.planner.driver.outcome.take()
        {
            self.settle(&outcome);
        }
        Some(())
    }

    pub(crate) fn give_up(&mut self, who: Who, configuration: &Configuration) -> Option<()> {
        self.driver(who)?.call.as_ref()?;
        self.count(Fault::TimeOut, configuration)?;
        self.driver_mut(who)?.call = None;
        Some(())
    }

    pub(crate) fn hear(&mut self, decision: u8) -> Option<()> {
        let decided = self.decided.get(usize::from(decision))?;
        let id = &decided.decision.decision_id;
        let pending = self.planner.session.pending()?;
        // The planner does one thing at a time: while it asks the bridge it hears nothing.
        needs(self.is_on() && pending.decision_id == *id && self.planner.driver.call.is_none())?;
        let mut published = self.published.iter();
        let outcome = published
            .find(|outcome| outcome.placement_id == *id)?
            .clone();
        self.settle(&outcome);
        Some(())
    }

    pub(crate) fn report(&mut self, controller: u8) -> Option<()> {
        needs(self.planner.is_up)?;
        let driver = self.driver_mut(Who::Controller(controller))?;
        let Settled(outcome) = driver.outcome.take()?;
        *driver = driver.going_on_with(None);
        self.settle(&outcome);
        Some(())
    }

    /// The session takes an outcome, which it may have had before.
    fn settle(&mut self, outcome: &v1::Outcome) {
        let id = &outcome.placement_id;
        let was_pending = self.is_pending(id);
        if self.planner.session.report(id, outcome).is_err() || !was_pending {
            return;
        }
        self.planner.driver = self.planner.driver.going_on_with(None);
        let kind = outcome.kind();
        let number = self.decision_no(id);
        let Some(decided) = number.and_then(|number| self.decided.get_mut(number)) else {
            return;
        };
        decided.settled = Some(kind);
        let item = usize::from(decided.item);
        let waits = self.items.get(item) == Some(&Whereabouts::Waiting);
        if kind == OutcomeKind::Placed && waits {
            self.break_promise(Broken::NotPacked);
        }
        let moves = number.is_some_and(|number| self.motion == Some(Motion::Place(number)));
        if kind == OutcomeKind::NotPlaced && (!waits || moves) {
            self.break_promise(Broken::WasPlaced);
        }
        if matches!(kind, OutcomeKind::Lost | OutcomeKind::Unknown) {
            self.must_look = true;
        }
    }

    fn is_pending(&self, decision_id: &str) -> bool {
        let pending = self.planner.session.pending();
        pending.is_some_and(|pending| pending.decision_id == decision_id)
    }

    pub(crate) fn kill_planner(&mut self, configuration: &Configuration) -> Option<()> {
        needs(self.planner.is_up)?;
        self.count(Fault::KillPlanner, configuration)?;
        self.planner.is_up = false;
        self.planner.driver = Driver::default();
        Some(())
    }

    pub(crate) fn start_planner(&mut self) -> Option<()> {
        needs(!self.planner.is_up)?;
        self.planner.is_up = true;
        Some(())
    }

    pub(crate) fn lose_store(&mut self, configuration: &Configuration) -> Option<()> {
        needs(!self.planner.is_up && *self.planner.session != Session::default())?;
        self.count(Fault::LoseStore, configuration)?;
        self.planner.session = Shared::new(Session::default());
        Some(())
    }

    pub(crate) fn back_up_store(&mut self, configuration: &Configuration) -> Option<()> {
        let is_of_use = configuration.most(Fault::Restore) > 0;
        let is_known = self.planner.backup.as_ref() == Some(&self.planner.session);
        needs(is_of_use && !is_known && self.happened(Fault::Restore) == 0)?;
        self.planner.backup = Some(self.planner.session.clone());
        Some(())
    }

    pub(crate) fn restore_store(&mut self, configuration: &Configuration) -> Option<()> {
        needs(!self.planner.is_up)?;
        let backup = self.planner.backup.clone()?;
        self.count(Fault::Restore, configuration)?;
        self.planner.session = backup;
        if !configuration.lacks(Sabotage::RestoredGoesOn) {
            let pending = self.planner.session.pending();
            let pending = pending.and_then(|decision| self.decision_no(&decision.decision_id));
            let failures = self.fresh_state();
            self.planner.session.restored_after(failures, FROM_BACKUP);
            if let Some(decided) = pending.and_then(|number| self.decided.get_mut(number)) {
                decided.settled.get_or_insert(OutcomeKind::Unknown);
            }
        }
        self.must_look = true;
        Some(())
    }

    pub(crate) fn item_no(&self, id: &str) -> Option<u8> {
        let position = (0..self.items.len()).position(|item| item_id(item) == id)?;
        u8::try_from(position).ok()
    }

    pub(crate) fn driver(&self, who: Who) -> Option<&Driver> {
        match who {
            Who::Planner => Some(&self.planner.driver),
            Who::Controller(number) => self.controllers.get(usize::from(number)),
        }
    }

    pub(crate) fn driver_mut(&mut self, who: Who) -> Option<&mut Driver> {
        match who {
            Who::Planner => Some(&mut self.planner.driver),
            Who::Controller(number) => self.controllers.get_mut(usize::from(number)),
        }
    }
}

/// A placement: which one is of no matter here.
fn somewhere() -> RestingPlacement {
    RestingPlacement {
        placement: Placement { yaw: 0, x: 0, y: 0 },
        resting_height: Units::default(),
    }
}
