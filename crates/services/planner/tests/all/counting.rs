//! What the planner counts of a cell.

use std::time::{Duration, Instant};

use crate::common::{self, announcement, block, cell, placed, soon};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Surface;
use ppnpack_packing::method::Method;
use ppnpack_packing::trial::TrialSettings;
use ppnpack_planner::{CellSettings, Where};
use ppnpack_service::Running;
use ppnpack_service::embedded;
use ppnpack_service::metrics;
use ppnpack_service::rpc::{self, Client};
use ppnpack_wire::keys::Service;
use ppnpack_wire::v1::{self, SessionEnd, Status};

/// The state that perception shows.
const SHOWN: u64 = 2;

fn assert_counts(counts: &[(&str, u64)]) {
    let text = metrics::render();
    for (series, count) in counts {
        let line = format!("ppnpack_{series} {count}\n");
        assert!(text.contains(&line), "{line} is not in:\n{text}");
    }
}

#[test]
fn what_becomes_of_plans_and_sessions_is_counted_by_cell() {
    metrics::install().unwrap();
    let hub = embedded::hub().unwrap();
    let perception = embedded::process(&hub, Service::Perception, "perception-1").unwrap();
    let grid = Grid::reference();
    let _listener = rpc::listen(&perception, None, move |incoming| {
        common::show(incoming, &grid, Surface::empty(&grid), SHOWN);
    })
    .unwrap();
    // There is no heuristic service, so that plans go without it.
    let settings = common::settings(CellSettings {
        evaluate: Where::Services,
        method: Method {
            trial: TrialSettings::off(),
            ..crate::common::method()
        },
        ..crate::common::coarse()
    });
    let planner = common::start(&hub, &settings, &[]);
    assert_counts(&[
        (r#"stale_scenes_total{cell="cell-1"}"#, 0),
        (r#"decisions_total{cell="cell-1",is_degraded="true"}"#, 0),
        (r#"decisions_total{cell="cell-1",is_degraded="false"}"#, 0),
        (
            r#"sessions_ended_total{cell="cell-1",end="SESSION_END_FAILED"}"#,
            0,
        ),
        (
            r#"sessions_ended_total{cell="cell-1",end="SESSION_END_ALL_PACKED"}"#,
            0,
        ),
    ]);
    let client = Client::new(&embedded::session(&hub).unwrap());
    common::begin(&client);
    let announce = v1::AnnounceRequest {
        items: vec![announcement("a", block()), announcement("b", block())],
        ..v1::AnnounceRequest::default()
    };
    client.call(&cell(), announce, soon()).unwrap();
    let plan = |deadline| client.call(&cell(), v1::PlanRequest::default(), deadline);
    let decision = plan(soon()).unwrap().decision.unwrap();
    assert_counts(&[
        (r#"decisions_total{cell="cell-1",is_degraded="true"}"#, 1),
        (r#"decisions_total{cell="cell-1",is_degraded="false"}"#, 0),
    ]);
    // Perception never shows what was placed.
    client
        .call(&cell(), placed(&decision, SHOWN + 1), soon())
        .unwrap();
    let refused = plan(Instant::now() + Duration::from_millis(500)).unwrap_err();
    assert!(
        matches!(refused.status(), None | Some(Status::Unavailable)),
        "{refused}"
    );
    let withdraw = v1::WithdrawRequest {
        item_id: "b".to_owned(),
        ..v1::WithdrawRequest::default()
    };
    // Answered after the plan, which has failed by then.
    client.call(&cell(), withdraw, soon()).unwrap();
    assert_counts(&[(r#"stale_scenes_total{cell="cell-1"}"#, 1)]);
    let automatic = v1::AutomaticRequest {
        is_automatic: true,
        ..v1::AutomaticRequest::default()
    };
    client.call(&cell(), automatic, soon()).unwrap();
    let until = soon();
    while client
        .call(&cell(), v1::SessionRequest::default(), soon())
        .is_ok_and(|reply| reply.session.unwrap().end() != SessionEnd::AllPacked)
    {
        assert!(Instant::now() < until, "the session does not end");
    }
    assert_counts(&[
        (
            r#"sessions_ended_total{cell="cell-1",end="SESSION_END_FAILED"}"#,
            0,
        ),
        (
            r#"sessions_ended_total{cell="cell-1",end="SESSION_END_ALL_PACKED"}"#,
            1,
        ),
    ]);
    planner.finish(soon()).unwrap();
}
