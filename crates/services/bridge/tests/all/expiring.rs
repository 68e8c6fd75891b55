//! Decisions that are too old to be carried out.

use crate::common::{Rig, place};
use ppnpack_bridge::Settings;
use ppnpack_wire::v1::{self, ExecutionPhase, Status};

/// The age from which decisions are not carried out, in seconds and in nanoseconds.
const LIMIT_S: f64 = 60.0;
const LIMIT_NS: u64 = 60_000_000_000;

/// A request for a placement that was decided then by the bridge's clock.
fn decided(placement_id: &str, state_number: u64, decided_at_ns: u64) -> v1::PlaceRequest {
    v1::PlaceRequest {
        decided_at_ns,
        ..place(placement_id, state_number, 0.16)
    }
}

#[test]
fn a_decision_that_is_too_old_or_of_another_clock_is_stale_and_never_begins() {
    let settings = Settings {
        decision_age_limit_s: LIMIT_S,
        ..Settings::default()
    };
    let (rig, script) = Rig::scripted_with(false, &settings);
    let controller = &rig.controller;
    let before = controller.state();
    let now_ns = before.clock_ns;
    for (id, decided_at_ns) in [
        ("old", now_ns - LIMIT_NS),
        ("future", now_ns + 10 * LIMIT_NS),
    ] {
        let state = controller.state_number();
        let request = decided(id, state, decided_at_ns);
        controller.refuses(request.clone(), Status::Stale);
        // Also where a clock is set back and it would be young again.
        assert_eq!(controller.state_number(), state + 1);
        let young = decided(id, state, controller.state().clock_ns);
        controller.refuses(young, Status::Stale);
        let unknown = decided(id, state, 0);
        controller.refuses(unknown, Status::Stale);
    }
    assert!(controller.state().clock_ns > now_ns);
    assert_eq!(controller.state().bodies, before.bodies);

    let young = decided("young", controller.state_number(), now_ns);
    let execution = controller.place(young.clone());
    assert_eq!(execution.phase(), ExecutionPhase::Accepted);
    script.carry_out(controller, "young");
    // What was carried out is known however late it is asked for again.
    let late = v1::PlaceRequest {
        decided_at_ns: now_ns - LIMIT_NS,
        ..young
    };
    assert_eq!(controller.place(late).phase(), ExecutionPhase::Ended);
    assert_eq!(script.done(), ["young"]);
}

#[test]
fn where_it_does_not_matter_any_age_will_do() {
    let settings = Settings {
        decision_age_limit_s: 0.0,
        ..Settings::default()
    };
    let (rig, script) = Rig::scripted_with(false, &settings);
    let controller = &rig.controller;
    let old = decided("old", controller.state_number(), 1);
    assert_eq!(controller.place(old).phase(), ExecutionPhase::Accepted);
    script.carry_out(controller, "old");
}
