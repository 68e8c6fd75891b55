//! Cells whose sensor does not know their states.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crate::common::{self, Rig, carried_out, ended, ended_as, not_placed, state_reply};
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::heightmap::Surface;
use ppnpack_planner::CellSettings;
use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::keys::Service;
use ppnpack_wire::v1::{self, OutcomeKind, Status};

/// How long a cloud may be on its way.
const LATENCY: Duration = Duration::from_millis(300);

/// A planner whose camera knows no states.
fn rig() -> Rig {
    let settings = CellSettings {
        sensor_latency_s: LATENCY.as_secs_f64(),
        ..common::untried()
    };
    // Each request is answered with a heightmap of just now.
    let sequence = AtomicU64::new(1);
    Rig::shown_by(settings, &[], move |incoming| {
        let grid = Grid::reference();
        let sequence = sequence.fetch_add(1, Ordering::Relaxed);
        common::show(incoming, &grid, Surface::empty(&grid), sequence, 0);
    })
}

#[test]
fn a_decision_is_of_the_bridges_state_on_a_picture_that_surely_shows_it_and_reports_of_others_are_refused()
 {
    let mut rig = rig();
    let state_number = Arc::new(AtomicU64::new(70));
    let told = Arc::clone(&state_number);
    rig.bridge_says(move || v1::CellState {
        state_number: told.load(Ordering::Relaxed),
        clock_ns: 1_000,
        ..v1::CellState::default()
    });

    let begun = Instant::now();
    rig.begin_with(&["a", "b"]);
    let first = rig.decision();
    assert_eq!(first.state_number, 70);
    // As the bridge told it, and what passed since.
    let aged_ns = u64::try_from(begun.elapsed().as_nanos()).unwrap();
    assert!((1_000..=1_000 + aged_ns).contains(&first.decided_at_ns));
    assert!(begun.elapsed() >= LATENCY);

    // Somebody has a hand in the container after the report: the picture has to be newer than when
    // that was heard of.
    let report = |kind, state_number| {
        let outcome = v1::Outcome {
            state_number,
            ..v1::Outcome::default()
        };
        ended_as(kind, &first, outcome)
    };
    let before = rig.session();
    // The cell was never in these after the decision: no picture of them comes, or one of the past
    // would do. What was placed or lost changed the state.
    for (kind, never, text) in [
        (OutcomeKind::NotPlaced, 1, "state_number"),
        (OutcomeKind::NotPlaced, 69, "state_number"),
        (OutcomeKind::NotPlaced, 72, "state_number"),
        (OutcomeKind::NotPlaced, u64::MAX, "state_number"),
        (OutcomeKind::Placed, 0, "state 71"),
        (OutcomeKind::Placed, 70, "state 71"),
        (OutcomeKind::Lost, 0, "state 71"),
        (OutcomeKind::Lost, 70, "state 71"),
    ] {
        rig.assert_refused(report(kind, never), Status::Conflict, text);
    }
    assert_eq!(rig.session(), before);
    rig.call(report(OutcomeKind::NotPlaced, 71));
    state_number.store(75, Ordering::Relaxed);
    let reported = Instant::now();
    assert_eq!(rig.decision().state_number, 75);
    assert!(reported.elapsed() >= LATENCY);
}

/// How long a bridge that is slow takes to say its state.
const SLOW: Duration = Duration::from_millis(150);

#[test]
fn a_bridge_that_answers_late_is_waited_for_and_nothing_is_gone() {
    let mut rig = rig();
    let state_number = Arc::new(AtomicU64::new(70));
    let told = Arc::clone(&state_number);
    rig.answer(
        Service::Bridge,
        move |incoming: Incoming<v1::CellStateRequest>| {
            let reply = state_reply(v1::CellState {
                state_number: told.load(Ordering::Relaxed),
                first_state_number: 70,
                ..v1::CellState::default()
            });
            std::thread::spawn(move || {
                std::thread::sleep(SLOW);
                incoming.reply(reply, Done::default());
            });
        },
    );
    rig.bridge_answers(move |incoming: &Incoming<v1::PlaceRequest>| {
        let request = incoming.message();
        let outcome = carried_out(request);
        let planned_on = request.state_number;
        let is_now = planned_on == state_number.load(Ordering::Relaxed);
        is_now.then(|| {
            state_number.store(outcome.state_number, Ordering::Relaxed);
            ended(request, outcome)
        })
    });
    rig.begin_automatic();
    rig.announce([common::announcement("a", common::block())]);
    let session = rig.ended();
    assert_eq!(session.end(), v1::SessionEnd::AllPacked, "{session:?}");
    assert_eq!(session.settled.len(), 1);
}

#[test]
fn without_the_state_of_a_bridge_that_was_heard_of_nothing_is_decided() {
    let mut rig = rig();
    rig.bridge_says(|| v1::CellState {
        state_number: 70,
        ..v1::CellState::default()
    });
    rig.begin_with(&["a"]);
    let first = rig.decision();
    rig.call(not_placed(&first, 70));
    rig.last_service_leaves();
    let text = rig.plan_unavailable(3_000);
    assert!(text.contains("the bridge of cell cell-1"), "{text}");
    assert_eq!(rig.session().pending, None);
}

#[test]
fn the_first_decision_after_a_start_has_an_age() {
    let mut rig = Rig::new(common::untried());
    rig.bridge_says(|| v1::CellState {
        state_number: 2,
        clock_ns: 1_000,
        ..v1::CellState::default()
    });
    rig.begin_with(&["a"]);
    assert!(rig.decision().decided_at_ns >= 1_000);
}

#[test]
fn what_a_bridge_that_is_away_may_still_begin_is_not_given_up() {
    let mut rig = rig();
    let state = || v1::CellState {
        state_number: 70,
        clock_ns: 1_000,
        ..v1::CellState::default()
    };
    rig.bridge_says(state);
    rig.begin_with(&["a"]);
    rig.decision();
    rig.last_service_leaves();
    let begin = v1::BeginRequest {
        session_id: "next".to_owned(),
        gives_up_pending: true,
        ..v1::BeginRequest::default()
    };
    rig.assert_refused(begin.clone(), Status::Unavailable, "may still begin");
    assert_eq!(rig.session().session_id, "s");

    // It is back, and voids what was decided.
    rig.bridge_counts_to(state);
    let begun = loop {
        // Until the planner has found it.
        match rig.ask(begin.clone()) {
            Ok(reply) => break reply.session.unwrap(),
            Err(error) => assert_eq!(error.status(), Some(Status::Unavailable), "{error}"),
        }
    };
    assert_eq!(begun.session_id, "next");
}
