//! One placement: the cell goes on until one has begun, and is held again.
//!
//! The protocol has no request for this. A hold brings what is under way to its end and lets nothing else begin, so one that is sent while
//! the first placement is made leaves it at that one. A robot that takes less time for a placement than a message for its way may have
//! begun another one by then.

use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use ppnpack_service::ServiceError;
use ppnpack_service::stream::{self, Subscription};
use ppnpack_service::sync::lock;
use ppnpack_wire::MAX_MESSAGE_BYTES;
use ppnpack_wire::keys::Stream;
use ppnpack_wire::v1;

use super::{ControlError, Controls, PATIENCE, Target};

/// How long it may take until a placement begins.
const BEGINNING: Duration = Duration::from_secs(30);

/// Signs that wait to be looked at.
const KEPT: usize = 64;

/// Why the cell is held afterwards.
const ONE_STEP: &str = "one step was asked for at the operator's page";

/// What is heard of a cell that makes a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sign {
    /// A placement is being made, or was.
    Begun,
    /// The cell is held.
    Held,
}

/// How the wait for a placement ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Waited {
    Begun,
    HeldByOthers,
    NothingBegan,
}

impl Controls {
    pub(super) fn step(&self, target: &Target) -> Result<String, ControlError> {
        if !lock(&self.stepping).insert(target.cell.clone()) {
            return Err(ControlError::Busy("another step is under way"));
        }
        let stepped = self.step_alone(target);
        lock(&self.stepping).remove(&target.cell);
        stepped
    }

    fn step_alone(&self, target: &Target) -> Result<String, ControlError> {
        self.must_be_held(target)?;
        let (signs, subscriptions) = self
            .listen(target)
            .map_err(|error| ControlError::Unanswered(error.to_string()))?;
        // What was told before the cell goes on says nothing of the step; what is told from now on may be its placement.
        while signs.try_recv().is_ok() {}
        let resumed = self.resume(target);
        let waited = match &resumed {
            Ok(_) => self.wait_for_placement(target, &signs),
            Err(_) => Waited::NothingBegan,
        };
        drop(subscriptions);
        // Also where it was not resumed, as far as is known: it may have been.
        self.hold(target, ONE_STEP, false).map_err(goes_on)?;
        resumed?;
        match waited {
            Waited::Begun => Ok("One placement has begun; the cell is held after it.".to_owned()),
            Waited::HeldByOthers => Err(refused(
                "it was held by somebody else before a placement began",
            )),
            Waited::NothingBegan => Err(ControlError::Refused(format!(
                "no placement began within {} s; the cell is held again",
                BEGINNING.as_secs()
            ))),
        }
    }

    fn must_be_held(&self, target: &Target) -> Result<(), ControlError> {
        for state in self.states(target)? {
            if state.hold.is_none() {
                return Err(refused(
                    "the cell is not held: a step begins with a cell that stands still",
                ));
            }
            if !state.executing_placement_id.is_empty() {
                return Err(refused("a placement is still being made: wait for its end"));
            }
        }
        Ok(())
    }

    fn states(&self, target: &Target) -> Result<Vec<v1::CellState>, ControlError> {
        let states = target.containers.iter().map(|container| {
            let reply = self.ask(container, v1::CellStateRequest::default(), PATIENCE)?;
            Ok(reply.state.unwrap_or_default())
        });
        states.collect()
    }

    fn wait_for_placement(&self, target: &Target, signs: &Receiver<Sign>) -> Waited {
        let deadline = Instant::now() + BEGINNING;
        let is_held = || {
            let states = self.states(target);
            states.is_ok_and(|states| states.iter().any(|state| state.hold.is_some()))
        };
        loop {
            match wait(signs, deadline) {
                // It was told before the cell went on, and came late.
                Waited::HeldByOthers if !is_held() => {}
                waited => return waited,
            }
        }
    }

    /// Hears what the containers of a cell tell from now on.
    fn listen(&self, target: &Target) -> Result<(Receiver<Sign>, Vec<Subscription>), ServiceError> {
        let (sender, signs) = sync_channel(KEPT);
        let mut subscriptions = Vec::new();
        for container in &target.containers {
            let tell = sender.clone();
            let on_state = move |_, state: v1::CellState| {
                let is_begun = !state.executing_placement_id.is_empty();
                let begun = is_begun.then_some(Sign::Begun);
                let held = state.hold.is_some().then_some(Sign::Held);
                if let Some(sign) = begun.or(held) {
                    // Where there is no room, others say the same.
                    tell.try_send(sign).ok();
                }
            };
            let tell = sender.clone();
            let on_outcome = move |_, _: v1::Outcome| {
                tell.try_send(Sign::Begun).ok();
            };
            let (session, of) = (&self.session, Some(container));
            subscriptions.extend([
                stream::subscribe(session, of, Stream::State, MAX_MESSAGE_BYTES, on_state)?,
                stream::subscribe(session, of, Stream::Outcome, MAX_MESSAGE_BYTES, on_outcome)?,
            ]);
        }
        Ok((signs, subscriptions))
    }
}

fn wait(signs: &Receiver<Sign>, deadline: Instant) -> Waited {
    let left = deadline.saturating_duration_since(Instant::now());
    match signs.recv_timeout(left) {
        Ok(Sign::Begun) => Waited::Begun,
        Ok(Sign::Held) => Waited::HeldByOthers,
        Err(_) => Waited::NothingBegan,
    }
}

fn refused(why: &str) -> ControlError {
    ControlError::Refused(why.to_owned())
}

/// The cell could not be held again.
fn goes_on(error: ControlError) -> ControlError {
    match error {
        ControlError::Refused(why) | ControlError::Unanswered(why) => ControlError::Unanswered(
            format!("THE CELL GOES ON: it could not be held again after the step: {why}"),
        ),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_waits_for_the_first_sign() {
        let soon = || Instant::now() + Duration::from_millis(1);
        for (sign, waited) in [
            (Sign::Begun, Waited::Begun),
            (Sign::Held, Waited::HeldByOthers),
        ] {
            let (sender, signs) = sync_channel(1);
            sender.send(sign).unwrap();
            assert_eq!(wait(&signs, soon()), waited);
            assert_eq!(wait(&signs, soon()), Waited::NothingBegan);
        }
    }
}
