//! The actor that answers what lies on the trays of cells, from the latest cloud of each tray.
//!
//! Nothing is looked for until somebody asks.

mod seen;
pub(crate) mod settings;

use std::sync::Arc;
use std::time::{Duration, Instant};

use nalgebra::Point3;
use ppnpack_packing::grid::Resolution;
use ppnpack_recognition::library::Library;
use ppnpack_recognition::recognise::Recogniser;
use ppnpack_recognition::segmentation::{SegmentationSettings, segment};
use ppnpack_service::actor::{Actor, Address, LatestValues, PendingRequests};
use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::convert::cloud::{CheckedCloud, Cloud};
use ppnpack_wire::header;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1::{self, Status};

use crate::counts::{Counts, Fate};
use crate::router::Arrived;
use settings::TraySettings;

/// The most items that one answer has.
const MAX_ITEMS: usize = 64;

/// What the actor is told.
pub(crate) type Message = Incoming<v1::ItemsRequest>;

/// The latest cloud of each tray, by its index.
#[derive(Clone)]
pub(crate) struct Clouds {
    cells: Arc<[Cell]>,
    latest: LatestValues<usize, Arrived>,
    counts: Arc<Counts>,
}

impl Clouds {
    /// Clouds of these trays, which wake the actor at this address.
    pub(crate) fn new(trays: &[Tray], actor: &Address<Message>, counts: Arc<Counts>) -> Self {
        Self {
            cells: trays.iter().map(|tray| tray.cell.clone()).collect(),
            latest: LatestValues::new(actor),
            counts,
        }
    }

    /// Puts a cloud. Runs on Zenoh's thread, and waits for nothing but a lock that is held as briefly.
    pub(crate) fn put(&self, cell: &Cell, cloud: v1::PointCloud) {
        let Some(tray) = self.cells.iter().position(|known| known == cell) else {
            let reason = "the cell has no tray: set service.trays";
            return self.counts.refuse(cell, Fate::Unserved, &reason);
        };
        let at = Instant::now();
        if self.latest.put(tray, Arrived { cloud, at }).is_some() {
            self.counts.count(Fate::Replaced);
        }
    }
}

/// A tray and what was seen of it.
pub(crate) struct Tray {
    cell: Cell,
    segmentation: SegmentationSettings,
    recogniser: Recogniser,
    /// That of the cell's grid.
    resolution: Resolution,
    /// With when it came.
    newest: Option<(CheckedCloud, Instant)>,
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
    fn items(&self, cloud: &Cloud<'_>) -> v1::ItemsReply {
        let container_from_sensor = cloud.container_from_sensor();
        let points = cloud
            .points()
            .map(|point| container_from_sensor * point.cast::<f64>());
        let eye = Point3::from(container_from_sensor.translation.vector);
        let found = segment(points, &eye, &self.segmentation);
        let clusters = found.clusters.iter().take(MAX_ITEMS);
        let items = clusters.map(|cluster| seen::item(cluster, &self.recogniser, &self.resolution));
        v1::ItemsReply {
            header: None,
            items: seen::within_message(items.collect()),
            cloud_sequence: cloud.sequence(),
            captured_at_ns: cloud.captured_at_ns(),
            specks: u32::try_from(found.specks).unwrap_or(u32::MAX),
        }
    }
}

/// Answers what lies on trays.
pub(crate) struct Trays {
    trays: Vec<Tray>,
    clouds: Clouds,
    pending: PendingRequests<Message>,
}

impl Actor for Trays {
    type Message = Message;

    fn handle(&mut self, mut incoming: Message) {
        incoming.start();
        let cell = incoming.cell();
        if self.trays.iter().any(|tray| tray.cell == *cell) {
            self.pending.keep_or_refuse(incoming);
        } else {
            let message = format!("cell {cell} has no tray: set service.trays.{cell}");
            incoming.refuse(Status::NotFound, message);
        }
    }

    fn tick(&mut self) {
        self.take_clouds();
        self.pending.refuse_expired(|incoming| {
            let cell = incoming.cell();
            let tray = self.trays.iter().find(|tray| tray.cell == *cell);
            match tray.and_then(|tray| tray.newest.as_ref()) {
                None => format!("no cloud of the tray of cell {cell} has come"),
                Some((newest, at)) => format!(
                    "no newer cloud of the tray of cell {cell} has come than number {}, {:.1} s ago",
                    newest.cloud().sequence(),
                    at.elapsed().as_secs_f64()
                ),
            }
        });
        self.answer();
    }

    fn next_tick(&self) -> Option<Instant> {
        self.pending.next_expiry()
    }
}

impl Trays {
    /// Keeps at most so many requests pending.
    pub(crate) fn new(trays: Vec<Tray>, clouds: Clouds, most_pending: usize) -> Self {
        Self {
            trays,
            clouds,
            pending: PendingRequests::new(most_pending),
        }
    }

    fn take_clouds(&mut self) {
        for (index, arrived) in self.clouds.latest.take() {
            let Some(tray) = self.trays.get_mut(index) else {
                continue;
            };
            match CheckedCloud::new(arrived.cloud) {
                Ok(cloud) => tray.newest = Some((cloud, arrived.at)),
                Err(error) => {
                    let counts = &self.clouds.counts;
                    counts.refuse(&tray.cell, Fate::Malformed, &error);
                }
            }
        }
    }

    /// Answers all that the newest clouds serve; a cloud is looked at once for all that are pending.
    fn answer(&mut self) {
        for tray in &self.trays {
            let Some((newest, at)) = &tray.newest else {
                continue;
            };
            let cloud = newest.cloud();
            let can_be_answered = |incoming: &Message| {
                *incoming.cell() == tray.cell && is_wanted(cloud.sequence(), *at, incoming)
            };
            let answered = self.pending.take(can_be_answered);
            if answered.is_empty() {
                continue;
            }
            let began = Instant::now();
            let found = tray.items(&cloud);
            for incoming in answered {
                reply(incoming, &found, began.elapsed());
            }
        }
    }
}

/// Whether a cloud of this number that came then is one of those that are wanted.
fn is_wanted(sequence: u64, at: Instant, incoming: &Message) -> bool {
    match incoming.message().least_sequence {
        0 => at > incoming.received(),
        least => sequence >= least,
    }
}

fn reply(incoming: Message, found: &v1::ItemsReply, took: Duration) {
    let done = Done {
        stages: vec![header::stage("recognise", took)],
        ..Done::default()
    };
    incoming.reply(found.clone(), done);
}
