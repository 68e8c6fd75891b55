//! What the planner counts of a cell.

use std::time::{Duration, Instant};

use crate::common::{self, Rig, cell, in_ms, placed, soon};
use ppnpack_planner::{CellSettings, Where};
use ppnpack_service::metrics;
use ppnpack_wire::v1::{self, SessionEnd, Status};

/// Says whether so much is counted of the cell, by the metric and its other labels.
fn is_counted((metric, labels, count): &(&str, &str, u64)) -> bool {
    let line = format!("ppnpack_{metric}_total{{cell=\"cell-1\"{labels}}} {count}\n");
    metrics::render().contains(&line)
}

fn assert_counts(counts: &[(&str, &str, u64)]) {
    for count in counts {
        assert!(
            is_counted(count),
            "{count:?} is not in:\n{}",
            metrics::render()
        );
    }
}

const DEGRADED: &str = r#",is_degraded="true""#;
const WHOLE: &str = r#",is_degraded="false""#;
const FAILED: &str = r#",end="SESSION_END_FAILED""#;
const ALL_PACKED: &str = r#",end="SESSION_END_ALL_PACKED""#;

#[test]
fn what_becomes_of_plans_and_sessions_is_counted_by_cell() {
    metrics::install().unwrap();
    // There is no heuristic service, so that plans go without it.
    let rig = Rig::new(CellSettings {
        evaluate: Where::Services,
        ..common::untried()
    });
    rig.seen.lock().unwrap().is_stuck = true;
    assert_counts(&[
        ("stale_scenes", "", 0),
        ("decisions", DEGRADED, 0),
        ("decisions", WHOLE, 0),
        ("sessions_ended", FAILED, 0),
        ("sessions_ended", ALL_PACKED, 0),
    ]);
    rig.begin_with(&["a", "b"]);
    let decision = rig.decision();
    assert_counts(&[("decisions", DEGRADED, 1), ("decisions", WHOLE, 0)]);
    // Perception never shows what was placed.
    rig.call(placed(&decision, decision.state_number + 1));
    let late = rig
        .client
        .call(&cell(), v1::PlanRequest::default(), in_ms(500));
    let refused = late.unwrap_err();
    assert!(
        matches!(refused.status(), None | Some(Status::Unavailable)),
        "{refused}"
    );
    // Its caller may have left before it failed.
    let until = soon();
    while !is_counted(&("stale_scenes", "", 1)) {
        assert!(Instant::now() < until, "it never fails");
        std::thread::sleep(Duration::from_millis(10));
    }
    rig.withdraw("b");
    rig.switch(true);
    assert_eq!(rig.ended().end(), SessionEnd::AllPacked);
    assert_counts(&[
        ("sessions_ended", FAILED, 0),
        ("sessions_ended", ALL_PACKED, 1),
    ]);
}
