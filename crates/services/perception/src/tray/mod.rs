//! The actor that answers what lies on the trays of cells, from the latest cloud of each tray.
//!
//! Nothing is looked for until somebody asks.

mod seen;
pub(crate) mod settings;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use nalgebra::Point3;
use ppnpack_packing::kernel::grid::Resolution;
use ppnpack_recognition::library::Library;
use ppnpack_recognition::recognise::{Recogniser, RecognitionSettings};
use ppnpack_recognition::segmentation::{SegmentationSettings, segment};
use ppnpack_service::actor::{Actor, Address, LatestValues, PendingRequests};
use ppnpack_service::clock::Boottime;
use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_service::stream::Arrived;
use ppnpack_wire::convert::cloud::{CheckedCloud, Cloud};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1::{self, Status};

use crate::counts::{Counts, Fate};
use crate::delay::Delays;
use crate::objects::{Objects, PREPARING};
use crate::room::Held;
use settings::TraySettings;

const MAX_ITEMS: usize = 64;

pub(crate) type Message = Incoming<v1::ItemsRequest>;

#[derive(Clone)]
pub(crate) struct Clouds {
    cells: Arc<[Cell]>,
    latest: LatestValues<Cell, Arrived<Held<v1::PointCloud>>>,
    counts: Arc<Counts>,
}

impl Clouds {
    /// Makes clouds of these trays, which wake the actor at this address.
    pub(crate) fn new(
        trays: &BTreeMap<Cell, Tray>,
        actor: &Address<Message>,
        counts: Arc<Counts>,
    ) -> Self {
        Self {
            cells: trays.keys().cloned().collect(),
            latest: LatestValues::new(actor),
            counts,
        }
    }

    /// Puts a cloud. Runs on Zenoh's thread, and waits for nothing but a lock that is held as
    /// briefly.
    pub(crate) fn put(&self, cell: &Cell, cloud: Held<v1::PointCloud>) {
        if !self.cells.contains(cell) {
            let reason = "the cell has no tray: set service.trays";
            return self.counts.refuse(cell, Fate::Unserved, &reason);
        }
        let replaced = self.latest.put(cell.clone(), Arrived::now(cloud));
        if replaced.is_some() {
            self.counts.count(Fate::Replaced);
        }
    }
}

pub(crate) struct Tray {
    segmentation: SegmentationSettings,
    recognition: RecognitionSettings,
    objects: Objects,
    resolution: Resolution,
    delays: Delays,
    newest: Option<Arrived<Held<CheckedCloud>>>,
}

impl Tray {
    pub(crate) fn new(settings: &TraySettings, objects: &Objects, resolution: Resolution) -> Self {
        Self {
            segmentation: settings.segmentation,
            recognition: settings.recognition,
            objects: objects.clone(),
            resolution,
            delays: Delays::default(),
            newest: None,
        }
    }

    fn items(&self, library: &Arc<Library>, cloud: &Cloud<'_>) -> v1::ItemsReply {
        let recogniser = Recogniser::new(Arc::clone(library), self.recognition);
        let container_from_sensor = cloud.container_from_sensor();
        let points = cloud
            .points()
            .map(|point| container_from_sensor * point.cast::<f64>());
        let eye = Point3::from(container_from_sensor.translation.vector);
        let found = segment(points, &eye, &self.segmentation);
        let clusters = found.clusters.iter().take(MAX_ITEMS);
        let items = clusters.map(|cluster| seen::item(cluster, &recogniser, &self.resolution));
        v1::ItemsReply {
            header: None,
            items: seen::within_message(items.collect()),
            cloud_sequence: cloud.sequence(),
            captured_at_ns: cloud.captured_at_ns(),
            specks: u32::try_from(found.specks).unwrap_or(u32::MAX),
        }
    }
}

pub(crate) struct Trays {
    trays: BTreeMap<Cell, Tray>,
    clouds: Clouds,
    pending: PendingRequests<Message>,
}

impl Actor for Trays {
    type Message = Message;

    fn handle(&mut self, mut incoming: Message) {
        incoming.start();
        let cell = incoming.cell();
        match self.trays.get(cell).map(|tray| tray.objects.get()) {
            Some(Some(_)) => self.pending.keep_or_refuse(incoming),
            Some(None) => incoming.refuse(Status::Unavailable, PREPARING),
            None => {
                let message = format!("cell {cell} has no tray: set service.trays.{cell}");
                incoming.refuse(Status::NotFound, message);
            }
        }
    }

    fn tick(&mut self) {
        self.take_clouds();
        self.pending.refuse_expired(|incoming| {
            let cell = incoming.cell();
            let tray = self.trays.get(cell);
            match tray.and_then(|tray| tray.newest.as_ref()) {
                None => format!("no cloud of the tray of cell {cell} has come"),
                Some(newest) => format!(
                    "no newer cloud of the tray of cell {cell} has come than number {}, {:.1} s ago",
                    newest.message.cloud().sequence(),
                    newest.at.elapsed().as_secs_f64()
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
    pub(crate) fn new(trays: BTreeMap<Cell, Tray>, clouds: Clouds, most_pending: usize) -> Self {
        Self {
            trays,
            clouds,
            pending: PendingRequests::new(most_pending),
        }
    }

    fn take_clouds(&mut self) {
        for (cell, arrived) in self.clouds.latest.take() {
            let Some(tray) = self.trays.get_mut(&cell) else {
                continue;
            };
            let read = arrived.map(|cloud| cloud.read(CheckedCloud::new));
            match read.transpose() {
                Ok(newest) => {
                    let captured_at_ns = newest.message.cloud().captured_at_ns();
                    let at = tray.delays.undelayed(captured_at_ns, newest.at);
                    tray.newest = Some(Arrived { at, ..newest });
                }
                Err(error) => self.clouds.counts.refuse(&cell, Fate::Malformed, &error),
            }
        }
    }

    /// Answers all requests that the newest clouds serve; a cloud is looked at once for all that
    /// are pending.
    fn answer(&mut self) {
        for (cell, tray) in &self.trays {
            let (Some(newest), Some(library)) = (&tray.newest, tray.objects.get()) else {
                continue;
            };
            let cloud = newest.message.cloud();
            let can_be_answered = |incoming: &Message| {
                incoming.cell() == cell && is_wanted(cloud.sequence(), newest.at, incoming)
            };
            let answered = self.pending.take(can_be_answered);
            if answered.is_empty() {
                continue;
            }
            let began = Instant::now();
            let found = tray.items(library, &cloud);
            for incoming in answered {
                incoming.reply(found.clone(), Done::in_one("recognise", began.elapsed()));
            }
        }
    }
}

/// Says whether a cloud of this number that came then is one of those that are wanted.
fn is_wanted(sequence: u64, at: Boottime, incoming: &Message) -> bool {
    match incoming.message().least_sequence {
        0 => at > incoming.came(),
        least => sequence >= least,
    }
}
