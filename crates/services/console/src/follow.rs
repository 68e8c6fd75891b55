//! Subscriptions of the cells, and the actor that folds what they bring into the picture.

use std::sync::Arc;
use std::time::{Duration, Instant};

use ppnpack_service::ServiceError;
use ppnpack_service::actor::{Actor, Address, LatestValues};
use ppnpack_service::stream::{self, Subscription};
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::{MAX_MESSAGE_BYTES, v1};
use prost::{Message, Name};
use zenoh::Session;

use crate::board::Board;
use crate::directory::Directory;
use crate::now_ms;
use crate::picture::{News, SeenContainer};
use crate::shapes::Wanted;

/// How often heightmaps are looked at: sensors may send them faster than anybody sees.
const LOOK: Duration = Duration::from_millis(500);

/// How often shapes are asked for whose volumes should be known and are not.
const ASKED_EVERY: Duration = Duration::from_secs(10);

/// News of a cell or a container that counts whatever comes after it.
pub(crate) type FollowerMessage = (Cell, News);

/// The newest sessions and states: older ones are left out.
pub(crate) type Newest = LatestValues<(Cell, Stream), News>;

/// The newest heightmap of each container, and when it was made, in milliseconds since 1970.
pub(crate) type Heightmaps = LatestValues<Cell, (u64, Box<v1::Heightmap>)>;

/// The actor that folds news into the picture, and puts that on the board.
pub(crate) struct Follower {
    board: Arc<Board>,
    directory: Arc<Directory>,
    newest: Newest,
    heightmaps: Heightmaps,
    /// The next time that heightmaps are looked at, and ages are told anew.
    next_look: Instant,
    /// The next time that shapes are asked for whose volumes are not known.
    next_asking: Instant,
    /// Whether the board lacks something.
    is_changed: bool,
    prefetcher: Address<Wanted>,
}

impl Follower {
    pub(crate) fn new(
        board: Arc<Board>,
        directory: Arc<Directory>,
        inboxes: &Inboxes,
        prefetcher: Address<Wanted>,
    ) -> Self {
        Self {
            board,
            directory,
            newest: inboxes.newest.clone(),
            heightmaps: inboxes.heightmaps.clone(),
            next_look: Instant::now(),
            next_asking: Instant::now(),
            is_changed: false,
            prefetcher,
        }
    }

    fn apply(&mut self, at_ms: u64, of: &Cell, news: News) {
        let wanted = self
            .directory
            .change(|picture| picture.apply(at_ms, of, news));
        self.ask(wanted);
    }

    fn ask(&self, wanted: impl IntoIterator<Item = Wanted>) {
        for wanted in wanted {
            if !self.prefetcher.try_send(wanted) {
                tracing::debug!("shapes are asked for later");
            }
        }
    }

    /// Asks for shapes that were not to be had before, or that no record named.
    fn ask_again(&mut self, now: Instant) {
        if self.next_asking <= now {
            self.next_asking = now + ASKED_EVERY;
            let missing = self.directory.picture().missing();
            self.ask(missing);
        }
    }

    fn look(&mut self) {
        for (container, (made_ms, heightmap)) in self.heightmaps.take() {
            // A network may mix keys up for a moment, as routers restart.
            if !heightmap.cell.is_empty() && heightmap.cell != container.as_str() {
                continue;
            }
            match SeenContainer::read(&heightmap) {
                Ok(seen) => self.apply(made_ms, &container, News::Seen(Box::new(seen))),
                Err(error) => tracing::debug!(%container, %error, "a heightmap cannot be read"),
            }
            self.directory
                .picture()
                .show_heightmap(&self.board, &container);
        }
    }
}

impl Actor for Follower {
    type Message = FollowerMessage;

    fn handle(&mut self, (cell, news): FollowerMessage) {
        self.is_changed = true;
        self.apply(now_ms(), &cell, news);
    }

    fn tick(&mut self) {
        for ((cell, _), news) in self.newest.take() {
            self.apply(now_ms(), &cell, news);
            self.is_changed = true;
        }
        let now = Instant::now();
        if self.next_look <= now {
            self.next_look = now + LOOK;
            self.look();
            self.ask_again(now);
            self.is_changed = true;
        }
        if std::mem::take(&mut self.is_changed) {
            self.directory.picture().show(&self.board, now_ms());
        }
    }

    fn next_tick(&self) -> Option<Instant> {
        Some(self.next_look)
    }
}

pub(crate) struct Inboxes {
    pub(crate) newest: Newest,
    pub(crate) heightmaps: Heightmaps,
    pub(crate) follower: Address<FollowerMessage>,
}

impl Inboxes {
    /// Subscribes these cells, or all where none is named.
    ///
    /// # Errors
    /// [`ServiceError::Zenoh`] where the session is closed.
    pub(crate) fn hear(
        &self,
        session: &Session,
        cells: &[Cell],
    ) -> Result<Vec<Subscription>, ServiceError> {
        let mut subscriptions = Vec::new();
        for cell in stream::each_or_all(cells) {
            let heightmaps = self.heightmaps.clone();
            let see = move |container, heightmap: v1::Heightmap| {
                heightmaps.put(container, (now_ms(), Box::new(heightmap)));
            };
            let of = (session, cell);
            subscriptions.extend([
                self.newest(of, Stream::Session, |it| News::Session(Box::new(it)))?,
                self.newest(of, Stream::State, |it| News::State(Box::new(it)))?,
                self.each(of, Stream::Record, |it| News::Record(Box::new(named(it))))?,
                self.each(of, Stream::Plan, |it| News::Decision(Box::new(it)))?,
                self.each(of, Stream::Outcome, |it| News::Outcome(Box::new(it)))?,
                subscribe(of, Stream::Heightmap, see)?,
            ]);
        }
        Ok(subscriptions)
    }

    /// Subscribes a stream of which the newest message alone counts.
    fn newest<M: Message + Name + Default + 'static>(
        &self,
        of: Of<'_>,
        stream: Stream,
        wrap: fn(M) -> News,
    ) -> Result<Subscription, ServiceError> {
        let newest = self.newest.clone();
        subscribe(of, stream, move |cell, message| {
            newest.put((cell, stream), wrap(message));
        })
    }

    /// Subscribes a stream of which each message counts.
    fn each<M: Message + Name + Default + 'static>(
        &self,
        of: Of<'_>,
        stream: Stream,
        wrap: fn(M) -> News,
    ) -> Result<Subscription, ServiceError> {
        let follower = self.follower.clone();
        subscribe(of, stream, move |cell, message| {
            if !follower.try_send((cell, wrap(message))) {
                tracing::debug!(%stream, "a message did not fit into the mailbox");
            }
        })
    }
}

/// The session, and the cell whose streams are subscribed, or `None` for all.
type Of<'a> = (&'a Session, Option<&'a Cell>);

fn subscribe<M: Message + Name + Default + 'static>(
    (session, cell): Of<'_>,
    stream: Stream,
    on_message: impl Fn(Cell, M) + Send + Sync + 'static,
) -> Result<Subscription, ServiceError> {
    stream::subscribe(session, cell, stream, MAX_MESSAGE_BYTES, on_message)
}

/// Strips a record to the shapes that it names: records wait in the mailbox, and a whole one is
/// large.
fn named(record: v1::PlanningRecord) -> v1::PlanningRecord {
    v1::PlanningRecord {
        session_id: record.session_id,
        items: record.items,
        candidates: record.candidates,
        ..v1::PlanningRecord::default()
    }
}
