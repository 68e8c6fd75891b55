//! Services of one worker that answers one method, for any cell.

use std::thread::JoinHandle;
use std::time::Instant;

use ppnpack_wire::rpc::Request;

use crate::actor::{self, Actor};
use crate::alive;
use crate::error::ServiceError;
use crate::health::HealthLatch;
use crate::process::Process;
use crate::rpc::{Incoming, Listener};
use crate::{Running, join};

/// A running service of one worker.
pub struct OneWorker {
    // Requests stop coming before the worker ends: fields are dropped in this order.
    alive: alive::Token,
    listener: Listener,
    _ready: HealthLatch,
    thread: JoinHandle<()>,
}

impl OneWorker {
    /// Starts a worker on a thread of this name, with so many requests waiting for it at most. The health check passes then.
    ///
    /// # Errors
    /// [`ServiceError`] where the session or the thread cannot be had.
    pub fn start<R, A>(
        process: &Process,
        name: &str,
        ready: HealthLatch,
        queue: usize,
        worker: A,
    ) -> Result<Self, ServiceError>
    where
        R: Request,
        A: Actor<Message = Incoming<R>> + Send + 'static,
    {
        let (address, mailbox) = actor::mailbox(queue.max(1));
        let thread = actor::spawn(process, name, worker, mailbox)?;
        let listener = address.listen(process, None, |incoming| incoming)?;
        let alive = alive::announce(process, None)?;
        ready.pass();
        Ok(Self {
            alive,
            listener,
            _ready: ready,
            thread,
        })
    }
}

impl Running for OneWorker {
    fn finish(self: Box<Self>, deadline: Instant) -> Result<(), String> {
        // Without the listener nobody has the worker's address: it ends when its mailbox is empty.
        drop((self.alive, self.listener));
        join(vec![self.thread], deadline)
    }
}
