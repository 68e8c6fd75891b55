use nalgebra::Isometry3;

use super::*;
use crate::placing::KnownPose;

fn placement(id: &str, state_number: u64) -> Placement {
    Placement {
        placement_id: id.to_owned(),
        item_id: format!("item-{id}"),
        object: "box".to_owned(),
        container_from_item: Isometry3::translation(0.1, 0.2, 0.3),
        state_number,
        cycle: None,
    }
}

fn body(item_id: &str) -> Body {
    Body {
        item_id: item_id.to_owned(),
        object: "box".to_owned(),
        container_from_item: KnownPose::Found(Isometry3::translation(0.1, 0.2, 0.25)),
        is_inside: true,
    }
}

#[test]
fn what_was_under_way_is_settled_after_a_restart() {
    let mut ledger = Ledger::without_past();
    let state = ledger.head().state_number;
    assert_eq!(ledger.recover(true), None);
    ledger.apply(ledger.accept(placement("a", state)));
    for (is_simulated, ending, after) in [
        (true, Ending::NotPlaced, state),
        (false, Ending::Unknown, state + 1),
    ] {
        let mut ledger = ledger.clone();
        ledger.apply(ledger.recover(is_simulated).unwrap());
        let (_, outcome) = ledger.placement("a").unwrap();
        let outcome = outcome.unwrap();
        assert_eq!(
            (outcome.finding.ending, outcome.state_number),
            (ending, after)
        );
        assert_eq!(ledger.under_way(), None);
        // Of a real robot nobody knows what it holds.
        assert_eq!(ledger.head().hold.is_some(), !is_simulated);
    }
}

#[test]
fn an_interrupted_renewal_leaves_what_is_known_and_a_real_cell_held() {
    let mut ledger = Ledger::without_past();
    ledger.apply(ledger.find_bodies(vec![body("a")]));
    ledger.apply(ledger.begin_renewal("r".to_owned()));
    for is_simulated in [true, false] {
        let mut ledger = ledger.clone();
        let before = ledger.head().state_number;
        ledger.apply(ledger.recover(is_simulated).unwrap());
        let head = ledger.head();
        assert_eq!(
            (head.state_number, &head.bodies[..]),
            (before + 1, &[body("a")][..])
        );
        assert_eq!(head.hold.is_some(), !is_simulated);
        ledger.apply(ledger.resume());
        assert_eq!(ledger.judge_renewal("r"), RenewalVerdict::New);
    }
}

#[test]
fn a_cell_that_was_held_already_is_held_for_what_the_bridge_finds_too() {
    let mut ledger = Ledger::without_past();
    ledger.apply(ledger.accept(placement("a", ledger.head().state_number)));
    ledger.apply(ledger.hold("a door is open"));
    ledger.apply(ledger.recover(false).unwrap());
    let reason = ledger.head().hold.clone().unwrap();
    assert!(reason.starts_with("a door is open; and "), "{reason}");
    assert!(reason.ends_with(PLACEMENT_CUT_OFF), "{reason}");
    ledger.apply(ledger.hold_besides(PLACEMENT_CUT_OFF));
    ledger.apply(ledger.hold("another reason"));
    assert_eq!(ledger.head().hold.as_deref(), Some(reason.as_str()));
}

#[test]
fn of_what_is_forgotten_nothing_is_said() {
    let mut ledger = Ledger::without_past();
    let first = placement("first", ledger.head().state_number);
    let fail = |ledger: &mut Ledger, placement: Placement| {
        ledger.apply(ledger.accept(placement));
        ledger
            .apply(ledger.end_placement(Finding::failed(Ending::NotPlaced, "missed"), Vec::new()));
    };
    fail(&mut ledger, first.clone());
    for number in 0..MAX_RECORDS {
        let next = placement(&number.to_string(), ledger.head().state_number);
        fail(&mut ledger, next);
    }
    assert_eq!(ledger.records().count(), MAX_RECORDS);
    assert_eq!(ledger.judge(&first), PlacementVerdict::Forgotten);
    // No sensor and no planner has it from this ledger.
    let other = placement("other", ledger.head().state_number + 1);
    assert_eq!(ledger.judge(&other), PlacementVerdict::Forgotten);
}

#[test]
fn a_ledger_without_a_past_begins_at_a_state_of_its_own() {
    let states: Vec<u64> = (0..50)
        .map(|_| Ledger::without_past().head().state_number)
        .collect();
    let mut distinct = states.clone();
    distinct.sort_unstable();
    distinct.dedup();
    assert_eq!(distinct.len(), states.len());
    assert!(states.iter().all(|state| *state > 1 << 60));
}

#[test]
fn a_restored_ledger_goes_on_at_a_state_of_its_own_whatever_the_clock_says() {
    // Far in the future: what the clock says now is a state that the cell had, or has had since the backup.
    let head = Head {
        state_number: 1 << 62,
        ..Ledger::without_past().head().clone()
    };
    let backup = Ledger::of(head, BTreeMap::new());
    let mut since = backup.clone();
    for _ in 0..1_000 {
        since.apply(since.find_bodies(Vec::new()));
    }
    let states: Vec<u64> = (0..50)
        .map(|_| backup.restored(FROM_BACKUP).head.state_number)
        .collect();
    assert!(
        states
            .iter()
            .all(|state| *state > since.head().state_number)
    );
    assert!(states.iter().any(|state| *state != states[0]));
}
