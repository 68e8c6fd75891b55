//! Who has decisions carried out: the planner in automatic mode, or a controller. Both do it by
//! [`pursuit`].

use ppnpack_protocol::pursuit::{self, Next};
use ppnpack_wire::v1::{self, OutcomeKind, Status};

use crate::world::needs;

/// What is asked of the bridge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Ask {
    Place(usize),
    Outcome(usize),
    State,
}

/// What the bridge answered.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Answer {
    Execution(v1::Execution),
    Refused(Status),
    State {
        first_state_number: u64,
        state_number: u64,
        is_held: bool,
    },
}

/// A request that is not answered yet, or whose answer is on its way.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Call {
    pub(crate) ask: Ask,
    pub(crate) answer: Option<Answer>,
}

/// Who has a decision carried out. All of it is forgotten when its process is killed.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Driver {
    pub(crate) decision: Option<usize>,
    pub(crate) call: Option<Call>,
    /// Whether the bridge said that it carries the decision out.
    pub(crate) is_accepted: bool,
    /// As what the decision is settled when the cell's state is known.
    pub(crate) settling: Option<OutcomeKind>,
    /// Whether the cell was held when it was last asked.
    pub(crate) is_held: bool,
    /// What the decision came to, to be reported.
    pub(crate) outcome: Option<Settled>,
}

/// How a decision ended, for the session.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Settled(pub(crate) v1::Outcome);

impl Driver {
    /// What it knows when it goes on with another decision, or with none.
    pub(crate) fn going_on_with(&self, decision: Option<usize>) -> Self {
        Self {
            decision,
            is_held: self.is_held,
            ..Self::default()
        }
    }

    /// What it asks the bridge next; `None` where it has nothing to ask.
    pub(crate) fn next_ask(&self) -> Option<Ask> {
        needs(self.call.is_none() && self.outcome.is_none())?;
        if self.is_held && self.settling.is_none() {
            return Some(Ask::State);
        }
        let decision = self.decision?;
        Some(match (self.settling, self.is_accepted) {
            (Some(_), _) => Ask::State,
            (None, false) => Ask::Place(decision),
            (None, true) => Ask::Outcome(decision),
        })
    }

    /// Takes the answer to its request; says whether it gives up, as somebody has to look.
    pub(crate) fn receive(&mut self, decision: Option<&v1::Decision>) -> Option<bool> {
        let Call { ask, answer } = self.call.take_if(|call| call.answer.is_some())?;
        let next = match (ask, answer?) {
            (
                Ask::State,
                Answer::State {
                    first_state_number,
                    state_number,
                    is_held,
                },
            ) => {
                match (self.settling.take(), decision) {
                    (Some(kind), Some(decision)) => {
                        let state = v1::CellState {
                            first_state_number,
                            ..v1::CellState::default()
                        };
                        let kind = pursuit::as_known(kind, decision, &state);
                        let outcome = pursuit::settled_as(decision, kind, "", state_number);
                        self.outcome = Some(Settled(outcome));
                    }
                    _ => self.is_held = is_held,
                }
                return Some(false);
            }
            (Ask::Place(_), answer) => {
                self.is_accepted = matches!(answer, Answer::Execution(_));
                self.is_held |= answer == Answer::Refused(Status::Held);
                pursuit::after_place(read(&answer))
            }
            (Ask::Outcome(_), answer) => pursuit::after_outcome(read(&answer)),
            (Ask::State, _) => return None,
        };
        match next {
            Next::Wait | Next::AskAgain => {}
            Next::Settle(outcome) => self.outcome = Some(Settled(outcome)),
            Next::SettleAs(kind) => self.settling = Some(kind),
            Next::PlaceAgain => self.is_accepted = false,
            Next::GiveUp => return Some(true),
        }
        Some(false)
    }
}

fn read(answer: &Answer) -> pursuit::Answer<'_> {
    match answer {
        Answer::Execution(execution) => Ok(Some(execution)),
        Answer::Refused(status) => Err(Some(*status)),
        Answer::State { .. } => Err(None),
    }
}
