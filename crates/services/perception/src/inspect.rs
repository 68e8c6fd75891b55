//! The actor that answers how placed items lie, from the latest clouds of containers.

use std::collections::BTreeMap;
use std::time::Instant;

use nalgebra::Point3;
use ppnpack_recognition::inspection::{
    ContainerCloud, Inspection, InspectionSettings, Lying, inspect,
};
use ppnpack_recognition::library::{Library, LibraryObject};
use ppnpack_service::actor::{Actor, LatestValues, PendingRequests};
use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::WireError;
use ppnpack_wire::convert::cloud::{CheckedCloud, Cloud};
use ppnpack_wire::convert::{pose, scene};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1::{self, InspectionKind, Status};

use crate::objects::{Objects, PREPARING};
use crate::room::Held;

/// Maximum number of requests that come and that are pending: each holds a heightmap, and a cell's
/// planner makes one at a time.
pub(crate) const MOST_PENDING: usize = 16;

pub(crate) type Message = Incoming<v1::InspectRequest>;

/// The latest cloud of each container that a heightmap was made of. Of several sensors it is one's.
pub(crate) type Clouds = LatestValues<Cell, Held<CheckedCloud>>;

pub(crate) struct Inspections {
    /// `None` where nothing is known that could be placed.
    objects: Option<Objects>,
    settings: InspectionSettings,
    clouds: Clouds,
    latest: BTreeMap<Cell, Held<CheckedCloud>>,
    pending: PendingRequests<Message>,
}

impl Actor for Inspections {
    type Message = Message;

    fn handle(&mut self, mut incoming: Message) {
        incoming.start();
        match self.objects {
            Some(_) => self.pending.keep_or_refuse(incoming),
            None => {
                let message = "perception has no catalogue: set service.catalogue";
                incoming.refuse(Status::NotFound, message);
            }
        }
    }

    fn tick(&mut self) {
        self.latest.append(&mut self.clouds.take());
        let library = self.objects.as_ref().and_then(Objects::get);
        self.pending.refuse_expired(|incoming| {
            let (cell, wanted) = (incoming.cell(), incoming.message().least_state_number);
            match library {
                Some(_) => format!("no cloud of cell {cell} shows its state {wanted} yet"),
                None => PREPARING.to_owned(),
            }
        });
        self.answer();
    }

    fn next_tick(&self) -> Option<Instant> {
        self.pending.next_expiry()
    }
}

impl Inspections {
    pub(crate) fn new(
        objects: Option<&Objects>,
        settings: InspectionSettings,
        clouds: Clouds,
    ) -> Self {
        Self {
            objects: objects.cloned(),
            settings,
            clouds,
            latest: BTreeMap::new(),
            pending: PendingRequests::new(MOST_PENDING),
        }
    }

    /// Answers the requests for no newer cloud than there is, once there are objects. Every cloud
    /// has it look again.
    fn answer(&mut self) {
        let Some(library) = self.objects.as_ref().and_then(Objects::get).cloned() else {
            return;
        };
        let latest = &self.latest;
        let can_be_answered = |incoming: &Message| {
            latest.get(incoming.cell()).is_some_and(|cloud| {
                cloud.cloud().state_number() >= incoming.message().least_state_number
            })
        };
        for incoming in self.pending.take(can_be_answered) {
            if incoming.has_expired() {
                incoming.refuse(Status::TimedOut, "the time limit passed in the queue");
            } else if let Some(cloud) = self.latest.get(incoming.cell()) {
                self.answer_one(incoming, &library, &cloud.cloud());
            }
        }
    }

    fn answer_one(&self, incoming: Message, library: &Library, cloud: &Cloud<'_>) {
        let began = Instant::now();
        let object = &incoming.message().object;
        let mut objects = library.objects.iter();
        let found = match objects.find(|known| known.model.name == *object) {
            Some(object) => self.inspect(incoming.message(), object, cloud),
            // What is not known cannot be found: others can.
            None => {
                let reason = format!("the catalogue has no object '{object}'");
                Ok(without(InspectionKind::Unclear, reason))
            }
        };
        match found {
            Ok(inspection) => {
                let reply = v1::InspectReply {
                    header: None,
                    inspection: Some(inspection),
                    state_number: cloud.state_number(),
                };
                incoming.reply(reply, Done::in_one("inspect", began.elapsed()));
            }
            Err(error) => incoming.refuse(Status::Invalid, error.to_string()),
        }
    }

    fn inspect(
        &self,
        request: &v1::InspectRequest,
        object: &LibraryObject,
        cloud: &Cloud<'_>,
    ) -> Result<v1::Inspection, WireError> {
        let planned = pose::read_required("planned", request.planned.as_ref())?;
        let (grid, before) = scene::read_required("before", request.before.as_ref())?;
        let before = before.surface().ok_or(WireError::Missing {
            field: "before.surface",
        })?;
        let container_from_sensor = cloud.container_from_sensor();
        let points_m = cloud
            .points()
            .map(|point| container_from_sensor * point.cast::<f64>());
        let points_m: Vec<Point3<f64>> = points_m.collect();
        let after = ContainerCloud {
            points_m: &points_m,
            eye_m: container_from_sensor.translation.vector.into(),
        };
        let container = grid.container();
        let found = inspect(object, &planned, before, &after, container, &self.settings);
        Ok(write(&found))
    }
}

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
        Inspection::Unclear(found) => without(InspectionKind::Unclear, found.reason.to_string()),
    }
}

/// Writes that no pose of an item is found, and why.
fn without(kind: InspectionKind, reason: String) -> v1::Inspection {
    v1::Inspection {
        kind: kind.into(),
        reason,
        ..v1::Inspection::default()
    }
}
