//! What a tried placement would load the items below with, against what they may carry.
use std::sync::Arc;

use ppnpack_packing::checks::check::{ValidityCheck, Verdict};
use ppnpack_packing::checks::loads::{Load, LoadSettings};
use ppnpack_packing::checks::trial::TrialSettings;
use ppnpack_packing::kernel::placement::RestingPlacement;
use ppnpack_packing::ranking::refusal::{Cause, Refusal};
use ppnpack_packing::ranking::step::Candidate;
use ppnpack_physics::trial::TrialCheck;
use ppnpack_physics::twin::TwinSettings;

use crate::common::{Content, Step, at, block, cuboid, lying, placed};

/// A block under the cells 10 to 16 along both sides, 50 units high, of 180 g; and one of 72 g on
/// it.
fn tower() -> Box<Content> {
    Box::new([
        (cuboid([0.06, 0.06, 0.1]), at(0.13, 0.13, 0.05)),
        (cuboid([0.06, 0.06, 0.04]), at(0.13, 0.13, 0.12)),
    ])
}

/// Where the next one rests on the tower.
fn on_top() -> RestingPlacement {
    placed(10, 10, 70)
}

/// 6 x 6 x 5 cm, of 90 g.
fn small() -> Candidate {
    block(0, [6, 6], 25)
}

/// What a check says of a placement where what lies lowest may carry so much, and then of the same
/// without a further try.
fn judged(
    held: Candidate,
    carries_kg: f64,
    margin: f64,
    resting: &RestingPlacement,
) -> (Verdict, Option<Refusal>) {
    let mut solids = lying(&tower());
    solids[0].burden.carries_kg = Some(carries_kg);
    solids[0].burden.name = Arc::from("glass");
    let step = Step::new(solids, [held]);
    let (input, held) = (step.input(), &step.held[0]);
    let check = TrialCheck::new(TrialSettings::default(), TwinSettings::default()).unwrap();
    let mut check = check.with_loads(&LoadSettings {
        tried_margin: margin,
        ..LoadSettings::default()
    });
    check.begin(&input).unwrap();
    let verdict = check.judge(&input, held, resting).unwrap();
    let unseen = check.refuses_unseen(&input, held, resting);
    (verdict, unseen)
}

fn accepted(held: Candidate, carries_kg: f64, margin: f64) -> Load {
    match judged(held, carries_kg, margin, &on_top()) {
        (Verdict::Accepted(evidence), None) => evidence.load.unwrap(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_is_passed_down_through_the_pile_is_held_against_the_limit() {
    // 72 g lie on it, and 90 g come; what is over by less than a simulation trembles is not too
    // much.
    let load = accepted(small(), 0.161, 1.0);
    assert_eq!(load.item, "glass");
    assert!((load.estimated_kg - 0.162).abs() < 0.002, "{load:?}");
    let (verdict, unseen) = judged(small(), 0.15, 1.0, &on_top());
    let Verdict::Refused(refusal) = verdict else {
        panic!("{verdict:?}");
    };
    assert_eq!(refusal.cause, Cause::Load);
    let detail = refusal.detail.clone().unwrap_or_default();
    assert!(detail.contains("glass would carry up to 1"), "{detail}");
    // Neither this nor one beside it is tried again.
    assert_eq!(unseen, Some(refusal));
}

#[test]
fn what_was_told_of_a_mass_counts_and_no_margin_is_more_than_all_that_is_above() {
    let heavy = Candidate {
        mass_kg: Some(0.9),
        ..small()
    };
    let load = accepted(heavy.clone(), 0.97, 2.0);
    // A margin does not count more than all that is above.
    assert!((load.estimated_kg - 0.972).abs() < 0.01, "{load:?}");
    assert!(!judged(heavy, 0.9, 1.0, &on_top()).0.is_accepted());
}

#[test]
fn what_lies_beside_it_is_loaded_by_nothing_more_and_what_carries_all_is_not_tried() {
    let load =
        |carries_kg, resting: &RestingPlacement| match judged(small(), carries_kg, 1.0, resting) {
            (Verdict::Accepted(evidence), _) => evidence.load,
            other => panic!("{other:?}"),
        };
    let beside = load(0.08, &placed(20, 20, 0)).unwrap();
    assert!((beside.estimated_kg - 0.072).abs() < 0.002, "{beside:?}");
    assert_eq!(load(0.2, &on_top()), None);
}
