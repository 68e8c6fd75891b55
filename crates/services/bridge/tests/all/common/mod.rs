//! Controllers, rigs and robots for the tests of the bridge.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use nalgebra::{Isometry3, Point3};
use ppnpack_bridge::robot::{
    Body, CutOff, Ending, Finding, KnownPose, Placement, Robot, RobotError, View,
};
use ppnpack_bridge::simulated::SimulatedSettings;
use ppnpack_bridge::{Bridge, Settings as BridgeSettings};
use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::catalogue::{Catalogue, NamedMesh, Settings, Source};
use ppnpack_catalogue::mesh::Bounds;
use ppnpack_packing::checks::motion::{Cycle, JointPoint, Leg, LegKind};
use ppnpack_packing::kernel::grid::{ContainerSize, Resolution};
use ppnpack_service::Shutdown;
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::process::Process;
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_service::stream::Latest;
use ppnpack_wire::MAX_CLOUD_BYTES;
use ppnpack_wire::convert::pose;
use ppnpack_wire::keys::{Cell, Service, Stream};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::{self, OutcomeKind, Status};
use prost::{Message, Name};

pub(crate) const PATIENCE: Duration = Duration::from_secs(60);

pub(crate) fn cell() -> Cell {
    Cell::new("cell-1").unwrap()
}

pub(crate) fn deadline() -> Instant {
    Instant::now() + PATIENCE
}

/// The objects `brick` (8 x 6 x 4 cm) and `cube` (5 cm), each around its origin.
pub(crate) fn catalogue() -> Arc<Catalogue> {
    let objects = [("brick", [0.08, 0.06, 0.04]), ("cube", [0.05; 3])];
    let objects = objects.map(|(name, sides_m)| {
        let highest = Point3::from(sides_m.map(|side_m: f64| side_m / 2.0));
        let bounds = Bounds {
            lowest: -highest,
            highest,
        };
        NamedMesh {
            name: name.to_owned(),
            mesh: bounds.mesh(),
            density_kg_m3: 400.0,
        }
    });
    let source = Source::Meshes(objects.to_vec().into());
    let settings = Settings {
        cache: CacheDir::Nowhere,
        ..Settings::default()
    };
    Arc::new(Catalogue::load(&source, &settings, &Resolution::reference(), &|_, _| {}).unwrap())
}

/// A request to place a brick flat in the middle of the container, or where `x_m` says.
pub(crate) fn place(placement_id: &str, state_number: u64, x_m: f64) -> v1::PlaceRequest {
    v1::PlaceRequest {
        header: None,
        placement_id: placement_id.to_owned(),
        item_id: format!("item-{placement_id}"),
        object: "brick".to_owned(),
        container_from_item: Some(pose::write(&Isometry3::translation(x_m, 0.16, 0.02))),
        state_number,
        cycle: None,
        decided_at_ns: 0,
    }
}

/// Asks the bridge on behalf of a controller.
pub(crate) struct Controller {
    client: Client,
    cell: Cell,
}

impl Controller {
    pub(crate) fn new(session: &zenoh::Session) -> Self {
        Self {
            client: Client::new(session),
            cell: cell(),
        }
    }

    pub(crate) fn at(&self, cell: &str) -> Self {
        Self {
            client: self.client.clone(),
            cell: Cell::new(cell).unwrap(),
        }
    }

    pub(crate) fn call<R: Request>(&self, request: R) -> Result<R::Reply, CallError> {
        self.client.call(&self.cell, request, deadline())
    }

    pub(crate) fn call_for<R: Request>(
        &self,
        request: R,
        span: Duration,
    ) -> Result<R::Reply, CallError> {
        self.client.call(&self.cell, request, Instant::now() + span)
    }

    pub(crate) fn refused<R: Request>(&self, request: R) -> Status {
        match self.call(request) {
            Err(CallError::Refused { status, .. }) => status,
            Err(error) => panic!("not refused, but {error}"),
            Ok(_) => panic!("not refused"),
        }
    }

    pub(crate) fn refuses<R: Request>(&self, request: R, status: Status) {
        assert_eq!(self.refused(request), status);
    }

    pub(crate) fn state(&self) -> v1::CellState {
        let reply = self.call(v1::CellStateRequest::default()).unwrap();
        reply.state.unwrap()
    }

    pub(crate) fn state_number(&self) -> u64 {
        self.state().state_number
    }

    pub(crate) fn hold_ids(&self) -> Vec<String> {
        let holds = self.state().holds.into_iter();
        holds.map(|hold| hold.id).collect()
    }

    pub(crate) fn resume(&self, hold_ids: &[String]) -> v1::CellState {
        self.call(resume(hold_ids)).unwrap().state.unwrap()
    }

    /// Has a brick placed in the present state.
    pub(crate) fn place_now(&self, placement_id: &str) -> v1::Execution {
        self.place(place(placement_id, self.state_number(), 0.16))
    }

    pub(crate) fn place(&self, request: v1::PlaceRequest) -> v1::Execution {
        self.call(request).unwrap().execution.unwrap()
    }

    pub(crate) fn outcome(&self, placement_id: &str) -> v1::Outcome {
        let reply = self.call(outcome(placement_id)).unwrap();
        reply.execution.unwrap().outcome.unwrap()
    }

    /// Has a brick placed, and waits for the end.
    pub(crate) fn carry_out(&self, placement_id: &str, state_number: u64, x_m: f64) -> v1::Outcome {
        self.place(place(placement_id, state_number, x_m));
        self.outcome(placement_id)
    }

    pub(crate) fn renew(&self, request_id: &str) -> u64 {
        let request = renew(request_id, self.state_number());
        self.call(request).unwrap().state_number
    }
}

/// A motion that takes so long, besides that of the cup to the item and its waits.
pub(crate) fn cycle(cycle_s: f64) -> Cycle {
    let point = |time_s| JointPoint {
        time_s,
        position_rad: [0.1, -0.2, time_s, 3.0, -6.0, 12.5],
    };
    let leg = |kind, leg_s| Leg {
        kind,
        points: [0.0, leg_s].map(point).into(),
    };
    let third_s = cycle_s / 3.0;
    Cycle {
        arm: "an arm".to_owned(),
        cycle_s,
        container_from_item_at_pick: Isometry3::translation(0.1, -0.35, 0.02),
        grasp_yaw_rad: 0.75,
        grip_s: 0.2,
        release_s: 0.15,
        legs: vec![
            leg(LegKind::Descend, 0.01),
            leg(LegKind::Lift, third_s),
            leg(LegKind::Insert, third_s),
            leg(LegKind::Return, third_s),
        ],
    }
}

/// Asks for the end of a placement.
pub(crate) fn outcome(placement_id: &str) -> v1::OutcomeRequest {
    v1::OutcomeRequest {
        header: None,
        placement_id: placement_id.to_owned(),
    }
}

pub(crate) fn header(request_id: &str) -> Option<v1::RequestHeader> {
    Some(v1::RequestHeader {
        request_id: request_id.to_owned(),
        ..v1::RequestHeader::default()
    })
}

pub(crate) fn hold(reason: &str, is_aborting: bool) -> v1::HoldRequest {
    v1::HoldRequest {
        header: None,
        reason: reason.to_owned(),
        is_aborting,
        holder: String::new(),
    }
}

pub(crate) fn resume(hold_ids: &[String]) -> v1::ResumeRequest {
    v1::ResumeRequest {
        hold_ids: hold_ids.to_vec(),
        ..v1::ResumeRequest::default()
    }
}

/// Says that a hand was in the container.
pub(crate) fn changed(removed_item_ids: &[&str]) -> v1::ChangedRequest {
    let removed = removed_item_ids.iter().map(|id| (*id).to_owned());
    v1::ChangedRequest {
        header: None,
        removed_item_ids: removed.collect(),
    }
}

/// Asks for an empty container in place of the one that this state is of.
pub(crate) fn renew(request_id: &str, state_number: u64) -> v1::RenewRequest {
    v1::RenewRequest {
        header: header(request_id),
        state_number,
    }
}

/// Waits for the next cloud of a state.
pub(crate) fn cloud_of(clouds: &Latest<v1::PointCloud>, state_number: u64) -> v1::PointCloud {
    let until = deadline();
    loop {
        let cloud = clouds.wait(until).unwrap().message.unwrap();
        if cloud.state_number == state_number {
            return cloud;
        }
    }
}

pub(crate) struct Rig {
    pub(crate) controller: Controller,
    pub(crate) bridge: Bridge,
    pub(crate) process: Process,
    pub(crate) caller: Process,
    _hub: Hub,
}

impl Rig {
    pub(crate) fn new(start: impl FnOnce(&Process) -> Bridge) -> Self {
        let hub = embedded::hub().unwrap();
        let process = embedded::process(&hub, Service::Bridge, "bridge-1").unwrap();
        let bridge = start(&process);
        let caller = embedded::process(&hub, Service::Planner, "test").unwrap();
        Self {
            controller: Controller::new(caller.session()),
            bridge,
            process,
            caller,
            _hub: hub,
        }
    }

    pub(crate) fn simulated(settings: SimulatedSettings) -> Self {
        let settings = BridgeSettings {
            cells: BTreeMap::from([(cell().to_string(), settings)]),
            ..BridgeSettings::default()
        };
        Self::new(|process| ppnpack_bridge::start(process, &settings, &catalogue()).unwrap())
    }

    pub(crate) fn scripted(is_simulated: bool, journal: Option<PathBuf>) -> (Self, Script) {
        let settings = BridgeSettings {
            journal,
            ..BridgeSettings::default()
        };
        Self::scripted_with(is_simulated, &settings)
    }

    pub(crate) fn scripted_with(is_simulated: bool, settings: &BridgeSettings) -> (Self, Script) {
        let (rig, script) = Self::unseen(is_simulated, settings);
        if !is_simulated {
            // Somebody has looked, as at the first start of a real cell.
            let mut ids = rig.controller.hold_ids();
            ids.retain(|id| id.starts_with("start-"));
            if !ids.is_empty() {
                rig.controller.resume(&ids);
            }
        }
        (rig, script)
    }

    pub(crate) fn subscribe<M: Message + Name + Default>(&self, stream: Stream) -> Latest<M> {
        Latest::subscribe(&self.caller, &cell(), stream, MAX_CLOUD_BYTES).unwrap()
    }

    pub(crate) fn wait_until_ready(&self) {
        let until = deadline();
        while !self.process.health().is_ready() {
            assert!(Instant::now() < until, "it does not recover");
            std::thread::yield_now();
        }
    }

    /// A cell as it starts, before anybody has looked.
    pub(crate) fn unseen(is_simulated: bool, settings: &BridgeSettings) -> (Self, Script) {
        let (robot, script) = scripted(is_simulated);
        let robots: BTreeMap<_, Box<dyn Robot>> = BTreeMap::from([(cell(), Box::new(robot) as _)]);
        let rig =
            Self::new(|process| ppnpack_bridge::start_robots(process, settings, robots).unwrap());
        (rig, script)
    }
}

/// A robot that does what the test tells it.
pub(crate) struct ScriptedRobot {
    is_simulated: bool,
    shared: Arc<Shared>,
    go: Receiver<()>,
    bodies: Vec<Body>,
}

/// A test's end of a scripted robot.
pub(crate) struct Script {
    pub(crate) shared: Arc<Shared>,
    /// Lets it carry one placement out.
    pub(crate) go: Sender<()>,
}

#[derive(Default)]
pub(crate) struct Shared {
    /// The placements and renewals that were carried out.
    done: Mutex<Vec<String>>,
    pub(crate) motions: Mutex<Vec<Option<Arc<Cycle>>>>,
    /// While a test has one of these locked, the robot hangs there.
    pub(crate) taking_over: Mutex<()>,
    pub(crate) capturing: Mutex<()>,
}

pub(crate) fn scripted(is_simulated: bool) -> (ScriptedRobot, Script) {
    let (go, going) = channel();
    let shared = Arc::<Shared>::default();
    let robot = ScriptedRobot {
        is_simulated,
        shared: Arc::clone(&shared),
        go: going,
        bodies: Vec::new(),
    };
    (robot, Script { shared, go })
}

impl Script {
    pub(crate) fn done(&self) -> Vec<String> {
        self.shared.done.lock().unwrap().clone()
    }

    /// Lets the robot carry out a placement, which succeeds.
    pub(crate) fn carry_out(&self, controller: &Controller, placement_id: &str) -> v1::Outcome {
        self.go.send(()).unwrap();
        let outcome = controller.outcome(placement_id);
        assert_eq!(outcome.kind(), OutcomeKind::Placed);
        outcome
    }
}

impl Robot for ScriptedRobot {
    fn is_simulated(&self) -> bool {
        self.is_simulated
    }

    fn container(&self) -> ContainerSize {
        ContainerSize::REFERENCE
    }

    fn objects(&self) -> Option<BTreeMap<String, Bounds>> {
        None
    }

    fn take_over(&mut self, bodies: Vec<Body>) -> Vec<Body> {
        drop(self.shared.taking_over.lock());
        self.bodies = bodies;
        self.bodies.clone()
    }

    fn place(&mut self, placement: &Placement, cut_off: &Shutdown) -> Result<Finding, CutOff> {
        while let Err(RecvTimeoutError::Timeout) = self.go.recv_timeout(Duration::from_millis(5)) {
            if cut_off.is_requested() {
                return Err(CutOff);
            }
        }
        let done = placement.placement_id.clone();
        self.shared.done.lock().unwrap().push(done);
        let cycle = placement.cycle.clone();
        self.shared.motions.lock().unwrap().push(cycle);
        if placement.object == "panic" {
            panic!("as the test asked for");
        }
        self.bodies.push(Body {
            item_id: placement.item_id.clone(),
            object: placement.object.clone(),
            container_from_item: KnownPose::Assumed(placement.container_from_item),
            is_inside: true,
        });
        Ok(Finding {
            container_from_item: Some(KnownPose::Assumed(placement.container_from_item)),
            is_inside: true,
            ..Finding::failed(Ending::Placed, "")
        })
    }

    fn renew(&mut self) -> Result<(), RobotError> {
        let done = "renewed".to_owned();
        self.shared.done.lock().unwrap().push(done);
        self.bodies.clear();
        Ok(())
    }

    fn bodies(&self) -> Vec<Body> {
        self.bodies.clone()
    }

    fn capture(&mut self) -> Result<Vec<View>, RobotError> {
        drop(self.shared.capturing.lock());
        Ok(vec![View {
            sensor: String::new(),
            points_m: Vec::new(),
            container_from_sensor: Isometry3::identity(),
            is_of_now: true,
        }])
    }
}
