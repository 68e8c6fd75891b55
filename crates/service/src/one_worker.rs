//! Services of one worker that answers one method, for some cells or any.

use std::thread::JoinHandle;
use std::time::Instant;

use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::item_store::MissingItems;
use ppnpack_wire::keys::{Cell, Service};
use ppnpack_wire::rpc::{Reply, Request};
use ppnpack_wire::v1::{self, Status};

use crate::actor::{self, Actor};
use crate::alive::{self, Alive};
use crate::error::ServiceError;
use crate::health::HealthLatch;
use crate::process::Process;
use crate::rpc::{Done, Incoming, Listener};
use crate::stream::each_or_all;
use crate::{Running, join};

/// A worker that answers the requests of planners, one after another.
pub trait Worker: Send + 'static {
    /// The request that it answers.
    type Request: Request<Reply: MissingItemsReply>;

    /// Answers a request.
    ///
    /// # Errors
    /// [`Refusal`] where it is not answered as it was asked.
    fn work(
        &mut self,
        incoming: &Incoming<Self::Request>,
    ) -> Result<(<Self::Request as Request>::Reply, Done), Refusal>;
}

/// A reply that can say which items are not known.
pub trait MissingItemsReply: Reply {
    /// Makes a reply that says no more than that.
    fn missing(items: Vec<Vec<u8>>) -> Self;
}

macro_rules! missing_items_replies {
    ($($reply:ident)*) => {
        $(impl MissingItemsReply for v1::$reply {
            fn missing(missing_items: Vec<Vec<u8>>) -> Self {
                Self {
                    missing_items,
                    ..Self::default()
                }
            }
        })*
    };
}

missing_items_replies! { EvaluateReply ProposeReply }

/// The reason for which a request is not answered as it was asked.
#[derive(Debug)]
pub enum Refusal {
    /// It is not possible, or more than may be asked for at once.
    Invalid(String),
    /// It names items that are not known.
    Missing(MissingItems),
    /// The time limit passed during the work.
    Late,
    /// The work failed.
    Failed(String),
}

impl<E: std::error::Error> From<E> for Refusal {
    fn from(error: E) -> Self {
        Self::Invalid(error.to_string())
    }
}

/// A worker, and the planners that are there to wait for its answers.
struct Answering<W> {
    worker: W,
    planners: Alive,
}

impl<W: Worker> Actor for Answering<W> {
    type Message = Incoming<W::Request>;

    fn handle(&mut self, incoming: Self::Message) {
        let Some(incoming) = incoming.still_wanted(&self.planners) else {
            return;
        };
        match self.worker.work(&incoming) {
            Ok((reply, done)) => incoming.reply(reply, done),
            Err(Refusal::Invalid(message)) => incoming.refuse(Status::Invalid, message),
            Err(Refusal::Late) => {
                let message =
                    "the time limit passed during the work: give it more time, or ask for less";
                incoming.refuse(Status::TimedOut, message);
            }
            Err(Refusal::Failed(message)) => incoming.refuse(Status::Failed, message),
            Err(Refusal::Missing(missing)) => {
                let message = missing.to_string();
                let items = missing.0.into_iter().map(ItemId::to_bytes).collect();
                let reply = MissingItemsReply::missing(items);
                incoming.refuse_with(reply, Status::MissingItems, message);
            }
        }
    }
}

/// A running service of one worker.
pub struct OneWorker {
    // Requests stop coming before the worker ends: fields are dropped in this order.
    alive: Vec<alive::Token>,
    listeners: Vec<Listener>,
    _ready: HealthLatch,
    thread: JoinHandle<()>,
}

impl OneWorker {
    /// Starts a worker on a thread of this name, for these cells, or any where none is named, with
    /// a queue for so many requests. The health check passes then.
    ///
    /// # Errors
    /// [`ServiceError`] where the session or the thread cannot be had.
    pub fn start(
        process: &Process,
        name: &str,
        ready: HealthLatch,
        cells: &[Cell],
        queue: usize,
        worker: impl Worker,
    ) -> Result<Self, ServiceError> {
        let planners = Alive::watch(process.session(), Service::Planner)?;
        let (address, mailbox) = actor::mailbox(queue.max(1));
        let thread = actor::spawn(process, name, Answering { worker, planners }, mailbox)?;
        let listen = |cell| address.listen(process, cell, |incoming| incoming);
        let listeners = each_or_all(cells).map(listen).collect::<Result<_, _>>()?;
        let announce = |cell| alive::announce(process, cell);
        let alive = each_or_all(cells).map(announce).collect::<Result<_, _>>()?;
        ready.pass();
        Ok(Self {
            alive,
            listeners,
            _ready: ready,
            thread,
        })
    }
}

impl Running for OneWorker {
    fn finish(self: Box<Self>, deadline: Instant) -> Result<(), String> {
        // Without the listeners nobody has the worker's address: it ends when its mailbox is empty.
        drop((self.alive, self.listeners));
        join(vec![self.thread], deadline)
    }
}
