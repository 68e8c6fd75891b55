//! The bridge of a container: its state, where a step needs it or is better with it, and its clock,
//! by which decisions age.

use std::time::{Duration, Instant};

use ppnpack_service::ServiceError;
use ppnpack_service::process::Process;
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_service::stream::{Arrived, Latest};
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::{MAX_MESSAGE_BYTES, v1};

use crate::refusal::Refusal;

/// Maximum wait for a state that is needed, by one request.
const NEEDED_LIMIT: Duration = Duration::from_secs(1);

/// Maximum wait for a state that can be done without.
const USEFUL_LIMIT: Duration = Duration::from_millis(100);

/// Time for which a bridge that did not say its state is not asked for what can be done without.
const LEFT_ALONE: Duration = Duration::from_secs(30);

/// Pause before a bridge that refused to say its state is asked again.
const PAUSE: Duration = Duration::from_millis(50);

/// The bridge of a container.
pub(crate) struct Bridge {
    address: Cell,
    client: Client,
    states: Latest<v1::CellState>,
    /// The clock as it was told last, with a state.
    clock_ns: Option<Arrived<u64>>,
    /// The state in the last answer; 0 before the first one.
    pub(crate) told_state: u64,
    left_alone_until: Option<Instant>,
}

impl Bridge {
    pub(crate) fn subscribe(
        process: &Process,
        address: &Cell,
        client: &Client,
    ) -> Result<Self, ServiceError> {
        Ok(Self {
            address: address.clone(),
            client: client.clone(),
            states: Latest::subscribe(process, address, Stream::State, MAX_MESSAGE_BYTES)?,
            clock_ns: None,
            told_state: 0,
            left_alone_until: None,
        })
    }

    pub(crate) fn call<R: Request>(
        &self,
        request: R,
        until: Instant,
    ) -> Result<R::Reply, CallError> {
        self.client.call(&self.address, request, until)
    }

    pub(crate) fn was_heard(&mut self) -> bool {
        if let Some(Ok(arrived)) = self.states.take().map(Arrived::transpose) {
            self.clock_ns = Some(arrived.map(|state| state.clock_ns));
        }
        self.clock_ns.is_some()
    }

    /// Takes over a state that was answered just now.
    pub(crate) fn heard(&mut self, state: v1::CellState) -> v1::CellState {
        self.clock_ns = Some(Arrived::now(state.clock_ns));
        self.told_state = state.state_number;
        self.left_alone_until = None;
        state
    }

    /// Asks for the present state once, also where the bridge did not answer last.
    pub(crate) fn ask_state(&mut self, until: Instant) -> Option<v1::CellState> {
        let reply = self.call(v1::CellStateRequest::default(), until);
        let state = reply.ok().and_then(|reply| reply.state);
        state.map(|state| self.heard(state))
    }

    /// Gives the present state where a step can do without; a bridge that did not say it is left
    /// alone for a while.
    pub(crate) fn useful_state(&mut self, deadline: Instant) -> Option<v1::CellState> {
        let now = Instant::now();
        if self.left_alone_until.is_some_and(|until| now < until) {
            return None;
        }
        let state = self.ask_state(deadline.min(now + USEFUL_LIMIT));
        if state.is_none() {
            self.left_alone_until = Some(now + LEFT_ALONE);
        }
        state
    }

    /// Gives the present state where a step can do without, with more patience for a bridge that
    /// was heard of.
    pub(crate) fn state_if_there(&mut self, deadline: Instant) -> Option<v1::CellState> {
        match self.was_heard() {
            true => self.ask_state(deadline.min(Instant::now() + NEEDED_LIMIT)),
            false => self.useful_state(deadline),
        }
    }

    /// Gives the present state. A bridge that was heard of, or is needed, is waited for until the
    /// deadline; `None` where there is none, and a controller drives the robot itself.
    ///
    /// # Errors
    /// [`Unavailable`](v1::Status::Unavailable) where it does not say.
    pub(crate) fn state(
        &mut self,
        is_needed: bool,
        deadline: Instant,
    ) -> Result<Option<v1::CellState>, Refusal> {
        if !is_needed && !self.was_heard() {
            return Ok(self.useful_state(deadline));
        }
        loop {
            let until = deadline.min(Instant::now() + NEEDED_LIMIT);
            if let Some(state) = self.ask_state(until) {
                return Ok(Some(state));
            }
            if Instant::now() + USEFUL_LIMIT >= deadline {
                return Err(Refusal::unavailable(format_args!(
                    "the bridge of cell {} does not say in which state it is",
                    self.address
                )));
            }
            std::thread::sleep(PAUSE);
        }
    }

    /// Gives what its clock shows now, in nanoseconds: a little less, as a state is on its way for
    /// a while; 0 where no bridge is heard of, not even when it is asked.
    pub(crate) fn now_ns(&mut self, deadline: Instant) -> u64 {
        if !self.was_heard() {
            self.useful_state(deadline);
        }
        let told = self.clock_ns.as_ref().filter(|told| told.message != 0);
        told.map_or(0, |told| {
            let since_ns = u64::try_from(told.at.elapsed().as_nanos()).unwrap_or(u64::MAX);
            told.message.saturating_add(since_ns)
        })
    }
}
