//! Cells whose sensor does not know their states.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crate::common::{self, announcement, block, cell, soon};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::{Scene, Surface};
use ppnpack_packing::trial::TrialSettings;
use ppnpack_planner::CellSettings;
use ppnpack_service::embedded;
use ppnpack_service::rpc::{self, Client, Done, Incoming};
use ppnpack_wire::convert;
use ppnpack_wire::keys::Service;
use ppnpack_wire::v1::{self, PlanResult, Status};

/// How long a cloud may be on its way.
const LATENCY: Duration = Duration::from_millis(300);

#[test]
fn a_decision_is_of_the_bridges_state_on_a_picture_that_surely_shows_it_and_reports_of_others_are_refused()
 {
    let hub = embedded::hub().unwrap();
    let perception = embedded::process(&hub, Service::Perception, "perception-1").unwrap();
    let sequence = AtomicU64::new(1);
    // Each request is answered with a heightmap of just now.
    let heightmap = move |incoming: Incoming<v1::HeightmapRequest>| {
        let grid = Grid::reference();
        let scene = Scene::from_surface(&grid, Surface::empty(&grid)).unwrap();
        let heightmap = v1::Heightmap {
            id: Some(v1::HeightmapId {
                epoch: 1,
                sequence: sequence.fetch_add(1, Ordering::Relaxed),
            }),
            scene: Some(convert::scene::write(&grid, &scene)),
            ..v1::Heightmap::default()
        };
        let reply = v1::HeightmapReply {
            heightmap: Some(heightmap),
            ..v1::HeightmapReply::default()
        };
        incoming.reply(reply, Done::default());
    };
    let _perception = rpc::listen(&perception, None, heightmap).unwrap();
    let bridge = embedded::process(&hub, Service::Bridge, "bridge-1").unwrap();
    let state_number = Arc::new(AtomicU64::new(70));
    let told = Arc::clone(&state_number);
    let state = move |incoming: Incoming<v1::CellStateRequest>| {
        let state = v1::CellState {
            state_number: told.load(Ordering::Relaxed),
            clock_ns: 1_000,
            ..v1::CellState::default()
        };
        let reply = v1::CellStateReply {
            state: Some(state),
            ..v1::CellStateReply::default()
        };
        incoming.reply(reply, Done::default());
    };
    let _bridge = rpc::listen(&bridge, None, state).unwrap();
    let mut settings = CellSettings {
        sensor_latency_s: LATENCY.as_secs_f64(),
        ..crate::common::coarse()
    };
    settings.method.trial = TrialSettings::off();
    let _planner = common::start(&hub, &common::settings(settings), &[]);
    let client = Client::new(&embedded::session(&hub).unwrap());

    common::begin(&client);
    let begun = Instant::now();
    let announce = v1::AnnounceRequest {
        items: vec![announcement("a", block()), announcement("b", block())],
        ..v1::AnnounceRequest::default()
    };
    client.call(&cell(), announce, soon()).unwrap();
    let decide = || {
        let reply = client
            .call(&cell(), v1::PlanRequest::default(), soon())
            .unwrap();
        assert_eq!(reply.result(), PlanResult::Decided, "{reply:?}");
        reply.decision.unwrap()
    };
    let first = decide();
    assert_eq!(first.state_number, 70);
    // As the bridge told it, and what passed since.
    let aged_ns = u64::try_from(begun.elapsed().as_nanos()).unwrap();
    assert!((1_000..=1_000 + aged_ns).contains(&first.decided_at_ns));
    assert!(begun.elapsed() >= LATENCY);

    // Somebody has a hand in the container after the report: the picture has to be newer than when that was heard of.
    let mut report = common::placed(&first, 71);
    report.outcome.as_mut().unwrap().kind = v1::OutcomeKind::NotPlaced.into();
    let session = client.call(&cell(), v1::SessionRequest::default(), soon());
    // The cell was never in these after the decision: no picture of them comes, or one of the past would do.
    for never in [1, 69, 72, u64::MAX] {
        let mut report = report.clone();
        report.outcome.as_mut().unwrap().state_number = never;
        let refused = client.call(&cell(), report, soon()).unwrap_err();
        assert_eq!(refused.status(), Some(Status::Conflict), "{refused}");
        assert!(refused.to_string().contains("state_number"), "{refused}");
    }
    // What was placed or lost changed the state.
    for kind in [v1::OutcomeKind::Placed, v1::OutcomeKind::Lost] {
        for as_before in [0, 70] {
            let mut report = common::placed(&first, as_before);
            report.outcome.as_mut().unwrap().kind = kind.into();
            let refused = client.call(&cell(), report, soon()).unwrap_err();
            assert_eq!(refused.status(), Some(Status::Conflict), "{refused}");
            assert!(refused.to_string().contains("state 71"), "{refused}");
        }
    }
    let again = client.call(&cell(), v1::SessionRequest::default(), soon());
    assert_eq!(again.unwrap().session, session.unwrap().session);
    client.call(&cell(), report.clone(), soon()).unwrap();
    // Sent again it changes nothing, whatever it says.
    report.outcome.as_mut().unwrap().state_number = 1;
    client.call(&cell(), report, soon()).unwrap();
    state_number.store(75, Ordering::Relaxed);
    let reported = Instant::now();
    assert_eq!(decide().state_number, 75);
    assert!(reported.elapsed() >= LATENCY);
}
