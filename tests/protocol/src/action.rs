//! What may happen next.

use ppnpack_protocol::placing::Ending;

use crate::configuration::Configuration;
use crate::driver::Call;
use crate::world::{Motion, World};

/// Who has decisions carried out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Who {
    /// The planner, in automatic mode.
    Planner,
    /// A controller.
    Controller(u8),
}

/// Something that may happen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Action {
    /// The next item is decided on, by a picture of this state that shows this content.
    Decide(Who, u64, u8),
    /// A controller asks for the session, and takes up the decision that awaits its outcome.
    TakeUp(u8),
    /// Nothing waits any more: the automatic mode ends.
    Finish,
    /// The bridge is asked for what comes next.
    Ask(Who),
    /// The request arrives, and is answered.
    Arrive(Who),
    /// The answer arrives.
    Receive(Who),
    /// The request is given up by who asked. It may arrive all the same.
    GiveUp(Who),
    /// A request for a placement that was given up, or doubled on its way, arrives.
    ArriveLate(u8),
    /// The planner hears of an outcome on its stream.
    Hear(u8),
    /// A controller reports what a decision came to.
    Report(u8),
    /// The robot begins what it was told.
    Move,
    /// The robot has ended what it did; whether the item is in the container then, where that may
    /// be either.
    Stop(Ending, bool),
    /// The bridge writes down what the robot did.
    Write,
    /// The bridge is killed.
    KillBridge,
    /// It is started.
    StartBridge,
    /// Its journal is lost.
    LoseJournal,
    /// A backup of the journal is made.
    BackUpJournal,
    /// It is put back.
    RestoreJournal,
    /// The planner is killed.
    KillPlanner,
    /// It is started.
    StartPlanner,
    /// Its store is lost.
    LoseStore,
    /// A backup of the store is made.
    BackUpStore,
    /// It is put back.
    RestoreStore,
    /// Somebody holds the cell.
    Hold(u8),
    /// Their request arrives once more, late.
    HoldAgain(u8),
    /// A hand takes an item out of the held cell, and says so.
    TakeOut(u8),
    /// Somebody looks, says what changed, and asks that what they saw hold the cell ends.
    Resume(u8),
    /// Their last request for that arrives, perhaps once more.
    Resumed(u8),
    /// Somebody sees that the session has failed, and asks that the automatic mode goes on.
    Acknowledge(u8),
    /// Their last request for that arrives, perhaps once more.
    Acknowledged(u8),
    /// Somebody begins a session anew, where the planner knows none.
    BeginAnew,
    /// An empty container is asked for.
    Renew,
    /// A session begins with the empty container.
    BeginNext,
}

impl World {
    /// All that may happen. Some of it may turn out to be impossible.
    pub fn actions(&self, configuration: &Configuration) -> Vec<Action> {
        use Action::*;
        let mut actions = match self.bridge.is_up {
            true => vec![Move, Write, KillBridge, Renew, BackUpJournal],
            false => vec![StartBridge, LoseJournal, RestoreJournal, BackUpJournal],
        };
        actions.extend(match self.planner.is_up {
            true => vec![Finish, KillPlanner, BeginAnew, BeginNext, BackUpStore],
            false => vec![StartPlanner, LoseStore, RestoreStore, BackUpStore],
        });
        for person in 0..self.people.len() as u8 {
            actions.extend([Hold(person), HoldAgain(person)]);
            actions.extend([Resume(person), Resumed(person)]);
            actions.extend([Acknowledge(person), Acknowledged(person)]);
        }
        for who in self.drivers() {
            match self.driver(who).and_then(|driver| driver.call.as_ref()) {
                None => actions.push(Ask(who)),
                Some(Call { answer: None, .. }) => actions.extend([Arrive(who), GiveUp(who)]),
                Some(_) => actions.extend([Receive(who), GiveUp(who)]),
            }
            if self.planner.session.pending().is_none() {
                let pictures = self.pictures.iter();
                actions.extend(pictures.map(|(state, content)| Decide(who, *state, *content)));
            }
            if let Who::Controller(controller) = who {
                actions.extend([TakeUp(controller), Report(controller)]);
            }
        }
        for decision in 0..self.decided.len() as u8 {
            actions.push(Hear(decision));
            if self.bridge.is_up && self.bridge.job.is_none() {
                actions.push(ArriveLate(decision));
            }
        }
        match self.motion {
            Some(Motion::Place(_)) => {
                actions.push(Stop(Ending::Placed, true));
                if configuration.may_fail {
                    actions.push(Stop(Ending::NotPlaced, false));
                    actions.push(Stop(Ending::Lost, false));
                    actions.extend([true, false].map(|inside| Stop(Ending::Unknown, inside)));
                }
            }
            Some(Motion::Renew) => actions.push(Stop(Ending::Placed, false)),
            None => {}
        }
        if self.is_held_by_somebody() {
            actions.extend((0..configuration.items).map(TakeOut));
        }
        actions
    }

    pub(crate) fn drivers(&self) -> Vec<Who> {
        match self.controllers.len() {
            0 => vec![Who::Planner],
            count => (0..count as u8).map(Who::Controller).collect(),
        }
    }

    /// Makes it happen; `None` where it cannot.
    pub(crate) fn happen(&mut self, action: Action, configuration: &Configuration) -> Option<()> {
        use Action::*;
        match action {
            Decide(who, state, content) => self.decide(who, state, content, configuration),
            TakeUp(controller) => self.take_up(controller),
            Finish => self.finish(),
            Ask(who) => self.ask(who),
            Arrive(who) => self.arrive(who, configuration),
            Receive(who) => self.receive(who),
            GiveUp(who) => self.give_up(who, configuration),
            ArriveLate(decision) => self.arrive_late(decision, configuration),
            Hear(decision) => self.hear(decision),
            Report(controller) => self.report(controller),
            Move => self.begin_motion(),
            Stop(ending, is_inside) => self.end_motion(ending, is_inside),
            Write => self.write_down(),
            KillBridge => self.kill_bridge(configuration),
            StartBridge => self.start_bridge(configuration),
            LoseJournal => self.lose_journal(configuration),
            BackUpJournal => self.back_up_journal(configuration),
            RestoreJournal => self.restore_journal(configuration),
            KillPlanner => self.kill_planner(configuration),
            StartPlanner => self.start_planner(),
            LoseStore => self.lose_store(configuration),
            BackUpStore => self.back_up_store(configuration),
            RestoreStore => self.restore_store(configuration),
            Hold(person) => self.hold(person, configuration),
            HoldAgain(person) => self.hold_again(person, configuration),
            TakeOut(item) => self.take_out(item, configuration),
            Resume(person) => self.resume(person),
            Resumed(person) => self.resumed(person, configuration),
            Acknowledge(person) => self.acknowledge(person, configuration),
            Acknowledged(person) => self.acknowledged(person, configuration),
            BeginAnew => self.begin_anew(configuration),
            Renew => self.renew(configuration),
            BeginNext => self.begin_next(configuration),
        }
    }
}
