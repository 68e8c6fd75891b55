//! Pictures that agree with what is believed to lie in a container, and pictures that do not.

use nalgebra::{Isometry3, Translation3};
use ppnpack_packing::scene::expected::{Contradiction, Expected};
use ppnpack_packing::scene::model::mesh::Mesh;
use ppnpack_packing::scene::model::raster::raise_surface;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::support::*;

/// Places for boxes along each side of the container, in metres from one to the next.
const PLACE_M: f64 = 0.08;

/// Samples of the surface along a metre.
const PER_M: f64 = 400.0;

/// What is not seen, along x, in metres.
const SHADOW_M: std::ops::Range<f64> = 0.13..0.16;

/// A box by its lowest corner and its sides, in metres.
fn lying(name: &str, at_m: [f64; 3], sides_m: [f64; 3]) -> LyingSolid {
    lies(cuboid(name, sides_m, 1.0), at_m)
}

/// One without a lid, as thick as 4 mm.
fn tray(name: &str, at_m: [f64; 3], [x, y, z]: [f64; 3]) -> LyingSolid {
    let thick = 0.004;
    let mut mesh = Mesh::cuboid([0.0; 3], [x, y, thick]);
    for (lowest, highest) in [
        ([0.0, 0.0, 0.0], [thick, y, z]),
        ([x - thick, 0.0, 0.0], [x, y, z]),
        ([0.0, 0.0, 0.0], [x, thick, z]),
        ([0.0, y - thick, 0.0], [x, y, z]),
    ] {
        mesh.append(&Mesh::cuboid(lowest, highest));
    }
    let model = Model {
        mesh,
        ..cuboid(name, [x, y, z], 1.0)
    };
    lies(model, at_m)
}

/// A picture of solids, without noise.
fn picture(solids: &[LyingSolid]) -> Surface {
    let mut surface = Surface::empty(&Grid::reference());
    for solid in solids {
        raise_surface(&solid.model.mesh, &solid.container_from_item, &mut surface);
    }
    surface
}

/// The same with noise, and with a strip in which only bounds are known.
fn noisy(surface: &Surface, random: &mut ChaCha8Rng) -> Surface {
    let (ny, pitch_m) = (surface.ny(), surface.pitch_m());
    let samples = surface.heights_m().iter().enumerate();
    let samples = samples.map(|(sample, height_m)| {
        let noise_m: f32 = random.random_range(-0.002..0.002);
        let seen_m = (height_m + noise_m).max(0.0);
        let x_m = (sample / ny) as f64 * pitch_m;
        let hides_m: f32 = random.random_range(0.001..0.1);
        match SHADOW_M.contains(&x_m) {
            true => (seen_m + hides_m, 0.0),
            false => (seen_m, seen_m),
        }
    });
    let (heights_m, support_m) = samples.unzip();
    let noisy = Surface::from_metres(surface.nx(), ny, pitch_m, heights_m);
    noisy.unwrap().with_support(support_m).unwrap()
}

fn scene(surface: Surface) -> Scene {
    Scene::from_surface(&Grid::reference(), surface).unwrap()
}

/// The contradictions of pictures that follow one another, with what is believed to lie there.
struct Watch(Expected);

impl Watch {
    fn new() -> Self {
        Self(Expected::default())
    }

    fn see(&mut self, surface: Surface, content: &Content) -> Option<Contradiction> {
        let grid = Grid::reference();
        let compared = self.0.compare(&grid, &scene(surface), content.clone());
        compared.err()
    }
}

/// The contradiction of a first picture.
fn first(surface: Surface, content: &Content) -> Option<Contradiction> {
    Watch::new().see(surface, content)
}

fn known(solids: &[LyingSolid]) -> Content {
    solids.to_vec().into()
}

fn assumed(solids: &[LyingSolid]) -> Content {
    let bodies = solids.iter().cloned();
    bodies.map(LyingBody::Assumed).collect()
}

/// Whether a picture shows no such item, and no other either.
fn is_gone(contradiction: Option<&Contradiction>, name: &str) -> bool {
    matches!(contradiction, Some(Contradiction::Gone { item, .. }) if item == name)
}

/// Boxes side by side, and smaller ones on some of them.
fn piles(random: &mut ChaCha8Rng) -> Vec<LyingSolid> {
    let mut solids = Vec::new();
    for place in 0..16_u8 {
        if random.random_bool(0.2) {
            continue;
        }
        let [x_m, y_m] = [place / 4, place % 4].map(|along| f64::from(along) * PLACE_M);
        let sides_m = [(); 2].map(|()| random.random_range(0.04..PLACE_M));
        let high_m = random.random_range(0.04..0.12);
        let [long_m, wide_m] = sides_m;
        solids.push(lying(
            &format!("low-{place}"),
            [x_m, y_m, 0.0],
            [long_m, wide_m, high_m],
        ));
        if random.random_bool(0.4) {
            let above_m = random.random_range(0.03..0.1);
            let sides_m = [long_m * 0.6, wide_m * 0.6, above_m];
            let name = format!("high-{place}");
            solids.push(lying(&name, [x_m + 0.005, y_m + 0.005, high_m], sides_m));
        }
    }
    solids
}

/// Whether nothing lies on a box, and half of it or more is seen.
fn is_visible(solid: &LyingSolid, all: &Surface) -> bool {
    let lowest = solid.container_from_item.translation.vector;
    let bounds = solid.model.mesh.bounds().unwrap();
    let sides_m = bounds.extents_m();
    let samples = |axis: usize| {
        let (from, to) = (lowest[axis], lowest[axis] + sides_m[axis]);
        (from * PER_M).ceil() as usize..(to * PER_M) as usize
    };
    let top_m = (lowest.z + sides_m.z) as f32;
    let (mut count, mut open, mut seen) = (0, 0, 0);
    for x in samples(0) {
        for y in samples(1) {
            let is_lit = !SHADOW_M.contains(&(x as f64 / PER_M));
            let is_top = (all.heights_m()[x * all.ny() + y] - top_m).abs() < 1e-4;
            count += 1;
            open += usize::from(is_top);
            seen += usize::from(is_lit && is_top);
        }
    }
    open == count && 2 * seen > count
}

#[test]
fn what_lies_where_it_should_is_never_doubted_and_each_that_is_taken_out_is_noticed() {
    let mut noticed = 0;
    for seed in 0..20 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let solids = piles(&mut random);
        let all = picture(&solids);
        for content in [known(&solids), assumed(&solids)] {
            let mut watch = Watch::new();
            for _ in 0..2 {
                assert_eq!(watch.see(noisy(&all, &mut random), &content), None);
            }
        }
        for taken in solids.iter().filter(|solid| is_visible(solid, &all)) {
            let name = taken.burden.name.to_string();
            let left = solids.iter().filter(|solid| **solid != *taken).cloned();
            let shown = noisy(&picture(&left.collect::<Vec<_>>()), &mut random);
            for content in [known(&solids), assumed(&solids)] {
                let found = first(shown.clone(), &content);
                assert!(is_gone(found.as_ref(), &name), "{seed} {name}: {found:?}");
                noticed += 1;
            }
        }
    }
    assert!(noticed > 200, "{noticed}");
}

#[test]
fn what_settled_and_slid_a_little_is_where_it_should_be() {
    for seed in 0..20 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let solids = piles(&mut random);
        let slid = solids.iter().map(|solid| {
            let mut slid = solid.clone();
            let [x_m, y_m] = [(); 2].map(|()| random.random_range(-0.015..0.015));
            let z_m = random.random_range(-0.01..0.0);
            slid.container_from_item = Translation3::new(x_m, y_m, z_m) * slid.container_from_item;
            slid
        });
        let slid: Vec<LyingSolid> = slid.collect();
        let shown = noisy(&picture(&slid), &mut random);
        assert_eq!(first(shown, &assumed(&solids)), None, "{seed}");
    }
}

#[test]
fn a_thin_rim_tells_of_an_item_wherever_it_slid() {
    let at = |x_m: f64| tray("tray", [x_m, 0.1, 0.0], [0.12, 0.1, 0.07]);
    let content = assumed(&[at(0.02)]);
    let shown = |solids: &[LyingSolid]| first(picture(solids), &content);
    for x_m in [0.02, 0.03, 0.04, 0.15] {
        assert_eq!(shown(&[at(x_m)]), None, "{x_m}");
    }
    assert!(is_gone(shown(&[]).as_ref(), "tray"));
}

#[test]
fn what_fell_over_or_rolled_away_is_not_gone() {
    let post = lying("post", [0.1, 0.1, 0.0], [0.06, 0.06, 0.25]);
    let fell = lying("post", [0.16, 0.1, 0.0], [0.15, 0.06, 0.06]);
    let content = known(&[post]);
    let mut watch = Watch::new();
    assert_eq!(watch.see(picture(&[fell]), &content), None);
    // Something small elsewhere is none of it.
    let crumb = lying("crumb", [0.25, 0.25, 0.0], [0.03, 0.03, 0.03]);
    let found = watch.see(picture(&[crumb]), &content);
    assert!(is_gone(found.as_ref(), "post"), "{found:?}");
    let told = found.unwrap().to_string();
    assert!(told.contains("item post is not to be seen"));
}

#[test]
fn a_picture_from_before_a_placement_does_not_show_it() {
    let before = vec![
        lying("a", [0.0, 0.0, 0.0], [0.1, 0.1, 0.1]),
        lying("b", [0.1, 0.0, 0.0], [0.08, 0.1, 0.06]),
    ];
    let mut after = before.clone();
    after.push(lying("c", [0.0, 0.0, 0.1], [0.08, 0.08, 0.05]));
    let mut watch = Watch::new();
    let old = picture(&before);
    assert_eq!(watch.see(old.clone(), &known(&before)), None);
    let found = watch.see(old.clone(), &assumed(&after));
    assert!(is_gone(found.as_ref(), "c"), "{found:?}");
    // It was found elsewhere since, or taken out.
    assert_eq!(watch.see(old, &known(&before)), None);
    assert_eq!(watch.see(picture(&after), &known(&after)), None);
}

#[test]
fn flat_things_and_hidden_ones_tell_nothing() {
    let flat = lying("flat", [0.2, 0.1, 0.0], [0.1, 0.1, 0.02]);
    let hidden = lying("hidden", [0.13, 0.1, 0.0], [0.03, 0.03, 0.1]);
    let content = known(&[flat, hidden]);
    let mut random = ChaCha8Rng::seed_from_u64(1);
    assert_eq!(first(noisy(&picture(&[]), &mut random), &content), None);
}

#[test]
fn what_comes_up_where_nothing_is_known_to_lie_is_noticed_until_somebody_has_looked() {
    let solids = vec![lying("a", [0.0, 0.0, 0.0], [0.1, 0.1, 0.1])];
    let hand = lying("hand", [0.15, 0.1, 0.0], [0.08, 0.06, 0.2]);
    let content = known(&solids);
    let reaching = picture(&[solids.clone(), vec![hand]].concat());
    let mut watch = Watch::new();
    assert_eq!(watch.see(picture(&solids), &content), None);
    let found = watch.see(reaching.clone(), &content);
    let is_foreign = |found: &Option<Contradiction>| {
        matches!(found, Some(Contradiction::Foreign { area_m2, higher_m })
            if (0.0045..0.0055).contains(area_m2) && (higher_m - 0.2).abs() < 1e-6)
    };
    assert!(is_foreign(&found), "{found:?}");
    assert!(found.unwrap().to_string().contains("48 cm²"));
    // Where not all that lies there is known, it may be that.
    let body = LyingBody::Known(solids[0].clone());
    let partly: Content = [body, LyingBody::Unknown].into_iter().collect();
    let mut other = Watch::new();
    for shown in [picture(&solids), reaching.clone()] {
        assert_eq!(other.see(shown, &partly), None);
    }
    // What was there from the beginning, and what somebody left there, stays.
    watch.0.forget();
    for _ in 0..2 {
        assert_eq!(watch.see(reaching.clone(), &content), None);
    }
}

#[test]
fn a_heightmap_without_a_surface_is_compared_by_its_cells() {
    let solids = vec![lying("a", [0.1, 0.1, 0.0], [0.1; 3])];
    let grid = Grid::reference();
    let seen = |shown: &[LyingSolid], believed: &[LyingSolid]| {
        let shown = Scene::from_heightmap(scene(picture(shown)).heightmap().clone());
        Expected::default()
            .compare(&grid, &shown, known(believed))
            .err()
    };
    assert_eq!(seen(&solids, &solids), None);
    assert!(is_gone(seen(&[], &solids).as_ref(), "a"));
    let mut beside = solids;
    beside[0].container_from_item = Isometry3::translation(5.0, 5.0, 0.0);
    let found = seen(&[], &beside);
    assert_eq!(
        found, None,
        "what lies beside the container is not looked for"
    );
}

#[test]
fn what_lay_there_before_is_unknown_content_and_noise_is_none() {
    let grid = Grid::reference();
    for seed in 0..20 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let solids = piles(&mut random);
        let shown = scene(noisy(&picture(&solids), &mut random));
        let first = |content| Expected::default().compare(&grid, &shown, content);
        assert!(first(known(&solids)) == Ok(known(&solids)), "{seed}");
        let nothing = Content::default();
        assert!(
            first(nothing.clone()) == Ok(nothing.with_unknown()),
            "{seed}"
        );
        // What is assumed may be that.
        assert!(first(assumed(&solids)) == Ok(assumed(&solids)), "{seed}");
    }
}
