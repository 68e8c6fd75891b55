//! The board as pages get it: all of it at once, and then its changes.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::State;
use axum::http::header::CONTENT_TYPE;
use axum::response::sse::{Event, Sse};
use axum::response::{IntoResponse, Response};
use futures_util::stream;
use ppnpack_service::Shutdown;
use ppnpack_service::metrics::{self, Metric};
use tokio::sync::{OwnedSemaphorePermit, watch};
use tokio::time::{Instant, timeout_at};

use super::Served;
use super::failure::Failure;
use crate::board::Board;
use crate::now_ms;

/// How often a page hears that it is connected, whatever else it hears.
const BEAT: Duration = Duration::from_secs(1);

pub(super) async fn state(State(served): State<Arc<Served>>) -> impl IntoResponse {
    let (_, text) = snapshot(&served.board);
    ([(CONTENT_TYPE, "application/json")], text)
}

pub(super) async fn events(State(served): State<Arc<Served>>) -> Result<Response, Failure> {
    let permit = Arc::clone(&served.limits.pages).try_acquire_owned();
    let permit = permit.map_err(|_| Failure::too_many_pages())?;
    let page = Page::new(&served, permit);
    let events = stream::unfold(page, Page::next);
    // A proxy in between is to pass events on as they come.
    Ok(([("x-accel-buffering", "no")], Sse::new(events)).into_response())
}

/// Writes all parts, and gives the newest revision among them.
fn snapshot(board: &Board) -> (u64, String) {
    let changes = board.since(0);
    let (now_ms, revision) = (now_ms(), changes.revision);
    let parts = changes.parts.join(",");
    let text = format!(r#"{{"now_ms":{now_ms},"revision":{revision},"parts":[{parts}]}}"#);
    (revision, text)
}

struct Page {
    board: Arc<Board>,
    changes: watch::Receiver<u64>,
    seen: u64,
    /// The events that it is sent next: no more than one change of each part.
    waiting: VecDeque<Event>,
    next_beat: Instant,
    shutdown: Shutdown,
    _counted: Counted,
}

impl Page {
    fn new(served: &Served, permit: OwnedSemaphorePermit) -> Self {
        let board = Arc::clone(&served.board);
        let changes = board.watch();
        let (seen, text) = snapshot(&board);
        Self {
            board,
            changes,
            seen,
            waiting: VecDeque::from([Event::default().event("snapshot").data(text)]),
            next_beat: Instant::now() + BEAT,
            shutdown: served.shutdown.clone(),
            _counted: Counted::new(permit),
        }
    }

    /// Gives the next event; `None` where the server ends.
    async fn next(mut self) -> Option<(Result<Event, Infallible>, Self)> {
        loop {
            if Instant::now() >= self.next_beat {
                self.next_beat = Instant::now() + BEAT;
                let event = self.beat();
                return Some((Ok(event), self));
            }
            if let Some(event) = self.waiting.pop_front() {
                return Some((Ok(event), self));
            }
            if self.shutdown.is_requested() {
                return None;
            }
            match timeout_at(self.next_beat, self.changes.changed()).await {
                Ok(Ok(())) => self.take_changes(),
                Ok(Err(_)) => return None,
                Err(_) => {}
            }
        }
    }

    fn take_changes(&mut self) {
        let changes = self.board.since(self.seen);
        self.seen = changes.revision;
        let parts = changes.parts.iter();
        let events = parts.map(|part| Event::default().event("part").data(part));
        self.waiting.extend(events);
    }

    fn beat(&self) -> Event {
        let (now_ms, revision) = (now_ms(), self.seen);
        let text = format!(r#"{{"now_ms":{now_ms},"revision":{revision}}}"#);
        Event::default().event("beat").data(text)
    }
}

/// A page that is counted until it is dropped.
struct Counted {
    _permit: OwnedSemaphorePermit,
}

impl Counted {
    fn new(permit: OwnedSemaphorePermit) -> Self {
        metrics::gauge(Metric::ConsolePages, &[]).increment(1.0);
        Self { _permit: permit }
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        metrics::gauge(Metric::ConsolePages, &[]).decrement(1.0);
    }
}
