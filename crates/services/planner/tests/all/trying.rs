//! Placements are tried before they are decided on, also of items that were only seen.

use std::sync::{Arc, Mutex};

use crate::common::{Rig, cell, coarse, in_ms};
use nalgebra::Isometry3;
use ppnpack_planner::CellSettings;
use ppnpack_wire::{convert, v1};

fn says(decision: &v1::Decision, what: &str) -> bool {
    decision.degraded.iter().any(|reason| reason.contains(what))
}

/// What a bridge says of an item that lies in the container.
fn body(item_id: &str, object: &str, at: Isometry3<f64>, is_found: bool) -> v1::Body {
    v1::Body {
        item_id: item_id.to_owned(),
        object: object.to_owned(),
        container_from_item: Some(convert::pose::write(&at)),
        is_inside: true,
        is_found,
    }
}

/// A planner of a session with these items, and a bridge that says once they were announced that
/// these bodies lie in the container.
fn among(bodies: Option<Vec<v1::Body>>, items: &[&str]) -> Rig {
    let mut rig = Rig::new(coarse());
    let told: Arc<Mutex<Vec<v1::Body>>> = Arc::default();
    if bodies.is_some() {
        let told = Arc::clone(&told);
        rig.bridge_says(move || v1::CellState {
            // Later than any that is reported.
            state_number: 1_000,
            bodies: told.lock().unwrap().clone(),
            ..v1::CellState::default()
        });
    }
    rig.begin_with(items);
    *told.lock().unwrap() = bodies.unwrap_or_default();
    rig
}

fn comes_to_rest(decision: &v1::Decision) -> bool {
    let settling = decision.settling.as_ref();
    settling.is_some_and(|settling| settling.is_still)
}

#[test]
fn unknown_items_are_tried_with_the_shapes_that_were_seen() {
    let rig = Rig::new(coarse());
    rig.begin_with(&["a", "b"]);
    let first = rig.decision();
    assert!(comes_to_rest(&first), "{first:?}");
    assert!(says(&first, "tried with the shape"), "{first:?}");
    assert!(!says(&first, "in the container"), "{first:?}");
    rig.place_square(&first, 6, true);
    let second = rig.decision();
    assert!(comes_to_rest(&second), "{second:?}");
    assert!(says(&second, "tried with the shape"), "{second:?}");
    assert!(
        says(&second, "items in the container took part"),
        "{second:?}"
    );
}

#[test]
fn a_body_of_no_known_shape_is_as_the_heightmap_shows_it() {
    let stranger = body("stranger", "of no catalogue", Isometry3::identity(), true);
    let rig = among(Some(vec![stranger]), &["a"]);
    rig.seen.lock().unwrap().raise((0, 0), 32, 0.05);
    let decision = rig.decision();
    // It comes to rest where it was planned, on what nobody knows.
    assert!(comes_to_rest(&decision), "{decision:?}");
    assert!(
        says(&decision, "on the heightmap of the others"),
        "{decision:?}"
    );
}

#[test]
fn what_lay_there_before_the_session_is_as_the_heightmap_shows_it() {
    for has_bridge in [false, true] {
        let mut rig = Rig::new(CellSettings {
            compare_content: true,
            ..coarse()
        });
        if has_bridge {
            // It knows of nothing that it placed.
            rig.bridge_says(|| v1::CellState {
                state_number: 1_000,
                ..v1::CellState::default()
            });
        }
        rig.seen.lock().unwrap().raise((0, 0), 32, 0.05);
        rig.begin_with(&["a", "b"]);
        for _ in 0..2 {
            let decision = rig.decision();
            assert!(comes_to_rest(&decision), "{decision:?}");
            assert!(says(&decision, "on the heightmap of the others"));
            rig.place_square(&decision, 6, true);
        }
    }
}

#[test]
fn a_body_that_the_bridge_calls_otherwise_is_where_the_session_has_its_item() {
    // In the frame of that object.
    let at = Isometry3::translation(5.0, 5.0, 5.0);
    let body = body("a", "of no catalogue", at, true);
    let rig = among(Some(vec![body]), &["a", "b"]);
    // The bridge says that it lies there before the session knows where.
    let first = rig.decision();
    assert_eq!(first.item_id, "a");
    assert!(says(&first, "on the heightmap of the others"), "{first:?}");
    rig.place_square(&first, 6, true);
    let second = rig.decision();
    assert!(
        says(&second, "items in the container took part"),
        "{second:?}"
    );
    assert!(
        !says(&second, "on the heightmap of the others"),
        "{second:?}"
    );
}

/// A block that the bridge says to lie in the corner.
fn in_the_corner(is_found: bool) -> v1::Body {
    body("a", "", Isometry3::translation(0.03, 0.03, 0.0), is_found)
}

/// Whether an item in the container took part in a try as a body, or as the heightmap shows it.
fn took_part(decision: &v1::Decision) -> bool {
    let as_body = says(decision, "items in the container took part");
    assert_ne!(as_body, says(decision, "on the heightmap of the others"));
    assert!(comes_to_rest(decision), "{decision:?}");
    as_body
}

#[test]
fn a_body_that_the_bridge_only_assumes_is_as_the_heightmap_shows_it() {
    for is_found in [true, false] {
        let rig = among(Some(vec![in_the_corner(is_found)]), &["a", "b"]);
        rig.seen.lock().unwrap().raise((0, 0), 6, 0.04);
        assert_eq!(took_part(&rig.decision()), is_found);
    }
}

#[test]
fn a_reported_item_is_a_body_where_it_was_found_whatever_the_bridge_assumes() {
    let assumed = || Some(vec![in_the_corner(false)]);
    for (bodies, is_found) in [(None, true), (None, false), (assumed(), true)] {
        let rig = among(bodies, &["a", "b"]);
        let first = rig.decision();
        assert_eq!(first.item_id, "a");
        rig.place_square(&first, 6, is_found);
        assert_eq!(took_part(&rig.decision()), is_found);
    }
}

#[test]
fn a_plan_with_too_little_time_to_try_is_the_best_untried_and_says_so() {
    let mut settings = coarse();
    // A try takes longer than the plan may.
    settings.twin.rough.timestep_s = 2e-6;
    settings.twin.rough.substeps = 64;
    let rig = Rig::new(settings);
    rig.begin_with(&["a"]);
    let plan = v1::PlanRequest::default();
    let reply = rig.client.call(&cell(), plan, in_ms(1_500)).unwrap();
    let decision = reply.decision.unwrap();
    assert!(says(&decision, "the item may not stay"), "{decision:?}");
    assert_eq!(decision.settling, None);
}
