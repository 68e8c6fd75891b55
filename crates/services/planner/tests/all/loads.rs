//! No item is loaded with more than it may carry, and containers stay balanced: by what is told of
//! items, else by what is estimated.

use crate::common::{self, Rig, announcement, line, of_mass, square};
use ppnpack_packing::checks::loads::LoadSettings;
use ppnpack_wire::v1::{self, PlanResult, Status};

/// A cell in which only loads ask for what lies in the container, with a session.
fn rig(loads: LoadSettings) -> Rig {
    let mut settings = common::untried();
    settings.method.loads = loads;
    let rig = Rig::new(settings);
    rig.begin();
    rig
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
        order_line: Some(of_mass(mass_kg)),
        ..announcement(item_id, square("slab", SLAB, 0.0001))
    }
}

/// Places a slab at once, where it is found or only assumed to be; gives what its decision says
/// that it loads.
fn place(rig: &Rig, item: v1::Announcement, is_found: bool) -> Option<v1::Load> {
    rig.announce([item]);
    let decision = rig.decision();
    rig.place_square(&decision, SLAB, is_found);
    decision.load.map(|load| *load)
}

/// Announces a slab that has no place as `base` would carry too much, and withdraws it.
fn assert_refused(rig: &Rig, item: v1::Announcement, text: &str) {
    let item_id = item.item_id.clone();
    rig.announce([item]);
    let reply = rig.plan();
    assert_eq!(reply.result(), PlanResult::NothingFits, "{reply:?}");
    rig.withdraw(&item_id);
    let reason = &reply.reasons[0];
    let expected = format!("base would carry{text}");
    assert!(reason.text.contains(&expected), "{reason:?}");
}

#[test]
fn an_item_is_loaded_with_no_more_than_it_may_carry() {
    let rig = rig(LoadSettings::default());
    assert_eq!(place(&rig, loaded("base", 1.0, Some(0.2)), true), None);
    assert_refused(&rig, loaded("heavy", 1.0, None), " up to 800 g more");
    let light = place(&rig, loaded("light", 0.15, None), true).unwrap();
    assert_eq!((light.item_id.as_str(), light.carries_kg), ("base", 0.2));
    assert!((light.estimated_kg - 0.15).abs() < 1e-9, "{light:?}");
    // What lies on it already counts, through the item between.
    assert_refused(&rig, loaded("more", 0.1, None), "");
    let least = place(&rig, loaded("least", 0.04, None), true).unwrap();
    assert_eq!(least.item_id, "base");
    assert!((least.estimated_kg - 0.19).abs() < 1e-9, "{least:?}");

    let session = rig.session();
    for (item_id, load) in [
        ("base", None),
        ("light", Some(light)),
        ("least", Some(least)),
    ] {
        let mut items = session.items.iter();
        let item = items.find(|item| item.item_id == item_id).unwrap();
        assert_eq!(item.load.as_deref().cloned(), load);
    }
}

#[test]
fn what_is_assumed_to_lie_there_of_a_mass_that_nobody_told_or_may_carry_nothing_is_not_overloaded()
{
    for (base, is_found, other, text) in [
        (
            loaded("base", 1.0, Some(0.2)),
            false,
            loaded("heavy", 1.0, None),
            "",
        ),
        // A hundred cubic centimetres.
        (
            loaded("base", 0.0, Some(0.01)),
            true,
            loaded("seen", 0.0, None),
            " up to 30 g more",
        ),
        (
            loaded("base", 1.0, Some(0.0)),
            true,
            loaded("light", 0.001, None),
            "",
        ),
    ] {
        let rig = rig(LoadSettings::default());
        place(&rig, base, is_found);
        assert_refused(&rig, other, text);
    }
}

#[test]
fn no_item_carries_less_than_nothing_or_more_than_anything() {
    let rig = rig(LoadSettings::default());
    for carries_kg in [-0.1, f64::NAN, f64::INFINITY, 10_001.0] {
        let request = common::announce([loaded("a", 1.0, Some(carries_kg))]);
        rig.assert_refused(request, Status::Invalid, "carries_kg");
    }
}

#[test]
fn a_container_stays_balanced() {
    let rig = rig(LoadSettings {
        imbalance_kg_m: Some(0.02),
        ..LoadSettings::default()
    });
    let mut moment_kg_m = [0.0, 0.0];
    for item_id in ["first", "second"] {
        rig.announce([line(item_id, of_mass(1.0))]);
        let decision = rig.decision();
        let pose = decision.container_from_item.as_ref().unwrap();
        let at = pose.position.as_ref().unwrap();
        moment_kg_m[0] += at.x_m - 0.16;
        moment_kg_m[1] += at.y_m - 0.16;
        let [x, y]: [f64; 2] = moment_kg_m;
        assert!(x.hypot(y) <= 0.02 + 1e-9, "{decision:?}");
        rig.place_square(&decision, 6, true);
    }
}
