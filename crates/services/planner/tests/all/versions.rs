//! A planner with bridges of other versions: older ones leave fields out, newer ones say what is not known here.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use crate::common::{self, announcement, block, cell, soon};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Surface;
use ppnpack_packing::trial::TrialSettings;
use ppnpack_planner::{CellSettings, PlannerService};
use ppnpack_service::Process;
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::{self, Client, Done, Incoming, Listener};
use ppnpack_wire::keys::Service;
use ppnpack_wire::v1::{self, ItemState, OutcomeKind, SessionEnd, Status};

/// The state that every heightmap shows.
const STATE: u64 = 70;

/// A planner in automatic mode, and a bridge that answers as a test says.
struct Rig {
    client: Client,
    /// How often the bridge was asked to place something.
    placed: Arc<AtomicUsize>,
    _planner: Box<PlannerService>,
    _listeners: Vec<Listener>,
    _processes: Vec<Process>,
    _hub: Hub,
}

impl Rig {
    /// A bridge in this state, which answers requests to place an item so.
    fn new(
        state: v1::CellState,
        answer: impl Fn(Incoming<v1::PlaceRequest>) + Send + Sync + 'static,
    ) -> Self {
        let hub = embedded::hub().unwrap();
        let perception = embedded::process(&hub, Service::Perception, "perception-1").unwrap();
        let heightmap = |incoming: Incoming<v1::HeightmapRequest>| {
            let grid = Grid::reference();
            let surface = Surface::empty(&grid);
            common::show(incoming, &grid, surface, STATE);
        };
        let bridge = embedded::process(&hub, Service::Bridge, "bridge-1").unwrap();
        let tell = move |incoming: Incoming<v1::CellStateRequest>| {
            let reply = v1::CellStateReply {
                state: Some(state.clone()),
                ..v1::CellStateReply::default()
            };
            incoming.reply(reply, Done::default());
        };
        let placed = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&placed);
        let place = move |incoming: Incoming<v1::PlaceRequest>| {
            counted.fetch_add(1, Ordering::Relaxed);
            answer(incoming);
        };
        let listeners = vec![
            rpc::listen(&perception, None, heightmap).unwrap(),
            rpc::listen(&bridge, None, tell).unwrap(),
            rpc::listen(&bridge, None, place).unwrap(),
        ];
        let mut settings = CellSettings {
            heightmap_age_limit_s: 600.0,
            place_limit_s: 1.0,
            ..crate::common::coarse()
        };
        settings.method.trial = TrialSettings::off();
        let planner = common::start(&hub, &common::settings(settings), &[]);
        let client = Client::new(&embedded::session(&hub).unwrap());
        let begin = v1::BeginRequest {
            session_id: "s".to_owned(),
            is_automatic: true,
            ..v1::BeginRequest::default()
        };
        client.call(&cell(), begin, soon()).unwrap();
        let announce = v1::AnnounceRequest {
            items: vec![announcement("a", block())],
            ..v1::AnnounceRequest::default()
        };
        client.call(&cell(), announce, soon()).unwrap();
        Self {
            client,
            placed,
            _planner: planner,
            _listeners: listeners,
            _processes: vec![perception, bridge],
            _hub: hub,
        }
    }

    /// The session once this holds.
    fn wait(&self, is_so: impl Fn(&v1::Session) -> bool) -> v1::Session {
        let end = soon();
        loop {
            let reply = self
                .client
                .call(&cell(), v1::SessionRequest::default(), end);
            let session = reply.unwrap().session.unwrap();
            if is_so(&session) {
                return session;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn failed(&self) -> v1::Session {
        let session = self.wait(|session| session.end != 0);
        assert_eq!(session.end(), SessionEnd::Failed);
        session
    }
}

fn stale(incoming: Incoming<v1::PlaceRequest>) {
    incoming.refuse(Status::Stale, "the container is in another state");
}

fn ended(incoming: Incoming<v1::PlaceRequest>, kind: i32) {
    let request = incoming.message();
    let outcome = v1::Outcome {
        placement_id: request.placement_id.clone(),
        item_id: request.item_id.clone(),
        kind,
        state_number: STATE,
        ..v1::Outcome::default()
    };
    let reply = v1::PlaceReply {
        execution: Some(v1::Execution {
            phase: v1::ExecutionPhase::Ended.into(),
            outcome: Some(outcome),
            ..v1::Execution::default()
        }),
        ..v1::PlaceReply::default()
    };
    incoming.reply(reply, Done::default());
}

#[test]
fn an_older_bridge_that_does_not_say_since_when_it_knows_all_may_have_placed_what_it_calls_stale() {
    // It calls stale too what it has forgotten with its journal.
    let state = v1::CellState {
        state_number: 9_000,
        ..v1::CellState::default()
    };
    let rig = Rig::new(state, stale);
    let session = rig.failed();
    let settled = session.settled.first().unwrap();
    assert_eq!(settled.kind(), OutcomeKind::Unknown);
    assert_eq!(session.items.first().unwrap().state(), ItemState::Gone);
    assert!(
        session.failure.contains("may lie anywhere"),
        "{}",
        session.failure
    );
    assert_eq!(rig.placed.load(Ordering::Relaxed), 1);
}

#[test]
fn what_a_bridge_calls_stale_that_knows_all_since_was_not_placed() {
    let state = v1::CellState {
        state_number: STATE,
        first_state_number: STATE,
        ..v1::CellState::default()
    };
    let rig = Rig::new(state, stale);
    let session = rig.wait(|session| !session.settled.is_empty());
    assert_eq!(
        session.settled.first().unwrap().kind(),
        OutcomeKind::NotPlaced
    );
}

#[test]
fn an_outcome_of_a_kind_that_is_not_known_here_ends_the_automatic_mode() {
    let rig = Rig::new(v1::CellState::default(), |incoming| ended(incoming, 99));
    let session = rig.failed();
    assert!(
        session.failure.contains("was not carried out"),
        "{}",
        session.failure
    );
    assert_eq!(session.items.first().unwrap().state(), ItemState::Decided);
}

#[test]
fn what_an_older_bridge_leaves_out_of_an_outcome_is_not_needed() {
    let kind = OutcomeKind::Placed.into();
    let rig = Rig::new(v1::CellState::default(), move |incoming| {
        ended(incoming, kind);
    });
    let session = rig.wait(|session| session.end != 0);
    assert_eq!(session.end(), SessionEnd::AllPacked);
    let item = session.items.first().unwrap();
    assert_eq!(item.container_from_item, item.planned);
}
