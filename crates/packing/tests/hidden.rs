//! What hidden samples are taken for where it is known what lies there.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Point3};
use ppnpack_packing::content::{Content, LyingBody, LyingSolid};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::{Scene, Surface};
use ppnpack_packing::hidden::SceneMemory;
use ppnpack_packing::model::mesh::Mesh;
use ppnpack_packing::model::{MassProperties, Model};

/// A block of 10 x 10 cm that lies in the corner, so high.
fn block(name: &str, height_m: f64) -> LyingSolid {
    let model = Model {
        name: name.to_owned(),
        mesh: Mesh::cuboid([0.0; 3], [0.1, 0.1, height_m]),
        volume_m3: 0.01 * height_m,
        pieces: Vec::new(),
        mass: MassProperties {
            mass_kg: 1.0,
            centre_of_mass_m: Point3::new(0.05, 0.05, height_m / 2.0),
            inertia_kg_m2: Matrix3::identity(),
        },
        carries_kg: None,
        resting_poses: Vec::new(),
    };
    LyingSolid::new(Arc::new(model), Isometry3::identity())
}

/// The block as it is seen: in its shadow, the samples of this column, nothing is.
fn scene(hidden: &[(usize, f32)], seen_m: f32) -> Scene {
    let grid = Grid::reference();
    let mut surface = Surface::empty(&grid);
    for x in 0..40 {
        for y in 0..40 {
            surface.raise(x, y, seen_m);
        }
    }
    let mut support_m = surface.heights_m().to_vec();
    for (x, bound_m) in hidden {
        surface.raise(*x, 8, *bound_m);
        support_m[x * surface.ny() + 8] = 0.0;
    }
    Scene::from_surface(&grid, surface.with_support(support_m).unwrap()).unwrap()
}

fn at(scene: &Scene, x: usize) -> (f32, f32) {
    let surface = scene.surface().unwrap();
    let sample = x * surface.ny() + 8;
    (surface.support_m()[sample], surface.heights_m()[sample])
}

fn completed(memory: &mut SceneMemory, scene: Scene, content: Content) -> Scene {
    memory.complete(&Grid::reference(), scene.with_content(content))
}

#[test]
fn what_is_hidden_is_as_high_as_what_is_known_to_lie_there_but_never_above_its_bound() {
    // Beyond the block the floor is hidden: by a little, by much, and where no ray passes.
    let hidden = [(42, 0.001), (44, 0.08), (46, 0.301)];
    let grid = Grid::reference();
    let seen = scene(&hidden, 0.1);
    assert_eq!(seen.heightmap().get(11, 2), Some(151));
    let known = completed(
        &mut SceneMemory::default(),
        seen.clone(),
        vec![block("block", 0.1)].into(),
    );
    assert_eq!(at(&known, 42), (0.0, 0.001));
    assert_eq!(at(&known, 44), (0.0, 0.003));
    assert_eq!(at(&known, 46), (0.0, 0.003));
    assert_eq!(known.heightmap().get(11, 2), Some(2));
    assert!(known.heightmap().get(5, 2) == Some(50) && grid.rim() == 150);
    // Where not all is known, only the bounds count.
    let some = [LyingBody::Known(block("block", 0.1)), LyingBody::Unknown];
    let partly = completed(
        &mut SceneMemory::default(),
        seen.clone(),
        some.into_iter().collect(),
    );
    assert_eq!(partly.heightmap(), seen.heightmap());
    let assumed = [LyingBody::Known(block("block", 0.1)).assumed()];
    let assumed = completed(
        &mut SceneMemory::default(),
        seen.clone(),
        assumed.into_iter().collect(),
    );
    assert_eq!(assumed.heightmap(), seen.heightmap());
}

#[test]
fn an_edge_that_shows_beside_a_sample_is_as_high_as_its_solid() {
    let grid = Grid::reference();
    let wide = LyingSolid {
        container_from_item: Isometry3::translation(0.0005, 0.0, 0.0),
        ..block("block", 0.1)
    };
    // The solid reaches half a millimetre into the sample beside those in which it was seen.
    let seen = scene(&[(60, 0.05)], 0.1);
    assert_eq!(at(&seen, 40), (0.0, 0.0));
    let known = completed(
        &mut SceneMemory::default(),
        seen.clone(),
        vec![wide.clone()].into(),
    );
    assert!((at(&known, 40).0 - 0.1).abs() < 1e-6);
    assert_eq!(known.heightmap().get(10, 2), Some(50));
    // Not where the picture does not show it at all.
    let empty = scene(&[(60, 0.05)], 0.0);
    let gone = completed(&mut SceneMemory::default(), empty, vec![wide].into());
    assert_eq!(at(&gone, 40), (0.0, 0.0));
    // A lip of 2.5 mm that the picture lacks is as high as it is; what noise and poses are off by is left as it was seen.
    for (seen_m, height_m) in [(0.0975, 0.1), (0.0985, 0.0985)] {
        let lip = completed(
            &mut SceneMemory::default(),
            scene(&[(60, 0.05)], seen_m),
            vec![block("block", 0.1)].into(),
        );
        assert!((at(&lip, 20).0 - height_m).abs() < 1e-6, "{seen_m}");
    }
    assert_eq!(grid.resolution().samples_per_cell(), 4);
}

#[test]
fn what_was_seen_before_stays_seen_where_nothing_moved() {
    let mut memory = SceneMemory::default();
    // A block of which nothing is known is seen at 2 cm, and hidden later by one that is placed.
    let unknown = scene(&[(70, 0.2)], 0.02);
    completed(&mut memory, unknown.clone(), Content::default());
    let hidden = scene(&[(39, 0.2), (100, 0.2)], 0.02);
    let far = LyingSolid {
        container_from_item: Isometry3::translation(0.2, 0.2, 0.0),
        ..block("far", 0.15)
    };
    let later = completed(&mut memory, hidden.clone(), vec![far].into());
    assert_eq!(at(&later, 39), (0.02, 0.02), "as it was seen");
    // Where something came to lie, what was seen before does not count.
    let mut memory = SceneMemory::default();
    completed(&mut memory, unknown, Content::default());
    let near = completed(&mut memory, hidden, vec![block("near", 0.15)].into());
    assert!((at(&near, 39).0 - 0.15).abs() < 1e-6);
}
