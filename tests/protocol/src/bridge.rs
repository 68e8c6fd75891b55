//! The bridge: its ledger, its robot, which goes on whoever watches it, and its disk.

use std::sync::Arc;

use nalgebra::Isometry3;
use ppnpack_protocol::ledger::{FROM_BACKUP, Ledger, PlacementVerdict, Record, RenewalVerdict};
use ppnpack_protocol::message;
use ppnpack_protocol::placing::{Body, Ending, Finding, KnownPose};
use ppnpack_wire::v1::{self, Status};

use crate::action::Who;
use crate::configuration::{Configuration, Fault, Sabotage};
use crate::driver::{Answer, Ask, Call};
use crate::shared::Shared;
use crate::world::{Broken, Job, Motion, Whereabouts, World, needs};

pub(crate) fn item_id(item: usize) -> String {
    format!("i{item}")
}

impl World {
    /// A request is sent. A placement's may arrive again, and late.
    pub(crate) fn send(&mut self, who: Who, ask: Ask) -> Option<()> {
        if let Ask::Place(decision) = ask {
            self.decided.get_mut(decision)?.is_sent = true;
        }
        let driver = self.driver_mut(who)?;
        driver.call = Some(Call { ask, answer: None });
        Some(())
    }

    pub(crate) fn arrive(&mut self, who: Who, configuration: &Configuration) -> Option<()> {
        needs(self.bridge.is_up)?;
        let call = self.driver(who)?.call.as_ref()?;
        needs(call.answer.is_none())?;
        let answer = match call.ask {
            Ask::Place(decision) => self.place(decision, configuration)?,
            Ask::Outcome(decision) => self.outcome(decision)?,
            Ask::State => Answer::State {
                first_state_number: match configuration.lacks(Sabotage::KnowsAll) {
                    true => 1,
                    false => self.bridge.ledger.head().first_state_number,
                },
                state_number: self.bridge.ledger.head().state_number,
                is_held: self.bridge.ledger.is_held(),
            },
        };
        self.driver_mut(who)?.call.as_mut()?.answer = Some(answer);
        Some(())
    }

    /// Nobody waits for the answer any more: it counts where the placement is begun.
    pub(crate) fn arrive_late(
        &mut self,
        decision: u8,
        configuration: &Configuration,
    ) -> Option<()> {
        let decision = usize::from(decision);
        needs(self.bridge.is_up && self.decided.get(decision)?.is_sent)?;
        let before = self.bridge.ledger.head().next;
        self.place(decision, configuration)?;
        (self.bridge.ledger.head().next != before).then_some(())
    }

    fn place(&mut self, number: usize, configuration: &Configuration) -> Option<Answer> {
        let decided = self.decided.get(number)?;
        let request = v1::PlaceRequest::from(&*decided.decision);
        let Ok(placement) = message::read_placement(&request) else {
            return Some(Answer::Refused(Status::Invalid));
        };
        let ledger = &self.bridge.ledger;
        let verdict = ledger.judge(&placement);
        let is_let_through = match verdict {
            PlacementVerdict::Stale => configuration.lacks(Sabotage::AnyState),
            PlacementVerdict::Held(_) => configuration.lacks(Sabotage::BeginsWhileHeld),
            _ => false,
        };
        if let Some(status) = verdict.refusal().filter(|_| !is_let_through) {
            let is_forgotten = status == Status::Forgotten;
            let is_lacking = configuration.lacks(Sabotage::KnowsAll);
            return Some(Answer::Refused(match is_forgotten && is_lacking {
                true => Status::Stale,
                false => status,
            }));
        }
        if let PlacementVerdict::Known(outcome) = verdict {
            let execution = message::execution(&placement, outcome);
            return Some(Answer::Execution(execution));
        }
        let execution = message::execution(&placement, None);
        let is_held = self.is_held_by_somebody();
        // What is unknown may have been carried out, now or before.
        let is_settled = decided
            .settled
            .is_some_and(|kind| kind != v1::OutcomeKind::Unknown);
        let change = ledger.accept(placement);
        self.bridge.ledger.apply(change);
        self.bridge.job = Some(Job::Place(number));
        if is_held {
            self.break_promise(Broken::BegunWhileHeld);
        }
        if is_settled {
            self.break_promise(Broken::BegunAfterItWasSettled);
        }
        Some(Answer::Execution(execution))
    }

    fn outcome(&self, number: usize) -> Option<Answer> {
        let id = &self.decided.get(number)?.decision.decision_id;
        Some(match self.bridge.ledger.placement(id) {
            None => Answer::Refused(Status::NotFound),
            Some((_, None)) => Answer::Refused(Status::TimedOut),
            Some((placement, outcome)) => Answer::Execution(message::execution(placement, outcome)),
        })
    }

    pub(crate) fn begin_motion(&mut self) -> Option<()> {
        needs(self.bridge.is_up && self.motion.is_none())?;
        match self.bridge.job {
            Some(Job::Renew) => self.motion = Some(Motion::Renew),
            Some(Job::Place(number)) => {
                let content = self.content();
                let decided = self.decided.get_mut(number)?;
                decided.begun += 1;
                let is_first = decided.begun == 1;
                let is_as_shown = decided.shown == content;
                let waits = self.items.get(usize::from(decided.item))? == &Whereabouts::Waiting;
                let promises = [
                    (is_first, Broken::BegunTwice),
                    (waits, Broken::ItemPlacedTwice),
                    (is_as_shown, Broken::OtherContent),
                ];
                let broken = promises.iter().find(|(is_kept, _)| !is_kept);
                if let Some((_, broken)) = broken {
                    self.break_promise(*broken);
                }
                self.motion = Some(Motion::Place(number));
            }
            _ => return None,
        }
        Some(())
    }

    pub(crate) fn end_motion(&mut self, ending: Ending, is_inside: bool) -> Option<()> {
        match self.motion.take()? {
            Motion::Renew => {
                for item in &mut self.items {
                    if *item == Whereabouts::Inside {
                        *item = Whereabouts::Elsewhere;
                    }
                }
                if self.bridge.job == Some(Job::Renew) {
                    self.bridge.job = Some(Job::Renewed);
                }
            }
            Motion::Place(number) => {
                let item = self.decided.get(number)?.item;
                *self.items.get_mut(usize::from(item))? = match (ending, is_inside) {
                    (Ending::NotPlaced, _) => Whereabouts::Waiting,
                    (_, true) => Whereabouts::Inside,
                    (_, false) => Whereabouts::Elsewhere,
                };
                // Of a bridge that was killed meanwhile nobody hears it.
                if self.bridge.job == Some(Job::Place(number)) {
                    self.bridge.job = Some(Job::Placed(Finding::failed(ending, "")));
                }
            }
        }
        Some(())
    }

    pub(crate) fn write_down(&mut self) -> Option<()> {
        let bodies = self.bodies();
        let ledger = &self.bridge.ledger;
        let change = match self.bridge.job.clone()? {
            Job::Placed(finding) => ledger.end_placement(finding, bodies),
            Job::Renewed => ledger.end_renewal(bodies),
            Job::Place(_) | Job::Renew => return None,
        };
        if let Some((
            _,
            Record::Placement {
                placement,
                outcome: Some(outcome),
            },
        )) = &change.written
        {
            let outcome = message::write_outcome(placement, outcome);
            self.published.push(Arc::new(outcome));
        }
        self.bridge.ledger.apply(change);
        self.bridge.job = None;
        Some(())
    }

    /// What the robot knows to lie in the container.
    fn bodies(&self) -> Vec<Body> {
        let items = self.items.iter().enumerate();
        let inside = items.filter(|(_, whereabouts)| **whereabouts == Whereabouts::Inside);
        let bodies = inside.map(|(item, _)| Body {
            item_id: item_id(item),
            object: "box".to_owned(),
            container_from_item: KnownPose::Assumed(Isometry3::identity()),
            is_inside: true,
        });
        bodies.collect()
    }

    pub(crate) fn kill_bridge(&mut self, configuration: &Configuration) -> Option<()> {
        needs(self.bridge.is_up)?;
        self.count(Fault::KillBridge, configuration)?;
        self.bridge.is_up = false;
        self.bridge.job = None;
        Some(())
    }

    pub(crate) fn start_bridge(&mut self, configuration: &Configuration) -> Option<()> {
        needs(!self.bridge.is_up && !configuration.lacks(Sabotage::NeverStarts))?;
        self.bridge.is_up = true;
        let has_not_happened = configuration.lacks(Sabotage::CutOffIsNotPlaced);
        let ledger = &self.bridge.ledger;
        let is_cut_off = ledger.under_way().is_some();
        let change = ledger.recover(has_not_happened);
        let change =
            change.filter(|_| is_cut_off || !configuration.lacks(Sabotage::BeginsWithoutPast));
        if let Some(change) = change {
            self.bridge.ledger.apply(change);
        }
        Some(())
    }

    pub(crate) fn lose_journal(&mut self, configuration: &Configuration) -> Option<()> {
        needs(!self.bridge.is_up)?;
        self.count(Fault::LoseJournal, configuration)?;
        self.bridge.ledger = Shared::new(Ledger::beginning_at(self.fresh_state()));
        Some(())
    }

    pub(crate) fn back_up_journal(&mut self, configuration: &Configuration) -> Option<()> {
        let is_of_use = configuration.most(Fault::Restore) > 0;
        let is_known = self.bridge.backup.as_ref() == Some(&self.bridge.ledger);
        needs(is_of_use && !is_known && self.happened(Fault::Restore) == 0)?;
        self.bridge.backup = Some(self.bridge.ledger.clone());
        Some(())
    }

    pub(crate) fn restore_journal(&mut self, configuration: &Configuration) -> Option<()> {
        needs(!self.bridge.is_up)?;
        let backup = self.bridge.backup.clone()?;
        self.count(Fault::Restore, configuration)?;
        let change = backup.restored_at(self.fresh_state(), FROM_BACKUP);
        self.bridge.ledger = backup;
        self.bridge.ledger.apply(change);
        Some(())
    }

    pub(crate) fn renew(&mut self, configuration: &Configuration) -> Option<()> {
        let id = format!("r{}", self.happened(Fault::Renew));
        let ledger = &self.bridge.ledger;
        needs(self.bridge.is_up && ledger.judge_renewal(&id) == RenewalVerdict::New)?;
        let change = ledger.begin_renewal(id);
        self.count(Fault::Renew, configuration)?;
        self.bridge.ledger.apply(change);
        self.bridge.job = Some(Job::Renew);
        Some(())
    }
}
