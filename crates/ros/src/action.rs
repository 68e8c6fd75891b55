//! Actions: goals that are carried out over time, may be cancelled, and have a result.
//!
//! An action is three services and two topics below its name: `_action/send_goal`, `_action/cancel_goal`, `_action/get_result`,
//! `_action/feedback` and `_action/status`. Source: <https://design.ros2.org/articles/actions.html>.

mod goals;
mod messages;

use std::sync::Arc;

pub use goals::Goal;
use goals::Goals;
pub use messages::{
    FeedbackMessage, GetResultRequest, GetResultResponse, SendGoalRequest, SendGoalResponse,
};
use messages::{GetResult, SendGoal};

use crate::description::Message;
use crate::error::RosError;
use crate::messages::action_msgs::CancelGoal;
use crate::names::Name;
use crate::node::Node;
use crate::qos::Qos;
use crate::service::{Request, Server};

/// An action: what is wanted, what comes meanwhile, what comes of it.
pub trait Action: Send + Sync + 'static {
    /// What is wanted.
    type Goal: Message + Clone;

    /// What came of it. The default is that of a goal which nobody carried out.
    type Result: Message + Default + Clone;

    /// How far it is.
    type Feedback: Message;

    /// Its name, such as `example_interfaces/action/Fibonacci`.
    fn type_name() -> String;
}

/// How far a goal is, as `action_msgs/GoalStatus` numbers it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i8)]
pub enum Status {
    /// No such goal is known.
    Unknown = 0,
    /// It will be carried out.
    Accepted = 1,
    /// It is carried out.
    Executing = 2,
    /// It is asked to end.
    Canceling = 3,
    /// It was carried out.
    Succeeded = 4,
    /// It was cancelled.
    Canceled = 5,
    /// It could not be carried out.
    Aborted = 6,
}

impl Status {
    /// Whether nothing more comes of it.
    pub fn has_ended(self) -> bool {
        matches!(self, Self::Succeeded | Self::Canceled | Self::Aborted)
    }

    fn number(self) -> i8 {
        self as i8
    }
}

/// What carries a goal out, on a thread of its own.
pub type Work<A> = Box<dyn FnOnce(Goal<A>) + Send>;

/// An action that is served, until it is dropped.
pub struct ActionServer {
    _servers: [Server; 3],
}

impl ActionServer {
    /// Serves an action. `on_goal` gives the work that carries a goal out, or `None` where it is refused; it runs on Zenoh's thread and must
    /// not wait. Nothing else bounds how many goals are carried out at the same time.
    ///
    /// # Errors
    /// [`RosError`] where the name is not possible, or the session is closed.
    pub fn new<A: Action>(
        node: &Node,
        name: &Name,
        on_goal: impl Fn(&A::Goal) -> Option<Work<A>> + Send + Sync + 'static,
    ) -> Result<Self, RosError> {
        let goals = Arc::new(Goals::<A>::new(
            node.publisher(&name.join("_action/feedback")?, Qos::EVENTS)?,
            node.publisher(&name.join("_action/status")?, Qos::LATCHED)?,
        ));
        let (sent, cancelled, asked) = (Arc::clone(&goals), Arc::clone(&goals), goals);
        let send = move |request: Request<SendGoal<A>>| accept(&sent, request, &on_goal);
        let cancel = move |request: Request<CancelGoal>| {
            let response = cancelled.cancel(&request.message().goal_info);
            request.answer(&response);
        };
        let result = move |request: Request<GetResult<A>>| asked.ask(request);
        Ok(Self {
            _servers: [
                node.serve(&name.join("_action/send_goal")?, send)?,
                node.serve(&name.join("_action/cancel_goal")?, cancel)?,
                node.serve(&name.join("_action/get_result")?, result)?,
            ],
        })
    }
}

/// Answers whether a goal is carried out, and has it carried out.
fn accept<A: Action>(
    goals: &Arc<Goals<A>>,
    request: Request<SendGoal<A>>,
    on_goal: &impl Fn(&A::Goal) -> Option<Work<A>>,
) {
    let SendGoalRequest { goal_id, goal } = request.message();
    let begun = on_goal(goal).and_then(|work| {
        let goal = Goals::begin(goals, goal_id.uuid, goal.clone())?;
        Some((goal, work))
    });
    let Some((goal, work)) = begun else {
        return request.answer(&SendGoalResponse::refused());
    };
    request.answer(&SendGoalResponse::accepted(goal.accepted_at()));
    let thread = std::thread::Builder::new().name("ros-goal".to_owned());
    // Where there can be no more threads the goal is dropped, and with it ends as aborted.
    if let Err(error) = thread.spawn(move || work(goal)) {
        tracing::error!(%error, "a goal is not carried out");
    }
}
