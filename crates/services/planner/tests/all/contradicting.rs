//! Pictures that contradict what the cell believes to lie in its container.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crate::common::{
    self, Rig, announcement, block, carried_out, ended, not_placed, placed_and, soon, state_reply,
    states,
};
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::heightmap::Surface;
use ppnpack_planner::CellSettings;
use ppnpack_service::rpc::Incoming;
use ppnpack_wire::v1::{self, ItemState};

/// A cell that holds pictures against what it believes, with two containers that look alike: the
/// one on the left is filled as long as it can be planned on.
fn two_compared() -> CellSettings {
    CellSettings {
        compare_content: true,
        ..common::left_and_right()
    }
}

/// Plans a step, which is not carried out; the next is planned on another picture. Gives where to,
/// and what is said of it.
fn look(rig: &Rig) -> (String, String) {
    let decision = rig.decision();
    rig.call(not_placed(&decision, decision.state_number + 1));
    (decision.container, decision.degraded.join("; "))
}

/// Why nothing is planned on what is shown of the container on the left.
fn why_not(rig: &Rig) -> String {
    let (container, why) = look(rig);
    assert_eq!(container, "right", "{why}");
    why
}

/// Where a decision puts its item, by the cell of its corner.
fn corner(decision: &v1::Decision) -> (u32, u32) {
    let at = decision.placement.as_ref().unwrap();
    (at.x, at.y)
}

#[test]
fn nothing_is_planned_on_a_picture_that_lacks_an_item_until_one_shows_it() {
    for is_found in [true, false] {
        let rig = Rig::new(two_compared());
        rig.begin_with(&["a", "b"]);
        let first = rig.decision();
        assert_eq!(first.container, "left");
        let placed_in = first.state_number + 1;
        rig.call(placed_and(&first, placed_in, is_found));
        // What is shown is empty still.
        let why = why_not(&rig);
        assert!(why.contains("doubtful: item a is not to be seen"), "{why}");
        assert!(why.contains("`changed`"), "{why}");
        rig.seen.lock().unwrap().state_number = placed_in;
        rig.show_square(&first, 6);
        let second = rig.decision();
        assert_eq!((&*second.container, &*second.item_id), ("left", "b"));
        assert_ne!(corner(&second), corner(&first));
    }
}

#[test]
fn an_item_that_lies_elsewhere_in_the_picture_or_was_taken_out_by_hand_stops_nothing() {
    let mut rig = Rig::new(two_compared());
    let bodies = Arc::new(Mutex::new(Vec::new()));
    let told = Arc::clone(&bodies);
    rig.bridge_answers(move |incoming: &Incoming<v1::CellStateRequest>| {
        let is_left = incoming.cell().as_str() == "left";
        let bodies = told.lock().unwrap().clone();
        Some(state_reply(v1::CellState {
            // Later than any that is reported.
            state_number: 1_000,
            bodies: if is_left { bodies } else { Vec::new() },
            ..v1::CellState::default()
        }))
    });
    rig.begin_with(&["a", "b"]);
    let first = rig.decision();
    bodies.lock().unwrap().push(v1::Body {
        item_id: "a".to_owned(),
        container_from_item: first.container_from_item,
        is_inside: true,
        ..v1::Body::default()
    });
    let placed_in = first.state_number + 1;
    rig.call(placed_and(&first, placed_in, false));
    assert!(why_not(&rig).contains("item a"));

    // It slid to the other side.
    {
        let mut seen = rig.seen.lock().unwrap();
        seen.state_number = placed_in;
        seen.raise((20, 20), 6, 0.04);
    }
    assert_eq!(look(&rig).0, "left");

    // Somebody took it out, and then says so.
    {
        let mut seen = rig.seen.lock().unwrap();
        seen.surface = None;
        seen.state_number += 1;
    }
    assert!(why_not(&rig).contains("item a"));
    bodies.lock().unwrap().clear();
    assert_eq!(look(&rig).0, "left");
}

#[test]
fn what_comes_up_where_nothing_is_known_to_lie_has_plans_wait_until_somebody_has_looked() {
    for is_found in [true, false] {
        let rig = Rig::new(two_compared());
        rig.begin_with(&["a", "b", "c"]);
        rig.place_square(&rig.decision(), 6, is_found);
        let second = rig.decision();
        rig.seen.lock().unwrap().raise((22, 22), 8, 0.1);
        rig.place_square(&second, 6, is_found);
        // What only is assumed to lie elsewhere may be that.
        if is_found {
            let why = why_not(&rig);
            assert!(why.contains("cm² came up"), "{why}");
            // It stays, as somebody says by `changed`.
            rig.seen.lock().unwrap().state_number += 1;
        }
        assert_eq!(look(&rig).0, "left");
    }
}

#[test]
fn a_picture_is_not_compared_where_that_is_switched_off() {
    let rig = Rig::new(CellSettings {
        compare_content: false,
        ..common::untried()
    });
    rig.begin_with(&["a", "b"]);
    let first = rig.decision();
    rig.call(placed_and(&first, first.state_number + 1, true));
    assert_eq!(corner(&rig.decision()), corner(&first));
}

#[test]
fn a_frozen_camera_has_one_item_placed_and_no_other_in_its_place() {
    let [shown, placed, placed_at] = [(); 3].map(|()| Arc::new(AtomicU64::new(0)));
    let settings = CellSettings {
        compare_content: true,
        ..common::untried()
    };
    // New heightmaps, of the state that is asked for, with the same old picture.
    let showing = Arc::clone(&shown);
    let mut rig = Rig::shown_by(settings, &[], move |incoming| {
        let grid = Grid::reference();
        let sequence = 1 + showing.fetch_add(1, Ordering::SeqCst);
        let state_number = incoming.message().least_state_number.max(2);
        common::show(
            incoming,
            &grid,
            Surface::empty(&grid),
            sequence,
            state_number,
        );
    });
    let (seen, count, at) = (shown.clone(), placed.clone(), placed_at.clone());
    rig.bridge_answers(move |incoming: &Incoming<v1::PlaceRequest>| {
        at.store(seen.load(Ordering::SeqCst), Ordering::SeqCst);
        count.fetch_add(1, Ordering::SeqCst);
        let request = incoming.message();
        Some(ended(request, carried_out(request)))
    });
    rig.begin();
    rig.switch(true);
    rig.announce(["a", "b"].map(|item_id| announcement(item_id, block())));
    // Until the planner has looked at several pictures since the placement.
    let until = soon();
    let has_looked = || {
        let since = shown.load(Ordering::SeqCst) - placed_at.load(Ordering::SeqCst);
        placed.load(Ordering::SeqCst) > 0 && since >= 10
    };
    while !has_looked() {
        assert!(Instant::now() < until, "nothing is asked for");
        std::thread::sleep(Duration::from_millis(20));
    }
    let session = rig.session();
    assert_eq!(placed.load(Ordering::SeqCst), 1);
    let expected = [ItemState::Packed, ItemState::Waiting];
    assert_eq!(states(&session), expected);
    assert_eq!(session.end, 0);
    rig.switch(false);
}
