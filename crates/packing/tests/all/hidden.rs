//! What hidden samples are taken for where it is known what lies there.

use ppnpack_packing::scene::hidden::SceneMemory;

use crate::support::*;

/// A block of 10 x 10 cm, so high, moved so far from the corner.
fn block(height_m: f64, [x_m, y_m]: [f64; 2]) -> LyingSolid {
    lies(cuboid("block", [0.1, 0.1, height_m], 1.0), [x_m, y_m, 0.0])
}

/// The block as it is seen: in its shadow, the samples of this column, nothing is.
fn scene(hidden: &[(usize, f32)], seen_m: f32) -> Scene {
    let grid = Grid::reference();
    assert_eq!(grid.resolution().samples_per_cell(), 4);
    let mut surface = Surface::empty(&grid);
    for (x, y) in (0..40).flat_map(|x| (0..40).map(move |y| (x, y))) {
        surface.raise(x, y, seen_m);
    }
    let mut support_m = surface.heights_m().to_vec();
    for (x, bound_m) in hidden {
        surface.raise(*x, 8, *bound_m);
        support_m[x * surface.ny() + 8] = 0.0;
    }
    Scene::from_surface(&grid, surface.with_support(support_m).unwrap()).unwrap()
}

/// What holds an item up, and the bound, at a sample of the column.
fn at(scene: &Scene, x: usize) -> (f32, f32) {
    let surface = scene.surface().unwrap();
    let sample = x * surface.ny() + 8;
    (surface.support_m()[sample], surface.heights_m()[sample])
}

fn completed(memory: &mut SceneMemory, scene: &Scene, content: impl Into<Content>) -> Scene {
    let scene = scene.clone().with_content(content.into());
    memory.complete(&Grid::reference(), scene)
}

/// With nothing seen before.
fn fresh(scene: &Scene, content: impl Into<Content>) -> Scene {
    completed(&mut SceneMemory::default(), scene, content)
}

#[test]
fn what_is_hidden_is_as_high_as_what_is_known_to_lie_there_but_never_above_its_bound() {
    // Beyond the block the floor is hidden: by a little, by much, and where no ray passes.
    let seen = scene(&[(42, 0.001), (44, 0.08), (46, 0.301)], 0.1);
    assert_eq!(seen.heightmap().get(11, 2), Some(151));
    let solid = block(0.1, [0.0; 2]);
    let known = fresh(&seen, vec![solid.clone()]);
    let expected = [(42, (0.0, 0.001)), (44, (0.0, 0.003)), (46, (0.0, 0.003))];
    assert_eq!(expected.map(|(x, _)| (x, at(&known, x))), expected);
    let cells = [(11, 2), (5, 2)].map(|(x, y)| known.heightmap().get(x, y));
    assert_eq!(cells, [Some(2), Some(50)]);
    // Where not all is known, only the bounds count.
    let known = LyingBody::Known(solid);
    for bodies in [
        vec![known.clone(), LyingBody::Unknown],
        vec![known.assumed()],
    ] {
        let partly = fresh(&seen, bodies.into_iter().collect::<Content>());
        assert_eq!(partly.heightmap(), seen.heightmap());
    }
}

#[test]
fn an_edge_that_shows_beside_a_sample_is_as_high_as_its_solid() {
    // The solid reaches half a millimetre into the sample beside those in which it was seen.
    let wide = || vec![block(0.1, [0.0005, 0.0])];
    let seen = scene(&[(60, 0.05)], 0.1);
    assert_eq!(at(&seen, 40), (0.0, 0.0));
    let known = fresh(&seen, wide());
    assert!((at(&known, 40).0 - 0.1).abs() < 1e-6);
    assert_eq!(known.heightmap().get(10, 2), Some(50));
    // Not where the picture does not show it at all.
    let gone = fresh(&scene(&[(60, 0.05)], 0.0), wide());
    assert_eq!(at(&gone, 40), (0.0, 0.0));
    // A lip of 2.5 mm that the picture lacks is as high as it is; what noise and poses are off by
    // is left as it was seen.
    for (seen_m, height_m) in [(0.0975, 0.1), (0.0985, 0.0985)] {
        let lip = fresh(&scene(&[(60, 0.05)], seen_m), vec![block(0.1, [0.0; 2])]);
        assert!((at(&lip, 20).0 - height_m).abs() < 1e-6, "{seen_m}");
    }
}

#[test]
fn what_was_seen_before_stays_seen_where_nothing_moved() {
    // A block of which nothing is known is seen at 2 cm, and hidden later by one that is placed.
    let unknown = scene(&[(70, 0.2)], 0.02);
    let hidden = scene(&[(39, 0.2), (100, 0.2)], 0.02);
    let later = |placed| {
        let mut memory = SceneMemory::default();
        completed(&mut memory, &unknown, Content::default());
        at(&completed(&mut memory, &hidden, vec![placed]), 39)
    };
    assert_eq!(later(block(0.15, [0.2; 2])), (0.02, 0.02), "as it was seen");
    // Where something came to lie, what was seen before does not count.
    assert!((later(block(0.15, [0.0; 2])).0 - 0.15).abs() < 1e-6);
}

#[test]
fn a_content_says_how_well_it_is_known() {
    let known = LyingBody::Known(block(0.1, [0.0; 2]));
    let seen = LyingBody::Seen(block(0.1, [0.0; 2]));
    let assumed = seen.clone().assumed();
    for (bodies, solids, has_seen, is_partial, all) in [
        (vec![], 0, false, false, 0),
        (vec![&known], 1, false, false, 1),
        (vec![&known, &seen], 2, true, false, 2),
        (vec![&assumed, &known], 1, false, true, 2),
        (vec![&known, &seen, &LyingBody::Unknown], 2, true, true, 2),
    ] {
        let content: Content = bodies.into_iter().cloned().collect();
        let found = (
            content.solids().len(),
            content.has_seen(),
            content.is_partial(),
        );
        assert_eq!(found, (solids, has_seen, is_partial));
        assert_eq!(content.all_solids().len(), all);
    }
    let all = Content::from(vec![block(0.1, [0.0; 2])]);
    assert!(!all.has_seen() && !all.is_partial());
}
