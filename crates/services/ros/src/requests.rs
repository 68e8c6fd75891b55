//! Requests of ROS, passed on to the stack.

use std::sync::Arc;
use std::time::{Duration, Instant};

use ppnpack_service::rpc::{CallError, Client};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::{rpc, v1};

use crate::error::RosError;
use crate::rmw::keys::Name;
use crate::rmw::messages::{Done, Service};
use crate::rmw::{Node, Request, Server};

/// Maximum of requests that are worked on at the same time; more are refused.
const MOST: usize = 32;

/// A client that asks the stack on behalf of nodes of ROS. Clones share the bound on requests.
#[derive(Clone)]
pub(crate) struct Requests {
    client: Client,
    limit: Duration,
    under_way: Arc<UnderWay>,
}

/// A count of the requests that are worked on: each has a clone of the content.
#[derive(Default)]
struct UnderWay(Arc<()>);

impl Requests {
    pub(crate) fn new(client: Client, limit: Duration) -> Self {
        Self {
            client,
            limit,
            under_way: Arc::default(),
        }
    }

    /// Gives the same with a bound of its own: nothing else that is worked on makes it refuse.
    pub(crate) fn apart(&self) -> Self {
        Self {
            under_way: Arc::default(),
            ..self.clone()
        }
    }

    /// Asks the stack, within this time.
    pub(crate) fn ask<R: rpc::Request>(
        &self,
        cell: &Cell,
        request: R,
        limit: Duration,
    ) -> Result<R::Reply, CallError> {
        self.client.call(cell, request, Instant::now() + limit)
    }

    /// Asks the stack, as long as a request of ROS may take.
    pub(crate) fn pass_on<R: rpc::Request>(
        &self,
        cell: &Cell,
        request: R,
    ) -> Result<(), CallError> {
        self.ask(cell, request, self.limit).map(drop)
    }

    /// Has an empty container brought in place of the one that is there.
    pub(crate) fn renew(&self, cell: &Cell, (): ()) -> Result<(), CallError> {
        let told = self.ask(cell, v1::CellStateRequest::default(), self.limit)?;
        let request = v1::RenewRequest {
            state_number: told.state.unwrap_or_default().state_number,
            ..v1::RenewRequest::default()
        };
        self.pass_on(cell, request)
    }

    /// Answers a service by whether the stack does what it is asked; `to_asked` runs as the request
    /// comes. Each request has a thread: one that waits, as long as a request of ROS may, holds up
    /// no other.
    pub(crate) fn serve<S: Service<Response = Done>, A: Send + 'static>(
        &self,
        node: &Node,
        name: &Name,
        cell: &Cell,
        to_asked: impl Fn(&S) -> A + Send + Sync + 'static,
        ask: fn(&Self, &Cell, A) -> Result<(), CallError>,
    ) -> Result<Server, RosError> {
        let (requests, cell) = (self.clone(), cell.clone());
        node.serve(name, move |request: Request<S>| {
            let under_way = Arc::clone(&requests.under_way.0);
            if Arc::strong_count(&under_way) > MOST + 1 {
                let busy = format!("{MOST} requests are worked on: ask again");
                return request.answer(&answer(Err(busy)));
            }
            let (requests, cell) = (requests.clone(), cell.clone());
            let asked = to_asked(&request.message);
            let work = move || {
                let done = ask(&requests, &cell, asked);
                request.answer(&answer(done.map_err(|error| error.to_string())));
                drop(under_way);
            };
            let thread = std::thread::Builder::new().name("ros-request".to_owned());
            if let Err(error) = thread.spawn(work) {
                tracing::error!(%error, "a request is not answered");
            }
        })
    }
}

fn answer(done: Result<(), String>) -> Done {
    Done {
        success: done.is_ok(),
        message: done.err().unwrap_or_default(),
    }
}
