//! Requests of ROS, passed on to the stack.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use ppnpack_ros::messages::ppnpack_srvs::{
    AnnounceResponse, BeginResponse, ChangedResponse, HoldResponse, PlanResponse, ReportResponse,
    WithdrawResponse,
};
use ppnpack_ros::messages::std_srvs::{SetBoolResponse, TriggerResponse};
use ppnpack_ros::names::Name;
use ppnpack_ros::service::{Request, Server, Service};
use ppnpack_ros::{Node, RosError};
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::rpc;

/// Requests that are worked on at the same time; more are refused.
const MOST: usize = 32;

/// Asks the stack on behalf of nodes of ROS. Clones share the bound on what is asked at the same time.
#[derive(Clone)]
pub(crate) struct Requests {
    client: Client,
    limit: Duration,
    under_way: Arc<AtomicUsize>,
}

/// A request that is worked on.
struct UnderWay(Arc<AtomicUsize>);

impl Drop for UnderWay {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::AcqRel);
    }
}

/// A response that says whether it was done, and why not.
pub(crate) trait Answer {
    /// What was not done, for this reason; or what was, without one.
    fn of(done: Result<(), String>) -> Self;
}

macro_rules! answers {
    ($($response:ty,)*) => {
        $(
            impl Answer for $response {
                fn of(done: Result<(), String>) -> Self {
                    Self {
                        success: done.is_ok(),
                        message: done.err().unwrap_or_default(),
                    }
                }
            }
        )*
    };
}

answers! {
    AnnounceResponse,
    BeginResponse,
    ChangedResponse,
    HoldResponse,
    ReportResponse,
    SetBoolResponse,
    TriggerResponse,
    WithdrawResponse,
}

impl Answer for PlanResponse {
    fn of(done: Result<(), String>) -> Self {
        Self {
            success: done.is_ok(),
            message: done.err().unwrap_or_default(),
            ..Self::default()
        }
    }
}

impl Requests {
    pub(crate) fn new(client: Client, limit: Duration) -> Self {
        Self {
            client,
            limit,
            under_way: Arc::default(),
        }
    }

    /// The same with a bound of its own: nothing else that is worked on has it refuse what is asked.
    pub(crate) fn apart(&self) -> Self {
        Self {
            under_way: Arc::default(),
            ..self.clone()
        }
    }

    /// The same as the controller of this packing session: planners refuse what it asks once another one is under way.
    pub(crate) fn of_session(&self, session_id: &str) -> Self {
        Self {
            client: self.client.clone().of_session(session_id),
            ..self.clone()
        }
    }

    /// Asks the stack, within the limit of a request of ROS.
    pub(crate) fn ask<R: rpc::Request>(
        &self,
        cell: &Cell,
        request: R,
    ) -> Result<R::Reply, CallError> {
        self.client.call(cell, request, Instant::now() + self.limit)
    }

    /// As [`Self::ask`], within a time of its own.
    pub(crate) fn ask_within<R: rpc::Request>(
        &self,
        cell: &Cell,
        request: R,
        limit: Duration,
    ) -> Result<R::Reply, CallError> {
        self.client.call(cell, request, Instant::now() + limit)
    }

    /// Answers a service by what the stack answers to a request that is made of the one of ROS.
    pub(crate) fn serve<S, R>(
        &self,
        node: &Node,
        name: &Name,
        cell: &Cell,
        to_request: impl Fn(&S::Request) -> R + Clone + Send + Sync + 'static,
    ) -> Result<Server, RosError>
    where
        S: Service<Response: Answer>,
        R: rpc::Request,
    {
        self.serve_with::<S>(node, name, cell, move |requests, cell, asked| {
            requests.ask(cell, to_request(asked))?;
            Ok(S::Response::of(Ok(())))
        })
    }

    /// Answers a service by this work, which may take as long as a request of ROS may. Each request has a thread: one that waits holds up
    /// no other.
    pub(crate) fn serve_with<S: Service<Response: Answer>>(
        &self,
        node: &Node,
        name: &Name,
        cell: &Cell,
        work: impl Fn(&Self, &Cell, &S::Request) -> Result<S::Response, CallError>
        + Clone
        + Send
        + Sync
        + 'static,
    ) -> Result<Server, RosError> {
        let (requests, cell) = (self.clone(), cell.clone());
        node.serve::<S>(name, move |request: Request<S>| {
            let Some(under_way) = requests.begin() else {
                let busy = format!("{MOST} requests are worked on: ask again");
                return request.answer(&S::Response::of(Err(busy)));
            };
            let (work, requests, cell) = (work.clone(), requests.clone(), cell.clone());
            let answer = move || {
                let done = work(&requests, &cell, request.message());
                let response = done.unwrap_or_else(|error| S::Response::of(Err(error.to_string())));
                request.answer(&response);
                drop(under_way);
            };
            let thread = std::thread::Builder::new().name("ros-request".to_owned());
            if let Err(error) = thread.spawn(answer) {
                tracing::error!(%error, "a request is not answered");
            }
        })
    }

    fn begin(&self) -> Option<UnderWay> {
        let before = self.under_way.fetch_add(1, Ordering::AcqRel);
        let under_way = UnderWay(Arc::clone(&self.under_way));
        (before < MOST).then_some(under_way)
    }
}
