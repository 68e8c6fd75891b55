//! Orders: what travels together, what leaves first, and what never comes.

use crate::common::{self, Rig, announcement, close, ids, left_and_right, line, of_order, square};
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::heightmap::Surface;
use ppnpack_packing::streams::orders::Sharing;
use ppnpack_service::ServiceSettings;
use ppnpack_wire::v1::{self, Status};

#[test]
fn an_undivided_order_cannot_follow_into_a_closed_container() {
    let mut settings = left_and_right();
    settings.rules.undivided = true;
    settings.set_aside = 5;
    let rig = Rig::new(settings);
    rig.begin();
    rig.announce(["a", "b", "c"].map(|item_id| line(item_id, of_order("7"))));
    assert_eq!(rig.step().container, "left");
    assert_eq!(rig.step().container, "left");
    rig.call(close("left", 0));
    // It is not set aside, either.
    let reasons = rig.try_step().unwrap_err();
    assert_eq!(ids(&reasons), ["c"]);
    assert_eq!(reasons[0].reason(), v1::Reason::Rule);
    assert_eq!(
        reasons[0].text,
        "container right: the items of order 7 must not be divided, and others of them are in a container that was closed"
    );
    // By another order it may.
    rig.withdraw("c");
    rig.announce([line("c2", of_order("8"))]);
    assert_eq!(rig.step().container, "right");
}

#[test]
fn nothing_is_placed_above_what_leaves_at_an_earlier_stop() {
    let rig = Rig::new(common::untried());
    rig.begin();
    // As wide as the floor, so that every item lies above those before.
    let at = |item_id: &str, stop| v1::Announcement {
        order_line: Some(v1::OrderLine {
            stop,
            ..v1::OrderLine::default()
        }),
        ..announcement(item_id, square("plate", 32, 0.001))
    };
    rig.announce([at("second", 2)]);
    assert_eq!(rig.step().item_id, "second");
    let mut surface = Surface::empty(&Grid::reference());
    for x in 0..surface.nx() {
        for y in 0..surface.ny() {
            surface.raise(x, y, 0.02);
        }
    }
    rig.seen.lock().unwrap().surface = Some(surface);
    rig.announce([at("third", 3), at("last", 0)]);
    let reasons = rig.try_step().unwrap_err();
    assert_eq!(reasons[0].reason(), v1::Reason::Rejected);
    for (reason, text) in reasons.iter().zip([
        "above what leaves earlier wherever it fits: stop 3 above stop 2",
        "no stop above stop 2",
    ]) {
        assert!(reason.text.contains(text), "{reason:?}");
    }
    let counts = rig.explain("third").counts.unwrap();
    let mut refusals = counts.refusals.iter();
    let is_there = refusals.any(|refusals| refusals.check() == v1::Check::Sequence);
    assert!(is_there, "{counts:?}");
    rig.announce([at("first", 1)]);
    assert_eq!(rig.step().item_id, "first");
}

#[test]
fn an_order_is_complete_when_all_came_or_no_more_is_expected() {
    let mut settings = left_and_right();
    settings.rules.sharing = Sharing::OneOrder;
    settings.closing.rules.order_complete = true;
    let rig = Rig::new(settings);
    rig.begin();
    let of_three = |item_id: &str, order: &str| {
        let order_line = v1::OrderLine {
            order_items: 3,
            ..of_order(order)
        };
        line(item_id, order_line)
    };
    rig.announce(["a", "b"].map(|item_id| of_three(item_id, "7")));
    rig.step();
    rig.step();
    assert!(rig.session().closed.is_empty());
    let no_more = |order: &str| v1::WithdrawRequest {
        order: order.to_owned(),
        ..v1::WithdrawRequest::default()
    };
    let says = "no item of order 8 was announced";
    rig.assert_refused(no_more("8"), Status::NotFound, says);
    let both = v1::WithdrawRequest {
        item_id: "a".to_owned(),
        ..no_more("7")
    };
    rig.assert_refused(both, Status::Invalid, "");
    rig.call(no_more("7"));
    let closed = rig.session().closed;
    assert_eq!(closed.len(), 1);
    assert_eq!(closed[0].reason(), v1::ClosingReason::OrderComplete);
    // The same announcement again, as after a restart of the controller, is no other item.
    rig.announce([of_three("a", "7")]);
    let without = common::announce([of_three("x", "")]);
    rig.assert_refused(without, Status::Invalid, "give order, too");
}

#[test]
fn groups_that_must_and_must_not_travel_together_are_refused() {
    let pair = || vec![("food".to_owned(), "soap".to_owned())];
    let mut settings = common::coarse();
    settings.rules.apart = pair();
    settings.rules.together = pair();
    let refused = common::settings(settings).validate().unwrap_err();
    assert!(
        refused.contains("rules.together: food and soap"),
        "{refused}"
    );
}
