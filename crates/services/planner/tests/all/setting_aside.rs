//! Items that have no valid placement are set aside for the next container.

use crate::common::{self, Rig, announcement, block, cell, ids, placed, soon, square, states};
use ppnpack_planner::CellSettings;
use ppnpack_service::stream::Latest;
use ppnpack_wire::MAX_MESSAGE_BYTES;
use ppnpack_wire::keys::Stream;
use ppnpack_wire::v1::{self, ItemState, PlanResult, Reason, SessionEnd, Status};

/// An item that is larger than the container's floor.
fn slab(item_id: &str) -> v1::Announcement {
    slab_of(item_id, 0.006)
}

fn slab_of(item_id: &str, mesh_volume_m3: f64) -> v1::Announcement {
    announcement(item_id, square("slab", 40, mesh_volume_m3))
}

fn small(item_id: &str) -> v1::Announcement {
    announcement(item_id, block())
}

/// A cell with a buffer of so many items that may set so many aside.
fn rig(buffer: usize, set_aside: usize) -> Rig {
    let mut settings = CellSettings {
        set_aside,
        ..common::coarse()
    };
    settings.method.buffer = buffer;
    Rig::new(settings)
}

fn limited(set_aside: u32) -> v1::BeginRequest {
    v1::BeginRequest {
        set_aside: Some(set_aside),
        ..v1::BeginRequest::default()
    }
}

#[test]
fn an_item_that_fits_nowhere_is_set_aside_and_stays_so_over_a_restart() {
    let mut rig = rig(1, 1);
    let decisions: Latest<v1::Decision> =
        Latest::subscribe(rig.any_process(), &cell(), Stream::Plan, MAX_MESSAGE_BYTES).unwrap();
    let begun = rig.begin_as(v1::BeginRequest::default());
    assert_eq!(begun.set_aside_limit, 1);
    rig.announce([slab("large"), small("small")]);
    let reply = rig.plan();
    assert_eq!(ids(&reply.set_aside), ["large"]);
    assert_eq!(reply.set_aside[0].reason(), Reason::TooLarge);
    let decision = reply.decision.unwrap();
    assert_eq!(decision.item_id, "small");
    assert_eq!(decision.set_aside, reply.set_aside);
    assert_eq!(decision.stages[0].stage, "set_aside");
    // Who watches learns of it too.
    let published = decisions.wait(soon()).unwrap().message.unwrap();
    assert_eq!(published.set_aside, reply.set_aside);

    let before = rig.session();
    let expected = [ItemState::SetAside, ItemState::Decided];
    assert_eq!(states(&before), expected);
    assert_eq!(before.set_aside, reply.set_aside);
    rig.restart(&[], |_| {});
    assert_eq!(rig.session(), before);

    rig.call(placed(&decision, decision.state_number + 1));
    let reply = rig.plan();
    assert_eq!(reply.result(), PlanResult::NothingWaits);
    // That was at the step before.
    assert!(reply.set_aside.is_empty());
    assert_eq!(ids(&rig.session().set_aside), ["large"]);
}

#[test]
fn no_more_is_set_aside_than_may_be_until_something_is_taken_away() {
    let rig = rig(1, 1);
    rig.begin();
    rig.announce([slab("first"), slab("second"), small("small")]);
    // Asked again, it says the same.
    for _ in 0..2 {
        let reply = rig.plan();
        assert_eq!(reply.result(), PlanResult::NothingFits);
        assert_eq!(ids(&reply.set_aside), ["first"]);
        assert_eq!(ids(&reply.reasons), ["second"]);
    }
    let session = rig.withdraw("first");
    assert_eq!(session.items[0].state(), ItemState::Withdrawn);
    assert_eq!(ids(&rig.step().set_aside), ["second"]);

    // One that is set aside is tried again when it is announced again.
    rig.announce([slab("second")]);
    let session = rig.session();
    assert_eq!(session.items[1].state(), ItemState::Waiting);
    assert!(session.set_aside.is_empty());
    let reply = rig.plan();
    assert_eq!(reply.result(), PlanResult::NothingWaits);
    assert_eq!(ids(&reply.set_aside), ["second"]);
}

#[test]
fn the_largest_item_of_the_buffer_is_set_aside_first() {
    let rig = rig(3, 0);
    assert_eq!(rig.begin_as(limited(1)).set_aside_limit, 1);
    rig.announce([
        slab("small"),
        slab_of("large", 0.007),
        slab_of("as-large", 0.007),
        small("block"),
    ]);
    let decision = rig.decision();
    assert_eq!(ids(&decision.set_aside), ["large"]);
    assert_eq!(decision.item_id, "block");
}

#[test]
fn a_session_that_may_set_nothing_aside_says_that_nothing_fits() {
    let rig = rig(1, 5);
    assert_eq!(rig.begin_as(limited(0)).set_aside_limit, 0);
    rig.announce([slab("large"), small("small")]);
    let reply = rig.plan();
    assert_eq!(reply.result(), PlanResult::NothingFits);
    assert_eq!(ids(&reply.reasons), ["large"]);
    assert!(reply.set_aside.is_empty());
    let many = v1::BeginRequest {
        session_id: "many".to_owned(),
        ..limited(10_001)
    };
    rig.assert_refused(many, Status::Invalid, "");
    assert_eq!(rig.session().session_id, "s");
}

#[test]
fn the_automatic_mode_ends_with_the_others_set_aside_or_nothing_that_fits() {
    let mut rig = rig(2, 2);
    rig.begin_automatic();
    rig.announce([slab("first"), slab("second")]);
    let session = rig.ended();
    assert_eq!(session.end(), SessionEnd::OthersSetAside);
    assert_eq!(ids(&session.set_aside), ["first", "second"]);
    // By itself nothing is decided after a restart before the bridge has said what lies there.
    rig.bridge_says(v1::CellState::default);
    rig.restart(&[], |_| {});
    assert_eq!(rig.session(), session);

    // A third one is more than may be set aside.
    rig.announce([slab("third")]);
    let session = rig.ended();
    assert_eq!(session.end(), SessionEnd::NothingFits);
    assert_eq!(ids(&session.reasons), ["third"]);
    assert_eq!(ids(&session.set_aside), ["first", "second"]);
}
