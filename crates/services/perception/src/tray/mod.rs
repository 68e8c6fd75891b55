//! What lies on the trays of cells: one thread that answers who asks, from the newest cloud of each tray.
//!
//! Nothing is looked for until somebody asks: clouds are put on a shelf, where newer ones replace them.

mod seen;
mod settings;

use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use nalgebra::Point3;
use ppnpack_packing::grid::Resolution;
use ppnpack_recognition::library::Library;
use ppnpack_recognition::recognise::Recogniser;
use ppnpack_recognition::segmentation::{SegmentationSettings, segment};
use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::convert::cloud;
use ppnpack_wire::header;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1::{self, Status};

use crate::counts::{Counts, Fate};
pub use settings::TraySettings;

/// The most items that one answer has.
const MAX_ITEMS: usize = 64;

/// Who waits is answered so long before the time limit passes, or a tenth of it, that the answer still comes in time.
const ANSWER_BEFORE: Duration = Duration::from_millis(20);

/// Nobody waits.
const LONG: Duration = Duration::from_secs(3600);

/// What comes to the thread.
pub(crate) enum Mail {
    /// Somebody wants to know what lies on a tray.
    Request(Incoming<v1::ItemsRequest>),
    /// There is a cloud on the shelf.
    Cloud,
}

/// The newest cloud of each tray that was not looked at.
type Shelf = Arc<Mutex<Vec<Option<Arrived>>>>;

/// Where clouds of trays are put.
#[derive(Clone)]
pub(crate) struct Inlet {
    cells: Arc<[Cell]>,
    shelf: Shelf,
    bell: SyncSender<Mail>,
}

struct Arrived {
    cloud: v1::PointCloud,
    at: Instant,
}

impl Inlet {
    /// Whoever works on the mailbox that `bell` leads to looks at the shelf.
    pub(crate) fn new(trays: &Trays, bell: SyncSender<Mail>) -> Self {
        Self {
            cells: trays.trays.iter().map(|tray| tray.cell.clone()).collect(),
            shelf: Arc::clone(&trays.shelf),
            bell,
        }
    }

    /// Puts a cloud. Runs on Zenoh's thread, and waits for nothing but a lock that is held as briefly.
    pub(crate) fn put(&self, cell: &Cell, cloud: v1::PointCloud) {
        let Some(tray) = self.cells.iter().position(|known| known == cell) else {
            return;
        };
        let at = Instant::now();
        let mut shelf = self.shelf.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(place) = shelf.get_mut(tray) {
            *place = Some(Arrived { cloud, at });
        }
        drop(shelf);
        // After whatever else fills the mailbox, the shelf is looked at all the same.
        self.bell.try_send(Mail::Cloud).ok();
    }
}

/// A tray and what was seen of it.
pub(crate) struct Tray {
    cell: Cell,
    segmentation: SegmentationSettings,
    recogniser: Recogniser,
    /// That of the cell's grid.
    resolution: Resolution,
    newest: Option<Arrived>,
}

impl Tray {
    pub(crate) fn new(
        cell: Cell,
        settings: &TraySettings,
        library: &Arc<Library>,
        resolution: Resolution,
    ) -> Self {
        Self {
            cell,
            segmentation: settings.segmentation,
            recogniser: Recogniser::new(Arc::clone(library), settings.recognition),
            resolution,
            newest: None,
        }
    }

    /// What a cloud shows.
    fn items(&self, cloud: &v1::PointCloud) -> Result<v1::ItemsReply, ppnpack_wire::WireError> {
        let read = cloud::read(cloud)?;
        let container_from_sensor = read.container_from_sensor();
        let points = read
            .points()
            .map(|point| container_from_sensor * point.cast::<f64>());
        let eye = Point3::from(container_from_sensor.translation.vector);
        let found = segment(points, &eye, &self.segmentation);
        let clusters = found.clusters.iter().take(MAX_ITEMS);
        let items = clusters.map(|cluster| seen::item(cluster, &self.recogniser, &self.resolution));
        Ok(v1::ItemsReply {
            header: None,
            items: items.collect(),
            cloud_sequence: read.sequence(),
            captured_at_ns: read.captured_at_ns(),
            specks: u32::try_from(found.specks).unwrap_or(u32::MAX),
        })
    }
}

/// Somebody who waits.
struct Waiting {
    tray: usize,
    since: Instant,
    incoming: Incoming<v1::ItemsRequest>,
}

impl Waiting {
    /// Whether a cloud is one of those that are wanted.
    fn is_served_by(&self, arrived: &Arrived) -> bool {
        match self.incoming.message().least_sequence {
            0 => arrived.at > self.since,
            least => arrived.cloud.sequence >= least,
        }
    }

    /// When it has to be answered.
    fn last_moment(&self) -> Instant {
        self.incoming.deadline() - ANSWER_BEFORE.min(self.incoming.header().time_limit / 10)
    }
}

/// Answers what lies on trays.
pub(crate) struct Trays {
    trays: Vec<Tray>,
    shelf: Shelf,
    waiting: Vec<Waiting>,
    /// How many may wait.
    most: usize,
    counts: Arc<Counts>,
}

impl Trays {
    pub(crate) fn new(trays: Vec<Tray>, most: usize, counts: Arc<Counts>) -> Self {
        let shelf = trays.iter().map(|_| None).collect();
        Self {
            trays,
            shelf: Arc::new(Mutex::new(shelf)),
            waiting: Vec::new(),
            most,
            counts,
        }
    }

    /// Works until nothing more can come.
    pub(crate) fn run(mut self, mail: &Receiver<Mail>) {
        loop {
            match mail.recv_timeout(self.pause()) {
                Ok(Mail::Request(incoming)) => self.keep(incoming),
                Ok(Mail::Cloud) | Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            self.look_at_shelf();
            self.answer();
            self.give_up_waiting();
        }
    }

    fn keep(&mut self, mut incoming: Incoming<v1::ItemsRequest>) {
        incoming.start();
        let cell = incoming.cell();
        let Some(tray) = self.trays.iter().position(|tray| tray.cell == *cell) else {
            let message = format!("cell {cell} has no tray: set service.trays.{cell}");
            return incoming.refuse(Status::NotFound, message);
        };
        if self.waiting.len() >= self.most {
            return incoming.refuse(Status::Busy, "too many wait for trays");
        }
        let since = Instant::now();
        self.waiting.push(Waiting {
            tray,
            since,
            incoming,
        });
    }

    fn look_at_shelf(&mut self) {
        let mut shelf = self.shelf.lock().unwrap_or_else(PoisonError::into_inner);
        let arrived: Vec<Option<Arrived>> = shelf.iter_mut().map(Option::take).collect();
        drop(shelf);
        for (tray, arrived) in self.trays.iter_mut().zip(arrived) {
            let Some(arrived) = arrived else {
                continue;
            };
            match cloud::read(&arrived.cloud) {
                Ok(_) => tray.newest = Some(arrived),
                Err(error) => self.counts.refuse(&tray.cell, Fate::Malformed, &error),
            }
        }
    }

    /// Answers all that the newest clouds serve; each cloud is looked at once.
    fn answer(&mut self) {
        for (index, tray) in self.trays.iter().enumerate() {
            let Some(newest) = &tray.newest else {
                continue;
            };
            let is_served =
                |waiting: &mut Waiting| waiting.tray == index && waiting.is_served_by(newest);
            let served: Vec<Waiting> = self.waiting.extract_if(.., is_served).collect();
            if served.is_empty() {
                continue;
            }
            let began = Instant::now();
            let found = tray.items(&newest.cloud);
            for waiting in served {
                reply(waiting.incoming, &found, began.elapsed());
            }
        }
    }

    fn pause(&self) -> Duration {
        let first = self.waiting.iter().map(Waiting::last_moment).min();
        first.map_or(LONG, |first| {
            first.saturating_duration_since(Instant::now())
        })
    }

    /// Answers those whose time limit passed.
    fn give_up_waiting(&mut self) {
        let now = Instant::now();
        let is_late = |waiting: &mut Waiting| waiting.last_moment() <= now;
        for waiting in self.waiting.extract_if(.., is_late) {
            let tray = self.trays.get(waiting.tray);
            let newest = tray.and_then(|tray| tray.newest.as_ref());
            let cell = waiting.incoming.cell();
            let message = match newest {
                None => format!("no cloud of the tray of cell {cell} has come"),
                Some(newest) => format!(
                    "no newer cloud of the tray of cell {cell} has come than number {}, {:.1} s ago",
                    newest.cloud.sequence,
                    newest.at.elapsed().as_secs_f64()
                ),
            };
            waiting.incoming.refuse(Status::TimedOut, message);
        }
    }
}

fn reply(
    incoming: Incoming<v1::ItemsRequest>,
    found: &Result<v1::ItemsReply, ppnpack_wire::WireError>,
    took: Duration,
) {
    match found {
        Ok(found) => {
            let stages = vec![header::stage("recognise", took)];
            incoming.reply(
                found.clone(),
                Done {
                    stages,
                    ..Done::default()
                },
            );
        }
        Err(error) => incoming.refuse(Status::Failed, error.to_string()),
    }
}
