use std::collections::BTreeSet;

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

fn ids(ids: &[&str]) -> Vec<String> {
    ids.iter().map(|id| (*id).to_owned()).collect()
}

/// Ends all holds of a cell.
fn end_holds(ledger: &mut Ledger) {
    let holds = ledger.head().holds.iter();
    let ids: Vec<String> = holds.map(|hold| hold.id.clone()).collect();
    ledger.apply(ledger.resume(&ids, 0).unwrap());
}

/// Begins a placement, which fails; says whether that left the cell held.
fn fail(ledger: &mut Ledger, placement: Placement) -> bool {
    ledger.apply(ledger.accept(placement));
    let is_held = ledger.is_held();
    let missed = Finding::failed(Ending::NotPlaced, "missed");
    ledger.apply(ledger.end_placement(missed, Vec::new()));
    is_held
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
        assert_eq!(ledger.is_held(), !is_simulated);
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
            (head.state_number, &head.bodies),
            (before + 1, &vec![body("a")])
        );
        assert_eq!(ledger.is_held(), !is_simulated);
        end_holds(&mut ledger);
        assert_eq!(ledger.judge_renewal("r"), RenewalVerdict::New);
    }
}

#[test]
fn each_hold_is_ended_by_its_id_and_the_last_lets_the_cell_go_on() {
    let mut ledger = Ledger::without_past();
    let state = ledger.head().state_number;
    ledger.apply(ledger.accept(placement("a", state)));
    ledger.apply(ledger.hold(Hold::new("h1", "door", "a door is open")));
    ledger.apply(ledger.hold(Hold::new("h2", "operator", "somebody looks")));
    // Sent again, it is the same one.
    ledger.apply(ledger.hold(Hold::new("h1", "door", "a door is open")));
    ledger.apply(ledger.recover(false).unwrap());
    let holds = &ledger.head().holds;
    let reasons = format!("a door is open; somebody looks; {PLACEMENT_CUT_OFF}");
    assert_eq!(holds.to_string(), reasons);
    let own: Vec<&Hold> = holds.iter().filter(|hold| hold.holder == BRIDGE).collect();
    let [own] = own[..] else { panic!("{holds}") };
    let own = own.id.clone();
    let before = ledger.head().state_number;
    // The door alone is closed: what is not there any more, or was not yet, is passed over.
    ledger.apply(ledger.resume(&ids(&["h1", "h9"]), 0).unwrap());
    assert!(ledger.is_held() && ledger.head().state_number == before);
    assert_eq!(ledger.resume(&ids(&["h1"]), 0), None);
    assert_eq!(ledger.resume(&[], 0), None);
    ledger.apply(ledger.resume(&ids(&["h2", &own]), 0).unwrap());
    assert!(!ledger.is_held());
    assert_eq!(ledger.head().state_number, before + 1);
    // Whatever it names, it was ended.
    assert_eq!(ledger.resume(&ids(&["h1"]), 3).unwrap(), ledger.no_change());
}

#[test]
fn a_full_set_of_holds_takes_one_more_and_whoever_saw_the_last_alone_ends_neither() {
    let mut ledger = Ledger::without_past();
    for number in 0..40 {
        let hold = Hold::new(&format!("h{number}"), "", &format!("reason {number}"));
        ledger.apply(ledger.hold(hold));
    }
    let holds = &ledger.head().holds;
    assert_eq!(holds.iter().count(), 32);
    let last = holds.iter().last().unwrap();
    assert_eq!(last.id, "h39");
    assert!(last.reason.starts_with("reason 39; reason 38; "));
    assert!(last.reason.ends_with("; reason 31"), "{}", last.reason);
    assert_eq!(ledger.resume(&ids(&["h31", "h38"]), 0), None);
    // However often it is said, it is kept once.
    for number in 40..10_000 {
        ledger.apply(ledger.hold(Hold::new(&format!("h{number}"), "", "again")));
    }
    let last = &ledger.head().holds.iter().last().unwrap().reason;
    assert!(last.starts_with("again; reason 39; "), "{last}");
}

#[test]
fn so_many_placements_begin_as_a_resume_asks_for_and_the_last_holds_the_cell() {
    let mut ledger = Ledger::without_past();
    let fail = |ledger: &mut Ledger, id: &str| {
        let asked = placement(id, ledger.head().state_number);
        assert_eq!(ledger.judge(&asked), PlacementVerdict::New, "{id}");
        fail(ledger, asked)
    };
    ledger.apply(ledger.hold(Hold::new("h1", "", "a look")));
    ledger.apply(ledger.resume(&ids(&["h1"]), 2).unwrap());
    assert!(!fail(&mut ledger, "a"));
    // A renewal is none of them.
    ledger.apply(ledger.begin_renewal("r".to_owned()));
    ledger.apply(ledger.end_renewal(Vec::new()));
    assert!(fail(&mut ledger, "b"));
    // The request for the step once more, which is late.
    assert_eq!(ledger.resume(&ids(&["h1"]), 2), None);
    let next = placement("c", ledger.head().state_number);
    assert!(matches!(ledger.judge(&next), PlacementVerdict::Held(_)));

    // Somebody else holds it meanwhile: then the limit is of the past.
    let stepped = ledger.head().holds.iter().next().unwrap().id.clone();
    ledger.apply(ledger.resume(&ids(&[&stepped]), 1).unwrap());
    ledger.apply(ledger.hold(Hold::new("h2", "", "a look")));
    end_holds(&mut ledger);
    assert!(!fail(&mut ledger, "d") && !fail(&mut ledger, "e"));
}

#[test]
fn a_real_cell_without_a_past_begins_held_until_somebody_has_looked() {
    let mut ledger = Ledger::without_past();
    assert_eq!(ledger.recover(true), None);
    ledger.apply(ledger.recover(false).unwrap());
    assert!(ledger.head().holds.to_string().contains("nothing is known"));
    // Started again before anybody came, it is held once.
    assert_eq!(ledger.recover(false), None);
    end_holds(&mut ledger);
    assert_eq!(ledger.recover(false), None);
}

#[test]
fn of_what_is_forgotten_nothing_is_said() {
    let mut ledger = Ledger::without_past();
    let first = placement("first", ledger.head().state_number);
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
    let states = (0..50).map(|_| Ledger::without_past().head().state_number);
    let distinct = BTreeSet::from_iter(states);
    // In one millisecond two of fifty have the same random bits once in a thousand times.
    assert!(distinct.len() > 45, "{distinct:?}");
    assert!(distinct.iter().all(|state| *state > 1 << 60));
}

#[test]
fn a_restored_ledger_goes_on_at_a_state_of_its_own_whatever_the_clock_says() {
    // Far in the future: what the clock says now is a state that the cell had, or has had since the
    // backup.
    let head = Head {
        state_number: 1 << 62,
        ..Ledger::without_past().head().clone()
    };
    let backup = Ledger::of(head, BTreeMap::new());
    let mut since = backup.clone();
    for _ in 0..1_000 {
        since.apply(since.find_bodies(Vec::new()));
    }
    let states = (0..50).map(|_| backup.restored(FROM_BACKUP).head.state_number);
    let distinct = BTreeSet::from_iter(states);
    assert!(
        distinct
            .iter()
            .all(|state| *state > since.head().state_number)
    );
    assert!(distinct.len() > 1);
}
