//! The goals of an action, from when they are accepted until nobody asks for their results any more.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::messages::{FeedbackMessage, GetResult, GetResultResponse};
use super::{Action, Status};
use crate::error::RosError;
use crate::messages::action_msgs::{CancelGoalResponse, GoalInfo, GoalStatus, GoalStatusArray};
use crate::messages::builtin_interfaces::Time;
use crate::messages::unique_identifier_msgs::Uuid;
use crate::publisher::Publisher;
use crate::service::Request;

/// Goals whose results are kept: of more, those that were accepted first are forgotten.
const KEPT: usize = 32;

/// How many may wait for the result of one goal.
const WAITING: usize = 16;

/// What names a goal.
type GoalId = [u8; 16];

/// The goals that are known.
pub(super) struct Goals<A: Action> {
    known: Mutex<BTreeMap<GoalId, Known<A>>>,
    feedback: Publisher<FeedbackMessage<A>>,
    status: Publisher<GoalStatusArray>,
}

struct Known<A: Action> {
    accepted_at: Time,
    status: Status,
    /// Once it has ended.
    result: A::Result,
    /// Who waits for that.
    waiting: Vec<Request<GetResult<A>>>,
}

/// A goal that is carried out. Dropped without an end, it is aborted.
pub struct Goal<A: Action> {
    id: GoalId,
    accepted_at: Time,
    message: A::Goal,
    goals: Arc<Goals<A>>,
}

impl<A: Action> Goals<A> {
    pub(super) fn new(
        feedback: Publisher<FeedbackMessage<A>>,
        status: Publisher<GoalStatusArray>,
    ) -> Self {
        Self {
            known: Mutex::default(),
            feedback,
            status,
        }
    }

    /// A goal is accepted; `None` where another one has its id.
    pub(super) fn begin(goals: &Arc<Self>, id: GoalId, message: A::Goal) -> Option<Goal<A>> {
        let accepted_at = Time::now();
        {
            let mut known = goals.known();
            if known.contains_key(&id) {
                return None;
            }
            forget(&mut known);
            let goal = Known {
                accepted_at: accepted_at.clone(),
                status: Status::Accepted,
                result: A::Result::default(),
                waiting: Vec::new(),
            };
            known.insert(id, goal);
        }
        goals.tell_status();
        Some(Goal {
            id,
            accepted_at,
            message,
            goals: Arc::clone(goals),
        })
    }

    /// Asks goals to end.
    pub(super) fn cancel(&self, of: &GoalInfo) -> CancelGoalResponse {
        let response = cancel(&mut self.known(), of);
        if !response.goals_canceling.is_empty() {
            self.tell_status();
        }
        response
    }

    /// Answers with the result of a goal, once there is one.
    pub(super) fn ask(&self, request: Request<GetResult<A>>) {
        let id = request.message().goal_id.uuid;
        let response = match self.known().get_mut(&id) {
            Some(goal) if !goal.status.has_ended() && goal.waiting.len() < WAITING => {
                return goal.waiting.push(request);
            }
            Some(goal) => response_of::<A>(goal.status, &goal.result),
            None => response_of::<A>(Status::Unknown, &A::Result::default()),
        };
        request.answer(&response);
    }

    /// Says how far the goals are, to all.
    fn tell_status(&self) {
        let known = self.known();
        let list = known.iter().map(|(id, goal)| GoalStatus {
            goal_info: info(*id, &goal.accepted_at),
            status: goal.status.number(),
        });
        let status = GoalStatusArray {
            status_list: list.collect(),
        };
        // Unlocked before, an older list could be published after a newer one, and be kept as the last.
        let published = self.status.publish(&status);
        drop(known);
        if let Err(error) = published {
            tracing::debug!(%error, "the status of goals was not published");
        }
    }

    fn set(&self, id: GoalId, from: Status, to: Status) {
        let mut known = self.known();
        let Some(goal) = known.get_mut(&id).filter(|goal| goal.status == from) else {
            return;
        };
        goal.status = to;
        drop(known);
        self.tell_status();
    }

    /// A goal ends, where it has not.
    fn end(&self, id: GoalId, status: Status, result: A::Result) {
        let mut known = self.known();
        let Some(goal) = known.get_mut(&id).filter(|goal| !goal.status.has_ended()) else {
            return;
        };
        let response = response_of::<A>(status, &result);
        goal.status = status;
        goal.result = result;
        let waiting = std::mem::take(&mut goal.waiting);
        drop(known);
        self.tell_status();
        waiting
            .into_iter()
            .for_each(|asked| asked.answer(&response));
    }

    fn known(&self) -> MutexGuard<'_, BTreeMap<GoalId, Known<A>>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<A: Action> Goal<A> {
    /// What is wanted.
    pub fn message(&self) -> &A::Goal {
        &self.message
    }

    /// Its id.
    pub fn id(&self) -> Uuid {
        Uuid { uuid: self.id }
    }

    pub(super) fn accepted_at(&self) -> Time {
        self.accepted_at.clone()
    }

    /// It is carried out from now.
    pub fn execute(&self) {
        self.goals.set(self.id, Status::Accepted, Status::Executing);
    }

    /// Whether it is asked to end.
    pub fn is_canceling(&self) -> bool {
        let known = self.goals.known();
        let goal = known.get(&self.id);
        goal.is_some_and(|goal| goal.status == Status::Canceling)
    }

    /// Says how far it is.
    ///
    /// # Errors
    /// [`RosError::Zenoh`] where the session is closed.
    pub fn feedback(&self, feedback: A::Feedback) -> Result<(), RosError> {
        let goal_id = self.id();
        self.goals
            .feedback
            .publish(&FeedbackMessage { goal_id, feedback })
    }

    /// It has ended, and what came of it: [`Status::Succeeded`], [`Status::Canceled`] or [`Status::Aborted`]; any other counts as that.
    pub fn end(self, status: Status, result: A::Result) {
        let ended = if status.has_ended() {
            status
        } else {
            Status::Aborted
        };
        self.goals.end(self.id, ended, result);
    }
}

impl<A: Action> Drop for Goal<A> {
    fn drop(&mut self) {
        let result = A::Result::default();
        self.goals.end(self.id, Status::Aborted, result);
    }
}

fn response_of<A: Action>(status: Status, result: &A::Result) -> GetResultResponse<A> {
    GetResultResponse {
        status: status.number(),
        result: result.clone(),
    }
}

fn info(id: GoalId, accepted_at: &Time) -> GoalInfo {
    GoalInfo {
        goal_id: Uuid { uuid: id },
        stamp: accepted_at.clone(),
    }
}

/// Makes room for one more.
fn forget<A: Action>(known: &mut BTreeMap<GoalId, Known<A>>) {
    while known.len() >= KEPT {
        let ended = known.iter().filter(|(_, goal)| goal.status.has_ended());
        let Some(first) = ended.min_by_key(|(_, goal)| goal.accepted_at.to_ns()) else {
            return;
        };
        let id = *first.0;
        known.remove(&id);
    }
}

/// Asks those goals to end that a request names.
fn cancel<A: Action>(known: &mut BTreeMap<GoalId, Known<A>>, of: &GoalInfo) -> CancelGoalResponse {
    let (id, until_ns) = (of.goal_id.uuid, of.stamp.to_ns());
    let names_all = id == [0; 16] && until_ns == 0;
    let named = known.get(&id).map(|goal| goal.status);
    let mut goals_canceling = Vec::new();
    for (own, goal) in known.iter_mut() {
        let is_named = names_all || *own == id || goal.accepted_at.to_ns() <= until_ns;
        if is_named && !goal.status.has_ended() {
            goal.status = Status::Canceling;
            goals_canceling.push(info(*own, &goal.accepted_at));
        }
    }
    let return_code = match named {
        _ if !goals_canceling.is_empty() => CancelGoalResponse::ERROR_NONE,
        Some(_) => CancelGoalResponse::ERROR_GOAL_TERMINATED,
        None if id == [0; 16] => CancelGoalResponse::ERROR_NONE,
        None => CancelGoalResponse::ERROR_UNKNOWN_GOAL_ID,
    };
    CancelGoalResponse {
        return_code,
        goals_canceling,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::ppnpack_actions::{Pack, PackResult};

    fn known(goals: &[(u8, i32, Status)]) -> BTreeMap<GoalId, Known<Pack>> {
        let known = goals.iter().map(|(id, sec, status)| {
            let goal = Known {
                accepted_at: Time {
                    sec: *sec,
                    nanosec: 0,
                },
                status: *status,
                result: PackResult::default(),
                waiting: Vec::new(),
            };
            ([*id; 16], goal)
        });
        known.collect()
    }

    /// Which goals are cancelled, and the return code.
    fn cancelled(id: u8, sec: i32) -> (Vec<u8>, i8) {
        let mut known = known(&[
            (1, 10, Status::Executing),
            (2, 20, Status::Accepted),
            (3, 30, Status::Succeeded),
        ]);
        let stamp = Time { sec, nanosec: 0 };
        let response = cancel(&mut known, &info([id; 16], &stamp));
        let listed = response.goals_canceling.iter();
        let listed: Vec<u8> = listed.map(|goal| goal.goal_id.uuid[0]).collect();
        for (own, goal) in &known {
            let is_listed = listed.contains(&own[0]);
            assert_eq!(goal.status == Status::Canceling, is_listed);
        }
        (listed, response.return_code)
    }

    #[test]
    fn those_goals_are_cancelled_that_a_request_names() {
        assert_eq!(cancelled(0, 0), (vec![1, 2], 0), "all");
        assert_eq!(cancelled(2, 0), (vec![2], 0), "one");
        assert_eq!(cancelled(0, 15), (vec![1], 0), "those up to a time");
        assert_eq!(cancelled(2, 15), (vec![1, 2], 0), "both");
        assert_eq!(cancelled(3, 0), (vec![], 3), "one that has ended");
        assert_eq!(cancelled(9, 0), (vec![], 2), "one that is not known");
        assert_eq!(cancelled(0, 5), (vec![], 0), "none up to a time");
    }

    #[test]
    fn the_results_of_so_many_goals_are_kept() {
        let ended = (0..40).map(|id| (id, i32::from(id), Status::Succeeded));
        let mut goals: Vec<(u8, i32, Status)> = ended.collect();
        goals[0].2 = Status::Executing;
        let mut known = known(&goals);
        forget(&mut known);
        assert_eq!(known.len(), KEPT - 1);
        assert!(known.contains_key(&[0; 16]), "it is carried out");
        assert!(!known.contains_key(&[1; 16]) && known.contains_key(&[39; 16]));
    }
}
