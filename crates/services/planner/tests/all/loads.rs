//! No item is loaded with more than it may carry, and containers stay balanced: by what is told of items, else by what is estimated.

use crate::common::rig::Rig;
use crate::common::{self, announcement, block, cell, soon, square};
use ppnpack_packing::loads::LoadSettings;
use ppnpack_packing::method::Method;
use ppnpack_packing::trial::TrialSettings;
use ppnpack_planner::CellSettings;
use ppnpack_wire::v1::{self, PlanResult, Status};

/// A cell in which nothing is tried, so that only loads ask for what lies in the container.
fn settings(loads: LoadSettings) -> CellSettings {
    CellSettings {
        method: Method {
            trial: TrialSettings::off(),
            loads,
            ..crate::common::method()
        },
        ..crate::common::coarse()
    }
}

fn rig() -> Rig {
    Rig::new(None, settings(LoadSettings::default()))
}

/// How many cells a slab is wide: as many as the container, so that slabs can only be stacked.
const SLAB: usize = 32;

/// A slab of this mass, in kilograms, that may carry so much.
fn loaded(item_id: &str, mass_kg: f64, carries_kg: Option<f64>) -> v1::Announcement {
    v1::Announcement {
        rules: Some(v1::ItemRules {
            carries_kg,
            ..v1::ItemRules::default()
        }),
        order_line: Some(v1::OrderLine {
            mass_kg,
            ..v1::OrderLine::default()
        }),
        ..announcement(item_id, square("slab", SLAB, 0.0001))
    }
}

fn announce(rig: &Rig, item: v1::Announcement) {
    rig.call(v1::AnnounceRequest {
        items: vec![item],
        ..v1::AnnounceRequest::default()
    });
}

/// Places a slab at once; gives what its decision says that it loads.
fn place(rig: &Rig, item: v1::Announcement) -> Option<v1::Load> {
    announce(rig, item);
    let decision = rig.decision();
    rig.place_square(&decision, SLAB, true);
    decision.load.map(|load| *load)
}

/// Announces a slab that has no place; gives why. It is withdrawn.
fn refused(rig: &Rig, item: v1::Announcement) -> v1::ItemReason {
    let item_id = item.item_id.clone();
    announce(rig, item);
    let reply = rig.call(v1::PlanRequest::default());
    assert_eq!(reply.result(), PlanResult::NothingFits, "{reply:?}");
    rig.call(v1::WithdrawRequest {
        item_id,
        ..v1::WithdrawRequest::default()
    });
    reply.reasons.into_iter().next().unwrap()
}

#[test]
fn an_item_is_loaded_with_no_more_than_it_may_carry() {
    let rig = rig();
    common::begin(&rig.client);
    assert_eq!(place(&rig, loaded("base", 1.0, Some(0.2))), None);
    let reason = refused(&rig, loaded("heavy", 1.0, None));
    assert!(
        reason.text.contains("base would carry up to 800 g more"),
        "{reason:?}"
    );
    let load = place(&rig, loaded("light", 0.15, None)).unwrap();
    assert_eq!((load.item_id.as_str(), load.carries_kg), ("base", 0.2));
    assert!((load.estimated_kg - 0.15).abs() < 1e-9, "{load:?}");
    // What lies on it already counts, through the item between.
    let reason = refused(&rig, loaded("more", 0.1, None));
    assert!(reason.text.contains("base would carry"), "{reason:?}");
    let least = place(&rig, loaded("least", 0.04, None)).unwrap();
    assert_eq!(least.item_id, "base");
    assert!((least.estimated_kg - 0.19).abs() < 1e-9, "{least:?}");

    let session = rig.call(v1::SessionRequest::default()).session.unwrap();
    let kept = |item_id: &str| {
        let mut items = session.items.iter();
        let item = items.find(|item| item.item_id == item_id).unwrap();
        item.load.as_deref().cloned()
    };
    assert_eq!(kept("base"), None);
    assert_eq!(kept("light"), Some(load));
    assert_eq!(kept("least"), Some(least));
    rig.finish();
}

#[test]
fn what_is_only_assumed_to_lie_there_carries_no_more_than_it_may() {
    let rig = rig();
    common::begin(&rig.client);
    announce(&rig, loaded("base", 1.0, Some(0.2)));
    rig.place_square(&rig.decision(), SLAB, false);
    let reason = refused(&rig, loaded("heavy", 1.0, None));
    assert!(reason.text.contains("base would carry"), "{reason:?}");
    rig.finish();
}

#[test]
fn a_mass_that_nobody_told_is_estimated() {
    let rig = rig();
    common::begin(&rig.client);
    place(&rig, loaded("base", 0.0, Some(0.01)));
    // A hundred cubic centimetres.
    let reason = refused(&rig, loaded("seen", 0.0, None));
    assert!(
        reason.text.contains("base would carry up to 30 g more"),
        "{reason:?}"
    );
    rig.finish();
}

#[test]
fn what_was_announced_to_carry_nothing_carries_nothing() {
    let rig = rig();
    common::begin(&rig.client);
    place(&rig, loaded("base", 1.0, Some(0.0)));
    let reason = refused(&rig, loaded("light", 0.001, None));
    assert!(reason.text.contains("base would carry"), "{reason:?}");
    rig.finish();
}

#[test]
fn no_item_carries_less_than_nothing_or_more_than_anything() {
    let rig = rig();
    common::begin(&rig.client);
    for carries_kg in [-0.1, f64::NAN, f64::INFINITY, 10_001.0] {
        let request = v1::AnnounceRequest {
            items: vec![loaded("a", 1.0, Some(carries_kg))],
            ..v1::AnnounceRequest::default()
        };
        let refused = rig.client.call(&cell(), request, soon()).unwrap_err();
        assert_eq!(refused.status(), Some(Status::Invalid), "{refused}");
        assert!(refused.to_string().contains("carries_kg"), "{refused}");
    }
    rig.finish();
}

#[test]
fn a_container_stays_balanced() {
    let rig = Rig::new(
        None,
        settings(LoadSettings {
            imbalance_kg_m: Some(0.02),
            ..LoadSettings::default()
        }),
    );
    common::begin(&rig.client);
    let block = |item_id| v1::Announcement {
        shape: Some(v1::announcement::Shape::Item(block())),
        ..loaded(item_id, 1.0, None)
    };
    announce(&rig, block("first"));
    let first = rig.decision();
    let centre = |decision: &v1::Decision| {
        let pose = decision.container_from_item.as_ref().unwrap();
        let at = pose.position.as_ref().unwrap();
        (at.x_m - 0.16, at.y_m - 0.16)
    };
    let (x, y) = centre(&first);
    assert!(x.hypot(y) <= 0.02 + 1e-9, "{first:?}");
    rig.place(&first);
    announce(&rig, block("second"));
    let second = rig.decision();
    let (other_x, other_y) = centre(&second);
    assert!(
        (x + other_x).hypot(y + other_y) <= 0.02 + 1e-9,
        "{second:?}"
    );
    rig.finish();
}
