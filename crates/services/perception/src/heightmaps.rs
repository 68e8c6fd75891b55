//! The actor that answers requests for heightmaps of all cells. It never waits for one of them.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use ppnpack_service::actor::{Actor, PendingRequests};
use ppnpack_service::clock::Boottime;
use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1::{self, Status};

use crate::router::Router;

pub(crate) enum Message {
    Request(Incoming<v1::HeightmapRequest>),
    New(Cell, v1::Heightmap),
}

/// A heightmap and when it was made.
type Made = (v1::Heightmap, Boottime);

pub(crate) struct Heightmaps {
    /// Knows when clouds came.
    router: Arc<Router>,
    latest: BTreeMap<Cell, Made>,
    pending: PendingRequests<Incoming<v1::HeightmapRequest>>,
}

impl Actor for Heightmaps {
    type Message = Message;

    fn handle(&mut self, message: Message) {
        match message {
            Message::Request(incoming) => self.answer_or_keep(incoming),
            Message::New(cell, heightmap) => self.take(cell, heightmap),
        }
    }

    fn tick(&mut self) {
        for incoming in self.pending.take_expired() {
            self.refuse(incoming);
        }
    }

    fn next_tick(&self) -> Option<Instant> {
        self.pending.next_expiry()
    }
}

impl Heightmaps {
    /// Keeps at most so many requests pending.
    pub(crate) fn new(router: Arc<Router>, most_pending: usize) -> Self {
        Self {
            router,
            latest: BTreeMap::new(),
            pending: PendingRequests::new(most_pending),
        }
    }

    fn answer_or_keep(&mut self, mut incoming: Incoming<v1::HeightmapRequest>) {
        incoming.start();
        match self.latest.get(incoming.cell()) {
            Some(made) if is_enough(made, &incoming) => answer(incoming, made),
            _ => self.pending.keep_or_refuse(incoming),
        }
    }

    fn take(&mut self, cell: Cell, heightmap: v1::Heightmap) {
        let made = (heightmap, Boottime::now());
        let can_be_answered = |incoming: &Incoming<v1::HeightmapRequest>| {
            *incoming.cell() == cell && is_enough(&made, incoming)
        };
        for incoming in self.pending.take(can_be_answered) {
            answer(incoming, &made);
        }
        self.latest.insert(cell, made);
    }

    /// Refuses a request whose time limit passed.
    fn refuse(&self, incoming: Incoming<v1::HeightmapRequest>) {
        let cell = incoming.cell();
        let wanted = incoming.message().least_state_number;
        let silence = self.router.silence(cell);
        let silence = silence.map_or_else(String::new, |silence| format!(": {silence}"));
        let newest = self.latest.get(cell).map(|(newest, _)| newest.state_number);
        let (status, message) = match newest {
            Some(newest) => (
                Status::TimedOut,
                format!(
                    "the newest heightmap of cell {cell} shows its state {newest}, not {wanted} yet{silence}"
                ),
            ),
            None => (
                Status::Unavailable,
                format!("there is no heightmap of cell {cell} yet{silence}"),
            ),
        };
        incoming.refuse(status, message);
    }
}

fn is_enough((newest, _): &Made, incoming: &Incoming<v1::HeightmapRequest>) -> bool {
    newest.state_number >= incoming.message().least_state_number
}

fn answer(incoming: Incoming<v1::HeightmapRequest>, (heightmap, made_at): &Made) {
    let reply = v1::HeightmapReply {
        header: None,
        heightmap: Some(heightmap.clone()),
        age_ns: u64::try_from(made_at.elapsed().as_nanos()).unwrap_or(u64::MAX),
    };
    incoming.reply(reply, Done::default());
}
