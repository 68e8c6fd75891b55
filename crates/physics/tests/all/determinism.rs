//! The contract: the same settings and calls give the same bits, whatever else runs, and going back
//! to a clone continues as if nothing had happened since.
use std::sync::Arc;

use nalgebra::Isometry3;
use ppnpack_catalogue::object::Model;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_physics::cell::SimulatedCell;

use crate::common::{ball, cell, cuboid, cuboids, put, turned};

/// Ten releases that fall on one another.
fn releases() -> Vec<(Arc<Model>, Isometry3<f64>)> {
    let angle = [
        ([0.0, 0.0, 0.0], [0.09, 0.03, 0.03]),
        ([0.03, 0.0, 0.03], [0.03; 3]),
    ];
    let block = cuboid([0.08, 0.06, 0.04]);
    let models = [block, cuboids("angle", &angle), ball(0.025)];
    (0..10)
        .map(|step| {
            let turn = f64::from(step);
            let x_m = 0.16 + 0.05 * (1.7 * turn).cos();
            let y_m = 0.16 + 0.05 * (2.3 * turn).sin();
            let pose = turned(x_m, y_m, 0.02 + 0.018 * turn, 0.4 * turn);
            (Arc::clone(&models[step as usize % models.len()]), pose)
        })
        .collect()
}

fn new_cell() -> SimulatedCell {
    cell(|settings| {
        settings.seed = 5;
        settings.release.jitter_m = 0.002;
        settings.release.jitter_yaw_rad = 0.05;
    })
}

fn place_all(cell: &mut SimulatedCell, releases: &[(Arc<Model>, Isometry3<f64>)]) {
    for (model, pose) in releases {
        cell.place(model, pose).unwrap();
    }
}

/// Every pose of the content, bit by bit.
fn pose_bits(cell: &SimulatedCell) -> Vec<(usize, [u64; 7])> {
    let bits = |pose: &Isometry3<f64>| {
        let (p, r) = (pose.translation, pose.rotation);
        [p.x, p.y, p.z, r.i, r.j, r.k, r.w].map(f64::to_bits)
    };
    let bodies = cell.contents().into_iter();
    let bits = bodies.map(|body| (body.id.index(), bits(&body.container_from_item)));
    bits.collect()
}

fn episode() -> Vec<(usize, [u64; 7])> {
    let mut cell = new_cell();
    place_all(&mut cell, &releases());
    pose_bits(&cell)
}

#[test]
fn an_episode_is_the_same_in_any_number_of_threads() {
    let expected = episode();
    assert!(expected.len() > 5);
    for threads in [1, 2, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let found = pool.unwrap().install(episode);
        assert!(found == expected, "in a pool of {threads} threads");
    }
    std::thread::scope(|scope| {
        let runs = [scope.spawn(episode), scope.spawn(episode)];
        for run in runs {
            assert!(run.join().unwrap() == expected, "beside another episode");
        }
    });
}

#[test]
fn a_cell_put_back_continues_as_if_nothing_had_happened() {
    let releases = releases();
    let (first, rest) = releases.split_at(5);
    let expected = episode();

    let mut cell = new_cell();
    place_all(&mut cell, first);
    let before = cell.clone();
    let halfway = pose_bits(&cell);
    place_all(&mut cell, rest);
    assert!(pose_bits(&cell) == expected, "being cloned changes nothing");

    cell.clone_from(&before);
    assert!(pose_bits(&cell) == halfway);
    place_all(&mut cell, rest);
    assert!(pose_bits(&cell) == expected, "after going back");
}

#[test]
fn trying_a_placement_leaves_no_trace() {
    let releases = releases();
    let mut cell = new_cell();
    for (index, (model, pose)) in releases.iter().enumerate() {
        let (other, elsewhere) = (
            &releases[(index + 1) % 10].0,
            turned(0.1, 0.2, 0.15, index as f64),
        );
        cell.try_place(other, &elsewhere).unwrap();
        let tried = cell.try_place(model, pose).unwrap();
        let placed = cell.place(model, pose).unwrap();
        assert_eq!(tried, placed);
    }
    assert!(pose_bits(&cell) == episode());
}

#[test]
fn a_reset_cell_is_like_a_new_one() {
    let mut cell = new_cell();
    place_all(&mut cell, &releases());
    cell.reset();
    assert!(cell.contents().is_empty());
    place_all(&mut cell, &releases());
    assert!(pose_bits(&cell) == episode());
}

#[test]
fn a_scan_after_going_back_shows_what_is_there() {
    let grid = Grid::reference();
    let mut cell = new_cell();
    let empty = cell.clone();
    let (small, large) = (cuboid([0.04; 3]), cuboid([0.08; 3]));
    // Both bodies are the cell's first, and rest at the same place.
    put(&mut cell, &small, turned(0.16, 0.16, 0.02, 0.0));
    cell.scan(&grid).unwrap();
    // A clone takes its surfaces along; a reset cell keeps those of bodies that were numbered
    // alike.
    let mut reset = cell.clone();
    reset.reset();
    cell = empty;
    put(&mut cell, &large, turned(0.16, 0.16, 0.04, 0.0));
    let mut fresh = new_cell();
    fresh.place(&large, &turned(0.16, 0.16, 0.04, 0.0)).unwrap();
    assert_eq!(cell.scan(&grid).unwrap(), fresh.scan(&grid).unwrap());
    reset.place(&large, &turned(0.16, 0.16, 0.04, 0.0)).unwrap();
    assert_eq!(reset.scan(&grid).unwrap(), fresh.scan(&grid).unwrap());
}
