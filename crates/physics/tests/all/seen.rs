//! Items of which no more is known than what was seen, in placements that are tried.
use std::sync::Arc;

use nalgebra::Isometry3;
use ppnpack_catalogue::object::Model;
use ppnpack_catalogue::{seen, views};
use ppnpack_packing::checks::check::{Evidence, ValidityCheck, Verdict};
use ppnpack_packing::checks::trial::TrialSettings;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::kernel::placement::RestingPlacement;
use ppnpack_packing::ranking::step::{Candidate, StepInput};
use ppnpack_packing::scene::Scene;
use ppnpack_packing::scene::content::{Content, LyingBody, LyingSolid};
use ppnpack_physics::trial::TrialCheck;
use ppnpack_physics::twin::TwinSettings;

use crate::common::{at, cuboid, placed};

/// A box as an item.
fn item(model: &Model) -> Arc<Item> {
    Arc::new(views::item(model, Grid::reference().resolution()).unwrap())
}

/// A box whose solid is known, and the same as it was seen.
fn known_and_seen(sides_m: [f64; 3]) -> [Candidate; 2] {
    let model = cuboid(sides_m);
    let item = item(&model);
    let seen = Candidate::new(0, item);
    [seen.clone().with_model(model), seen]
}

fn tall() -> [Candidate; 2] {
    known_and_seen([0.03, 0.03, 0.1])
}

/// A box of 10 x 10 x 10 cm in the corner of the container.
fn base() -> LyingSolid {
    LyingSolid::new(cuboid([0.1; 3]), at(0.05, 0.05, 0.05))
}

/// The same as it was seen.
fn seen_base() -> LyingSolid {
    let known = base();
    let grid = Grid::reference();
    let item = item(&known.model);
    let model = seen::solid(&item, grid.resolution()).unwrap();
    let pose: Isometry3<f64> = item.container_from_item(&grid, &placed(0, 0, 0)).unwrap();
    LyingSolid::new(Arc::new(model), pose)
}

/// How high the container is with the base.
fn with_base() -> Heightmap {
    let mut heightmap = Heightmap::empty(&Grid::reference());
    for x in 0..10 {
        for y in 0..10 {
            heightmap.raise(x, y, 50);
        }
    }
    heightmap
}

/// What becomes of a candidate there, among the base, of which so much is known.
fn verdict(content: &[LyingBody], held: &Candidate, resting: &RestingPlacement) -> Verdict {
    let grid = Grid::reference();
    let content: Content = content.iter().cloned().collect();
    let scene = Scene::from_heightmap(with_base()).with_content(content);
    let input = StepInput::new(&grid, &scene, std::slice::from_ref(held));
    let settings = TrialSettings::default();
    let mut check = TrialCheck::new(settings, TwinSettings::default()).unwrap();
    check.begin(&input).unwrap();
    check.judge(&input, held, resting).unwrap()
}

/// What was found out about a placement that is accepted after it was tried.
fn accepted(verdict: Verdict) -> Evidence {
    match verdict {
        Verdict::Accepted(evidence) if evidence.settling.is_some() => evidence,
        other => panic!("{other:?}"),
    }
}

fn says(evidence: &Evidence, what: &str) -> bool {
    evidence.degraded.iter().any(|reason| reason.contains(what))
}

#[test]
fn a_flat_box_on_the_floor_is_accepted_either_way() {
    let [known, seen] = known_and_seen([0.1, 0.08, 0.03]);
    let content = [LyingBody::Known(base())];
    let resting = placed(15, 15, 0);
    let evidence = accepted(verdict(&content, &known, &resting));
    assert!(evidence.degraded.is_empty(), "{evidence:?}");
    let evidence = accepted(verdict(&content, &seen, &resting));
    assert_eq!(evidence.degraded.len(), 1, "{evidence:?}");
    assert!(says(&evidence, "the shape that was seen"), "{evidence:?}");
}

#[test]
fn a_tall_box_mostly_over_an_edge_is_refused_either_way() {
    for held in tall() {
        let verdict = verdict(&[LyingBody::Known(base())], &held, &placed(9, 3, 50));
        assert!(!verdict.is_accepted(), "{verdict:?}");
    }
}

#[test]
fn what_was_seen_and_what_nobody_knows_bear_what_is_placed_on_them() {
    let seen = LyingBody::Seen(seen_base());
    for (body, degraded) in [
        (seen, "items in the container took part"),
        (LyingBody::Unknown, "on the heightmap of the others"),
    ] {
        for held in tall() {
            let content = std::slice::from_ref(&body);
            let evidence = accepted(verdict(content, &held, &placed(3, 3, 50)));
            assert!(says(&evidence, degraded), "{evidence:?}");
            let over_the_edge = verdict(content, &held, &placed(9, 3, 50));
            assert!(!over_the_edge.is_accepted(), "{over_the_edge:?}");
        }
    }
}

#[test]
fn what_cannot_be_laid_down_counts_as_not_known() {
    let mut far = base();
    far.container_from_item = at(0.05, 0.05, 1e6);
    let [known, _] = tall();
    let verdict = verdict(&[LyingBody::Known(far)], &known, &placed(3, 3, 50));
    let evidence = accepted(verdict);
    let is_said = says(&evidence, "on the heightmap of the others");
    assert!(is_said, "{evidence:?}");
}
