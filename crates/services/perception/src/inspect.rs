//! How placed items lie: one thread that answers from the newest clouds of containers.

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use nalgebra::Point3;
use ppnpack_recognition::inspection::{
    ContainerCloud, Inspection, InspectionSettings, Lying, inspect,
};
use ppnpack_recognition::library::{Library, LibraryObject};
use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::convert::{cloud, pose, scene};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1::{self, InspectionKind, Status};
use ppnpack_wire::{WireError, header};

use crate::waiting::{Bell, Waiting};

/// Requests that come and that wait at most: each holds a heightmap, and a cell's planner makes one at a time.
pub(crate) const MOST_WAITING: usize = 16;

/// What is said where nothing can be found.
const NO_CATALOGUE: &str = "perception has no catalogue: set service.catalogue";

/// What comes to the thread.
pub(crate) type Mail = crate::waiting::Mail<v1::InspectRequest>;

/// The newest cloud of each container that a heightmap was made of. Of several sensors it is one's.
type Newest = Arc<Mutex<BTreeMap<Cell, Arc<v1::PointCloud>>>>;

/// Where clouds are put.
#[derive(Clone)]
pub(crate) struct Inlet {
    newest: Newest,
    bell: Bell<v1::InspectRequest>,
}

impl Inlet {
    pub(crate) fn put(&self, cell: &Cell, cloud: v1::PointCloud) {
        let mut newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        newest.insert(cell.clone(), Arc::new(cloud));
        drop(newest);
        self.bell.ring();
    }
}

/// Answers how placed items lie.
pub(crate) struct Inspections {
    /// `None` where nothing is known that could be placed.
    library: Option<Arc<Library>>,
    settings: InspectionSettings,
    newest: Newest,
    waiting: Waiting<v1::InspectRequest>,
}

impl Inspections {
    pub(crate) fn new(library: Option<&Arc<Library>>, settings: InspectionSettings) -> Self {
        Self {
            library: library.cloned(),
            settings,
            newest: Newest::default(),
            waiting: Waiting::new(MOST_WAITING),
        }
    }

    /// Where clouds are put, if they are of use; `mailbox` is that of the thread that works on these.
    pub(crate) fn inlet(&self, mailbox: SyncSender<Mail>) -> Option<Inlet> {
        self.library.as_ref().map(|_| Inlet {
            newest: Arc::clone(&self.newest),
            bell: Bell::new(mailbox, &self.waiting),
        })
    }

    /// Works until nothing more can come.
    pub(crate) fn run(mut self, mail: &Receiver<Mail>) {
        loop {
            match mail.recv_timeout(self.waiting.pause()) {
                Ok(Mail::Request(mut incoming)) => {
                    incoming.start();
                    match self.library {
                        Some(_) => self.waiting.keep(*incoming),
                        None => incoming.refuse(Status::NotFound, NO_CATALOGUE),
                    }
                }
                Ok(Mail::Clouds) | Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            self.answer();
            self.give_up_waiting();
        }
    }

    /// Answers those who want no newer cloud than there is.
    fn answer(&mut self) {
        self.waiting.has_heard();
        // Cheap, and not locked while an item is looked for.
        let newest = {
            let newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
            newest.clone()
        };
        let is_served = |incoming: &Incoming<v1::InspectRequest>| {
            newest
                .get(incoming.cell())
                .is_some_and(|cloud| cloud.state_number >= incoming.message().least_state_number)
        };
        for incoming in self.waiting.take(is_served) {
            if incoming.has_expired() {
                incoming.refuse(Status::TimedOut, "the time limit passed in the queue");
            } else if let Some(cloud) = newest.get(incoming.cell()) {
                self.answer_one(incoming, cloud);
            }
        }
    }

    fn answer_one(&self, incoming: Incoming<v1::InspectRequest>, cloud: &v1::PointCloud) {
        let began = Instant::now();
        let object = &incoming.message().object;
        let mut objects = self.library.iter().flat_map(|library| &library.objects);
        let Some(object) = objects.find(|known| known.model.name == *object) else {
            let message = format!("the catalogue has no object '{object}'");
            return incoming.refuse(Status::NotFound, message);
        };
        match self.inspect(incoming.message(), object, cloud) {
            Ok(inspection) => {
                let reply = v1::InspectReply {
                    header: None,
                    inspection: Some(inspection),
                    state_number: cloud.state_number,
                };
                let stages = vec![header::stage("inspect", began.elapsed())];
                incoming.reply(
                    reply,
                    Done {
                        stages,
                        ..Done::default()
                    },
                );
            }
            Err(error) => incoming.refuse(Status::Invalid, error.to_string()),
        }
    }

    fn inspect(
        &self,
        request: &v1::InspectRequest,
        object: &LibraryObject,
        cloud: &v1::PointCloud,
    ) -> Result<v1::Inspection, WireError> {
        let planned = pose::read_required("planned", request.planned.as_ref())?;
        let (grid, before) = scene::read_required("before", request.before.as_ref())?;
        let before = before.surface().ok_or(WireError::Missing {
            field: "before.surface",
        })?;
        let read = cloud::read(cloud)?;
        let container_from_sensor = read.container_from_sensor();
        let points_m: Vec<Point3<f64>> = read
            .points()
            .map(|point| container_from_sensor * point.cast::<f64>())
            .collect();
        let after = ContainerCloud {
            points_m: &points_m,
            eye_m: container_from_sensor.translation.vector.into(),
        };
        let container = grid.container();
        let found = inspect(object, &planned, before, &after, container, &self.settings);
        Ok(write(&found))
    }

    /// Answers those whose time limit passed.
    fn give_up_waiting(&mut self) {
        for incoming in self.waiting.take_expired() {
            let (cell, wanted) = (incoming.cell(), incoming.message().least_state_number);
            let message = format!("no cloud of cell {cell} shows its state {wanted} yet");
            incoming.refuse(Status::TimedOut, message);
        }
    }
}

/// A finding as a message.
fn write(found: &Inspection) -> v1::Inspection {
    let lying = |kind: InspectionKind, lying: &Lying| v1::Inspection {
        kind: kind.into(),
        container_from_item: Some(pose::write(&lying.container_from_item)),
        slide_m: lying.slide_m,
        tilt_rad: lying.tilt_rad,
        is_inside: lying.is_inside,
        fitness: lying.agreement.fitness,
        reason: String::new(),
    };
    let without = |kind: InspectionKind, reason: String| v1::Inspection {
        kind: kind.into(),
        reason,
        ..v1::Inspection::default()
    };
    match found {
        Inspection::AsPlanned(found) => lying(InspectionKind::AsPlanned, found),
        Inspection::Moved(found) => lying(InspectionKind::Moved, found),
        Inspection::Toppled(found) => lying(InspectionKind::Toppled, found),
        Inspection::Missing(absence) => {
            let (new_cm2, least_cm2) = (absence.new_m2 * 1e4, absence.least_m2 * 1e4);
            let reason = format!(
                "it is not seen in the container, and nothing there could hide it: {new_cm2:.1} cm2 is new where it would show at least {least_cm2:.1}"
            );
            without(InspectionKind::Missing, reason)
        }
        Inspection::Unclear(unclear) => {
            without(InspectionKind::Unclear, unclear.reason.to_string())
        }
    }
}
