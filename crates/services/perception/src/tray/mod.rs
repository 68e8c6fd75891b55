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
use crate::waiting::{Bell, Waiting};
pub use settings::TraySettings;

/// The most items that one answer has.
const MAX_ITEMS: usize = 64;

/// What comes to the thread.
pub(crate) type Mail = crate::waiting::Mail<v1::ItemsRequest>;

/// The newest cloud of each tray that was not looked at.
type Shelf = Arc<Mutex<Vec<Option<Arrived>>>>;

/// Where clouds of trays are put.
#[derive(Clone)]
pub(crate) struct Inlet {
    cells: Arc<[Cell]>,
    shelf: Shelf,
    bell: Bell<v1::ItemsRequest>,
    counts: Arc<Counts>,
}

struct Arrived {
    cloud: v1::PointCloud,
    at: Instant,
}

impl Inlet {
    /// Of trays whose thread works on this mailbox.
    pub(crate) fn new(trays: &Trays, mailbox: SyncSender<Mail>) -> Self {
        Self {
            cells: trays.trays.iter().map(|tray| tray.cell.clone()).collect(),
            shelf: Arc::clone(&trays.shelf),
            bell: Bell::new(mailbox, &trays.waiting),
            counts: Arc::clone(&trays.counts),
        }
    }

    /// Puts a cloud. Runs on Zenoh's thread, and waits for nothing but a lock that is held as briefly.
    pub(crate) fn put(&self, cell: &Cell, cloud: v1::PointCloud) {
        let Some(tray) = self.cells.iter().position(|known| known == cell) else {
            let reason = "the cell has no tray: set service.trays";
            return self.counts.refuse(cell, Fate::Unserved, &reason);
        };
        let at = Instant::now();
        let mut shelf = self.shelf.lock().unwrap_or_else(PoisonError::into_inner);
        let place = shelf.get_mut(tray);
        let replaced = place.and_then(|place| place.replace(Arrived { cloud, at }));
        drop(shelf);
        if replaced.is_some() {
            self.counts.count(Fate::Replaced);
        }
        self.bell.ring();
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
            items: seen::within_message(items.collect()),
            cloud_sequence: read.sequence(),
            captured_at_ns: read.captured_at_ns(),
            specks: u32::try_from(found.specks).unwrap_or(u32::MAX),
        })
    }
}

/// Answers what lies on trays.
pub(crate) struct Trays {
    trays: Vec<Tray>,
    shelf: Shelf,
    waiting: Waiting<v1::ItemsRequest>,
    counts: Arc<Counts>,
}

impl Trays {
    pub(crate) fn new(trays: Vec<Tray>, most: usize, counts: Arc<Counts>) -> Self {
        let shelf = trays.iter().map(|_| None).collect();
        Self {
            trays,
            shelf: Arc::new(Mutex::new(shelf)),
            waiting: Waiting::new(most),
            counts,
        }
    }

    /// Works until nothing more can come.
    pub(crate) fn run(mut self, mail: &Receiver<Mail>) {
        loop {
            match mail.recv_timeout(self.waiting.pause()) {
                Ok(Mail::Request(incoming)) => self.keep(*incoming),
                Ok(Mail::Clouds) | Err(RecvTimeoutError::Timeout) => {}
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
        if self.trays.iter().any(|tray| tray.cell == *cell) {
            self.waiting.keep(incoming);
        } else {
            let message = format!("cell {cell} has no tray: set service.trays.{cell}");
            incoming.refuse(Status::NotFound, message);
        }
    }

    fn look_at_shelf(&mut self) {
        self.waiting.has_heard();
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

    /// Answers all that the newest clouds serve; a cloud is looked at once for all that wait.
    fn answer(&mut self) {
        for tray in &self.trays {
            let Some(newest) = &tray.newest else {
                continue;
            };
            let served = self
                .waiting
                .take(|incoming| *incoming.cell() == tray.cell && is_wanted(newest, incoming));
            if served.is_empty() {
                continue;
            }
            let began = Instant::now();
            let found = tray.items(&newest.cloud);
            for incoming in served {
                reply(incoming, &found, began.elapsed());
            }
        }
    }

    /// Answers those whose time limit passed.
    fn give_up_waiting(&mut self) {
        for incoming in self.waiting.take_expired() {
            let cell = incoming.cell();
            let tray = self.trays.iter().find(|tray| tray.cell == *cell);
            let message = match tray.and_then(|tray| tray.newest.as_ref()) {
                None => format!("no cloud of the tray of cell {cell} has come"),
                Some(newest) => format!(
                    "no newer cloud of the tray of cell {cell} has come than number {}, {:.1} s ago",
                    newest.cloud.sequence,
                    newest.at.elapsed().as_secs_f64()
                ),
            };
            incoming.refuse(Status::TimedOut, message);
        }
    }
}

/// Whether a cloud is one of those that are wanted.
fn is_wanted(arrived: &Arrived, incoming: &Incoming<v1::ItemsRequest>) -> bool {
    match incoming.message().least_sequence {
        0 => arrived.at > incoming.received(),
        least => arrived.cloud.sequence >= least,
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
