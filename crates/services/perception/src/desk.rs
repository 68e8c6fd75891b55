//! The thread that answers who asks for heightmaps, of all cells. It never waits for one of them.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Instant;

use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1::{self, Status};

use crate::router::Router;
use crate::waiting::Waiting;

/// What comes to the desk.
pub(crate) enum Mail {
    /// Somebody wants a heightmap.
    Request(Incoming<v1::HeightmapRequest>),
    /// There is a new heightmap of a cell.
    Heightmap(Cell, v1::Heightmap),
}

/// A heightmap and when it was made.
struct Made {
    heightmap: v1::Heightmap,
    at: Instant,
}

/// Answers who asks for heightmaps.
pub(crate) struct Desk {
    /// Knows when clouds came.
    router: Arc<Router>,
    newest: BTreeMap<Cell, Made>,
    waiting: Waiting<v1::HeightmapRequest>,
}

impl Desk {
    pub(crate) fn new(router: Arc<Router>, most: usize) -> Self {
        Self {
            router,
            newest: BTreeMap::new(),
            waiting: Waiting::new(most),
        }
    }

    /// Works until nothing more can come.
    pub(crate) fn run(mut self, mail: &Receiver<Mail>) {
        loop {
            match mail.recv_timeout(self.waiting.pause()) {
                Ok(Mail::Request(incoming)) => self.answer_or_keep(incoming),
                Ok(Mail::Heightmap(cell, heightmap)) => self.take(cell, heightmap),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            self.give_up_waiting();
        }
    }

    fn answer_or_keep(&mut self, mut incoming: Incoming<v1::HeightmapRequest>) {
        incoming.start();
        match self.newest.get(incoming.cell()) {
            Some(made) if is_enough(&made.heightmap, &incoming) => answer(incoming, made),
            _ => self.waiting.keep(incoming),
        }
    }

    fn take(&mut self, cell: Cell, heightmap: v1::Heightmap) {
        let made = Made {
            heightmap,
            at: Instant::now(),
        };
        let is_served = |waiting: &Incoming<v1::HeightmapRequest>| {
            *waiting.cell() == cell && is_enough(&made.heightmap, waiting)
        };
        for incoming in self.waiting.take(is_served) {
            answer(incoming, &made);
        }
        self.newest.insert(cell, made);
    }

    /// Answers those whose time limit passed.
    fn give_up_waiting(&mut self) {
        for incoming in self.waiting.take_expired() {
            let cell = incoming.cell();
            let wanted = incoming.message().least_state_number;
            let silence = self.router.silence(cell);
            let silence = silence.map_or_else(String::new, |silence| format!(": {silence}"));
            match self.newest.get(cell) {
                Some(made) => {
                    let message = format!(
                        "the newest heightmap of cell {cell} shows its state {}, not {wanted} yet{silence}",
                        made.heightmap.state_number
                    );
                    incoming.refuse(Status::TimedOut, message);
                }
                None => {
                    let message = format!("there is no heightmap of cell {cell} yet{silence}");
                    incoming.refuse(Status::Unavailable, message);
                }
            }
        }
    }
}

fn is_enough(heightmap: &v1::Heightmap, incoming: &Incoming<v1::HeightmapRequest>) -> bool {
    heightmap.state_number >= incoming.message().least_state_number
}

fn answer(incoming: Incoming<v1::HeightmapRequest>, made: &Made) {
    let reply = v1::HeightmapReply {
        header: None,
        heightmap: Some(made.heightmap.clone()),
        age_ns: u64::try_from(made.at.elapsed().as_nanos()).unwrap_or(u64::MAX),
    };
    incoming.reply(reply, Done::default());
}
