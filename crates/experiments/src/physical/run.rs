//! One run: objects come to the tray, are recognised, planned and placed, until none waits.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Context;
use nalgebra::{Isometry3, Point2};
use ppnpack_catalogue::object::Model;
use ppnpack_service::clock::now_ns;
use ppnpack_service::rpc::CallError;
use ppnpack_wire::convert::cloud::{self, Capture};
use ppnpack_wire::convert::pose;
use ppnpack_wire::keys::{Key, Stream};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::{self, InspectionKind, OutcomeKind, PlanResult, Status};
use prost::Message;
use zenoh::Wait;
use zenoh::qos::CongestionControl;

use super::World;
use super::record::{DecisionRecord, End, Found, ItemRecord, RunRecord, SeenAs};
use super::tray::{Lying, Tray};
use ppnpack_cli::failure::{Failure, OrRun, Outcome};
use ppnpack_cli::stack::Stack;
use ppnpack_cli::stack::controller::{Controller, REQUEST_LIMIT};
use ppnpack_cli::stack::report::{arrival_of, item_id};

/// Attempts at one item.
const MAX_ATTEMPTS: u32 = 5;

/// How long a plan may wait for a heightmap that can be trusted.
const PLAN_LIMIT: Duration = Duration::from_secs(10);

/// How long an inspection may take, and how often it is looked for.
const INSPECTION_LIMIT: Duration = Duration::from_secs(6);
const POLL: Duration = Duration::from_millis(2);

/// Maximum distance from an object's centre of mass of what is seen of it, from above, in metres.
const SAME_M: f64 = 0.06;

pub(super) struct Case {
    pub(super) session_id: String,
    pub(super) seeds: Seeds,
    /// Indices into the catalogue, in their order of arrival.
    pub(super) objects: Vec<usize>,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Seeds {
    /// Seed of how objects come to lie on the tray, and of the noise of its camera.
    pub(super) tray: u64,
    /// How far from where it should be the arm releases an item.
    pub(super) release: u64,
    /// The noise of the container's camera.
    pub(super) camera: u64,
    /// Picks that miss, and items that are dropped.
    pub(super) faults: u64,
}

pub(super) struct Done {
    pub(super) record: RunRecord,
    pub(super) state: v1::CellState,
    pub(super) heightmap: v1::Heightmap,
    pub(super) tray_cloud: v1::PointCloud,
}

struct Run<'a> {
    world: &'a World<'a>,
    stack: &'a Stack,
    controller: Controller,
    tray: Tray,
    /// Objects that have not come to the tray yet.
    queue: VecDeque<(usize, Arc<Model>)>,
    /// Poses in which announced items were seen.
    seen: BTreeMap<usize, Isometry3<f64>>,
    record: RunRecord,
    tray_sequence: u64,
    tray_cloud: v1::PointCloud,
}

pub(super) fn run(world: &World<'_>, stack: &Stack, case: &Case) -> Outcome<Done> {
    let controller = Controller::new(stack.client(), super::cell()?);
    controller.renew()?;
    // The tray has no place beside it: what fits nowhere leaves the cell.
    controller.begin(&case.session_id, &[], 0)?;
    let models = case.objects.iter().filter_map(|index| {
        let object = world.catalogue.get(*index)?;
        Some(Arc::clone(&object.model))
    });
    let queue: VecDeque<_> = models.enumerate().collect();
    let items = queue.iter().map(|(_, model)| ItemRecord {
        object: model.name.clone(),
        is_known: world.known(&model.name).is_some(),
        seen_as: SeenAs::Nothing,
        attempts: 0,
        end: End::Waiting,
        found: None,
    });
    let run = Run {
        world,
        stack,
        controller,
        tray: Tray::new(case.seeds.tray)?,
        record: RunRecord {
            items: items.collect(),
            ..RunRecord::default()
        },
        queue,
        seen: BTreeMap::new(),
        tray_sequence: 0,
        tray_cloud: v1::PointCloud::default(),
    };
    run.go()
}

impl Run<'_> {
    fn go(mut self) -> Outcome<Done> {
        let mut goes_on = true;
        while goes_on {
            self.fill()?;
            goes_on = match self.tray.lying.is_empty() {
                true => !self.queue.is_empty(),
                false => self.step()?,
            };
        }
        let state = self.controller.state()?;
        let heightmap = self.controller.heightmap(state.state_number)?;
        Ok(Done {
            record: self.record,
            state,
            heightmap,
            tray_cloud: self.tray_cloud,
        })
    }

    /// Lets objects come to the tray as long as there is room, and announces what is seen of them.
    fn fill(&mut self) -> Outcome {
        let mut is_new = false;
        while self.tray.lying.len() < self.world.settings.buffer {
            let Some((arrival, model)) = self.queue.front() else {
                break;
            };
            let (arrival, has_room) = (*arrival, self.tray.lay(*arrival, model));
            if has_room {
                is_new = true;
            } else if self.tray.lying.is_empty() {
                self.end(arrival, refused("it is too large for the tray"));
            } else {
                break;
            }
            self.queue.pop_front();
        }
        if is_new { self.announce() } else { Ok(()) }
    }

    /// Looks at the tray, and announces what was not there before.
    fn announce(&mut self) -> Outcome {
        let began = Instant::now();
        let reply = self.look()?;
        self.took("recognise", began);
        let mut new = self.tray.lying.clone();
        new.retain(|object| !self.seen.contains_key(&object.arrival));
        for object in new {
            let items = reply.items.iter();
            let found = items
                .filter_map(|item| Some((self.distance_m(item, &object)?, item)))
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .filter(|(distance_m, _)| *distance_m <= SAME_M);
            match found {
                Some((_, item)) => self.announce_one(&object, item)?,
                None => self.leave(object.arrival, refused("it was not seen on the tray")),
            }
        }
        Ok(())
    }

    fn announce_one(&mut self, object: &Lying, item: &v1::SeenItem) -> Outcome {
        let waits_at = read_pose(item.container_from_item.as_ref());
        let (Some(waits_at), Some(heightmaps)) = (waits_at, &item.item) else {
            self.leave(object.arrival, refused("it is too large for the grid"));
            return Ok(());
        };
        let seen_as = self.seen_as(object, item, &waits_at);
        if let Some(record) = self.record.items.get_mut(object.arrival) {
            record.seen_as = seen_as;
        }
        let announcement = v1::Announcement {
            item_id: item_id(object.arrival),
            shape: Some(v1::announcement::Shape::Item(heightmaps.clone())),
            heightmap_from_item: item.heightmap_from_item,
            waits_at: item.container_from_item,
            ..v1::Announcement::default()
        };
        let request = v1::AnnounceRequest {
            items: vec![announcement],
            ..v1::AnnounceRequest::default()
        };
        self.ask("planner", request)?;
        self.seen.insert(object.arrival, waits_at);
        Ok(())
    }

    /// Sees what lies on the tray, by a cloud of now.
    fn look(&mut self) -> Outcome<v1::ItemsReply> {
        let points = self.tray.view()?;
        self.tray_sequence += 1;
        let capture = Capture {
            sequence: self.tray_sequence,
            captured_at_ns: i64::try_from(now_ns()).unwrap_or(i64::MAX),
            state_number: 0,
            container_from_sensor: self.tray.container_from_camera(),
        };
        let message = cloud::write(&capture, &points);
        let key = Key::Stream(super::cell()?, Stream::TrayCloud).to_string();
        let session = self.stack.session();
        session
            .put(key, message.encode_to_vec())
            .congestion_control(CongestionControl::Block)
            .wait()
            .map_err(|error| Failure::Run(anyhow::anyhow!("the tray's cloud: {error}")))?;
        if self.tray_cloud.data.is_empty() {
            self.tray_cloud = message;
        }
        let request = v1::ItemsRequest {
            least_sequence: self.tray_sequence,
            ..v1::ItemsRequest::default()
        };
        self.ask("perception", request)
    }

    fn ask<R: Request>(&self, service: &str, request: R) -> Outcome<R::Reply> {
        self.controller.ask(service, request, REQUEST_LIMIT)
    }

    /// How far something seen is from an object, seen from above in metres.
    fn distance_m(&self, item: &v1::SeenItem, object: &Lying) -> Option<f64> {
        let pose = read_pose(item.container_from_item.as_ref())?;
        let centre: Point2<f64> = match self.world.known(&item.object) {
            Some(index) => {
                let known = self.world.library.objects.get(index)?;
                (pose * known.model.mass.centre_of_mass_m).xy()
            }
            None => pose.translation.vector.xy().into(),
        };
        Some((centre - object.centre_m()).norm())
    }

    fn seen_as(&self, object: &Lying, item: &v1::SeenItem, waits_at: &Isometry3<f64>) -> SeenAs {
        let Some(estimated) = self.world.known(&item.object) else {
            return SeenAs::Unknown;
        };
        let error = self.world.known(&object.model.name).and_then(|known| {
            let truth = &object.container_from_object;
            let library = &self.world.library;
            library.pose_error(known, truth, estimated, waits_at)
        });
        SeenAs::Object {
            name: item.object.clone(),
            position_off_m: error.map(|error| error.position_m),
            angle_off_rad: error.map(|error| error.angle_rad),
        }
    }

    /// Plans, and does what the planner says; whether it trusts what it sees.
    fn step(&mut self) -> Outcome<bool> {
        let began = Instant::now();
        let request = v1::PlanRequest::default();
        let reply = match self.controller.call(request, PLAN_LIMIT) {
            Ok(reply) => reply,
            Err(CallError::Refused {
                status: Status::Unavailable | Status::TimedOut,
                message,
                ..
            }) => {
                self.give_up(&message);
                return Ok(false);
            }
            Err(error) => return Err(error).context("the planner does not plan").or_run(),
        };
        self.took("plan", began);
        match (reply.result(), reply.decision) {
            (PlanResult::Decided, Some(decision)) => self.carry_out(&decision)?,
            (PlanResult::NothingFits, _) => {
                for reason in &reply.reasons {
                    if let Some(arrival) = arrival_of(&reason.item_id) {
                        self.withdraw(arrival, refused(&reason.text))?;
                    }
                }
            }
            (result, _) => return Err(anyhow::anyhow!("the planner answered {result:?}").into()),
        }
        Ok(true)
    }

    /// The arm moves the object as the decision says: with what was wrong about where it was seen.
    fn carry_out(&mut self, decision: &v1::Decision) -> Outcome {
        self.record.decisions.push(decision_record(decision));
        let arrival = arrival_of(&decision.item_id).context("a decision on no item of here")?;
        let object = self.tray.lying.iter().find(|one| one.arrival == arrival);
        let object = object.cloned().context("a decision on an absent item")?;
        let seen = self.seen.get(&arrival).copied().unwrap_or_default();
        let target = pose::read_required("pose", decision.container_from_item.as_ref()).or_run()?;
        // An arm picks the item as its cycle says; without one, as it was seen.
        let cycle = decision.cycle.as_ref();
        let picked = cycle.and_then(|it| read_pose(it.container_from_item_at_pick.as_ref()));
        let truly = target * picked.unwrap_or(seen).inverse() * object.container_from_object;
        let before = self.controller.state()?;
        let request = v1::PlaceRequest {
            object: object.model.name.clone(),
            container_from_item: Some(pose::write(&truly)),
            ..v1::PlaceRequest::from(decision)
        };
        let began = Instant::now();
        let outcome = self.controller.place(request)?;
        self.took("simulate", began);
        let record = self.record.items.get_mut(arrival);
        let attempts = record.map_or(0, |record| {
            record.attempts += 1;
            record.attempts
        });
        // A real arm does not know where the item came to lie: that is for the inspection to find.
        let report = v1::Outcome {
            container_from_item: None,
            ..outcome.clone()
        };
        self.controller.report(&decision.decision_id, report)?;
        let began = Instant::now();
        self.controller.heightmap(outcome.state_number)?;
        self.took("see", began);
        match outcome.kind() {
            OutcomeKind::Placed => {
                self.inspected(arrival, &outcome)?;
                self.took("inspect", began);
                let after = self.controller.state()?;
                let end = End::Placed {
                    is_inside: outcome.is_inside,
                    slide_m: outcome.slide_m,
                    tilt_rad: outcome.tilt_rad,
                    disturbance_m: disturbance_m(&before, &after),
                };
                self.leave(arrival, end);
            }
            OutcomeKind::NotPlaced if attempts < MAX_ATTEMPTS => {}
            OutcomeKind::NotPlaced => {
                let reason = format!("not placed in {attempts} attempts: {}", outcome.failure);
                self.withdraw(arrival, refused(&reason))?;
            }
            _ => {
                let failure = outcome.failure;
                self.leave(arrival, End::Lost { failure });
            }
        }
        Ok(())
    }

    /// Records how the session says that a placed item lies, and how far that is from the truth.
    fn inspected(&mut self, arrival: usize, outcome: &v1::Outcome) -> Outcome {
        let until = Instant::now() + INSPECTION_LIMIT;
        let inspection = loop {
            let reply = self.ask("planner", v1::SessionRequest::default())?;
            let items = reply.session.unwrap_or_default().items;
            let own = items.into_iter().find(|it| it.item_id == item_id(arrival));
            match own.and_then(|own| own.inspection) {
                Some(inspection) => break inspection,
                None if Instant::now() < until => std::thread::sleep(POLL),
                None => return Ok(()),
            }
        };
        if inspection.kind() == InspectionKind::Unspecified {
            return Ok(());
        }
        let kind = inspection.kind().as_str_name().to_ascii_lowercase();
        let kind = kind.trim_start_matches("inspection_kind_").to_owned();
        let found = read_pose(inspection.container_from_item.as_ref());
        let truth = read_pose(outcome.container_from_item.as_ref());
        if let Some(record) = self.record.items.get_mut(arrival) {
            let known = self.world.known(&record.object);
            let is_right =
                matches!(&record.seen_as, SeenAs::Object { name, .. } if *name == record.object);
            let poses = found.zip(truth).filter(|_| is_right);
            let error = poses.and_then(|(found, truth)| {
                let library = &self.world.library;
                library.pose_error(known?, &truth, known?, &found)
            });
            record.found = Some(Found {
                kind,
                position_off_m: error.map(|error| error.position_m),
                angle_off_rad: error.map(|error| error.angle_rad),
                reason: inspection.reason,
            });
        }
        Ok(())
    }

    fn withdraw(&mut self, arrival: usize, end: End) -> Outcome {
        let request = v1::WithdrawRequest {
            item_id: item_id(arrival),
            ..v1::WithdrawRequest::default()
        };
        self.ask("planner", request)?;
        self.leave(arrival, end);
        Ok(())
    }

    fn give_up(&mut self, doubt: &str) {
        self.record.doubt = Some(doubt.to_owned());
        for item in &mut self.record.items {
            if item.end == End::Waiting {
                item.end = refused(doubt);
            }
        }
    }

    fn leave(&mut self, arrival: usize, end: End) {
        self.tray.take(arrival);
        self.seen.remove(&arrival);
        self.end(arrival, end);
    }

    fn end(&mut self, arrival: usize, end: End) {
        if let Some(record) = self.record.items.get_mut(arrival) {
            record.end = end;
        }
    }

    fn took(&mut self, stage: &str, began: Instant) {
        let took_s = began.elapsed().as_secs_f64();
        let stages_s = &mut self.record.stages_s;
        stages_s.entry(stage.to_owned()).or_default().push(took_s);
    }
}

fn read_pose(message: Option<&v1::Pose>) -> Option<Isometry3<f64>> {
    pose::read_required("pose", message).ok()
}

fn refused(reason: &str) -> End {
    End::Refused {
        reason: reason.to_owned(),
    }
}

fn decision_record(decision: &v1::Decision) -> DecisionRecord {
    let stage_s = |name: &str| {
        let mut stages = decision.stages.iter();
        let stage = stages.find(|stage| stage.stage == name);
        stage.map_or(0.0, |stage| stage.duration_ns as f64 * 1e-9)
    };
    DecisionRecord {
        propose_s: stage_s("propose"),
        evaluate_s: stage_s("evaluate"),
        check_s: stage_s("check"),
        cycle_s: decision.cycle.as_ref().map_or(0.0, |cycle| cycle.cycle_s),
        degraded: decision.degraded.clone(),
        is_widened: decision.is_widened,
    }
}

fn disturbance_m(before: &v1::CellState, after: &v1::CellState) -> f64 {
    let place = |body: &v1::Body| {
        let pose = read_pose(body.container_from_item.as_ref())?;
        Some(pose.translation.vector)
    };
    let moved_m = before.bodies.iter().filter_map(|body| {
        let mut bodies = after.bodies.iter();
        let now = bodies.find(|other| other.item_id == body.item_id)?;
        Some((place(now)? - place(body)?).norm())
    });
    moved_m.fold(0.0, f64::max)
}
