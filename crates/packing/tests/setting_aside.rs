//! Episodes in which items are set aside, and in which items come in several poses.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::sync::Arc;

use ppnpack_packing::candidate::Candidate;
use ppnpack_packing::episode::{Ending, Episode, IdealCell, Play, SetAside, play};
use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Units, Yaws};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::objective::Order;
use ppnpack_packing::plan::{Planner, Reason};
use ppnpack_packing::proposals::ProposeAll;
use ppnpack_packing::search::{Search, SearchSettings};

/// The volume of one cell of the container with one unit of height, in cubic metres.
const VOXEL_M3: f64 = 0.01 * 0.01 * 0.002;

/// 4 x 4 cells, 10 units high, one yaw.
fn grid() -> Grid {
    let resolution = Resolution::new(0.01, 0.002, Yaws::half_turn(1).unwrap());
    let container = ContainerSize {
        x_m: 0.04,
        y_m: 0.04,
        z_m: 0.02,
    };
    Grid::new(container, resolution.unwrap()).unwrap()
}

/// A block of so many cells and units.
fn block(nx: usize, ny: usize, height: Units) -> Arc<Item> {
    let (top, bottom) = (vec![height; nx * ny], vec![0; nx * ny]);
    let surfaces = ViewSurfaces::of_cells(nx, ny, top, bottom);
    let volume_m3 = (nx * ny) as f64 * f64::from(height) * VOXEL_M3;
    Arc::new(Item::new("block", vec![surfaces], volume_m3).unwrap())
}

/// Plates that fill the container's floor.
fn plates(heights: &[Units]) -> Vec<Candidate> {
    Candidate::sequence(heights.iter().map(|height| block(4, 4, *height)))
}

/// Packs a sequence in the order of arrival, without physics; whatever fits is valid.
fn packed(sequence: Vec<Candidate>, buffer: usize, set_aside: usize) -> Episode {
    let grid = grid();
    let settings = SearchSettings {
        order: Order::Arrival,
        ..SearchSettings::default()
    };
    let search = Box::new(Search::new(&grid, &settings).unwrap());
    let mut planner = Planner::new(Box::new(ProposeAll), search, vec![], Order::Arrival, 0);
    let how = Play {
        set_aside,
        ..Play::with_buffer(buffer)
    };
    let mut cell = IdealCell::new(&grid);
    play(&grid, &mut planner, &mut cell, sequence, how, &mut ()).unwrap()
}

fn arrivals(episode: &Episode) -> Vec<usize> {
    let steps = episode.steps.iter();
    steps.map(|step| step.candidate.arrival).collect()
}

/// What was set aside: arrivals, and before which steps.
fn aside(episode: &Episode) -> Vec<(usize, u64)> {
    let items = episode.set_aside.iter();
    items.map(|it| (it.candidate.arrival, it.step)).collect()
}

/// The items that nothing fits for at the end: arrivals and poses.
fn unplaced(episode: &Episode) -> Vec<(usize, usize)> {
    let Ending::NothingFits(items) = &episode.ending else {
        panic!("{:?}", episode.ending);
    };
    let items = items.iter();
    items.map(|(held, _)| (held.arrival, held.pose)).collect()
}

#[test]
fn where_nothing_may_be_set_aside_the_first_that_does_not_fit_ends_the_episode() {
    let episode = packed(plates(&[6, 6, 4]), 1, 0);
    assert_eq!(arrivals(&episode), [0]);
    assert_eq!(unplaced(&episode), [(1, 0)]);
    assert!(episode.set_aside.is_empty());
}

#[test]
fn what_does_not_fit_is_set_aside_and_later_ones_are_packed() {
    let episode = packed(plates(&[6, 6, 4]), 1, 1);
    assert_eq!(arrivals(&episode), [0, 2]);
    assert!(matches!(episode.ending, Ending::OthersSetAside));
    let [SetAside { reason, .. }] = &episode.set_aside[..] else {
        panic!("{:?}", episode.set_aside);
    };
    assert_eq!(aside(&episode), [(1, 1)]);
    assert_eq!(reason, &Some(Reason::NoFit));
    assert_eq!(episode.metrics.packed.items, 2);
}

#[test]
fn where_all_fit_nothing_is_set_aside() {
    let episode = packed(plates(&[4, 4, 2]), 1, 3);
    assert_eq!(arrivals(&episode), [0, 1, 2]);
    assert!(episode.set_aside.is_empty() && matches!(episode.ending, Ending::AllPacked));
}

#[test]
fn no_more_are_set_aside_than_may_be() {
    let sequence = || plates(&[6, 6, 5, 6, 4]);
    let episode = packed(sequence(), 1, 2);
    assert_eq!(arrivals(&episode), [0]);
    assert_eq!(aside(&episode), [(1, 1), (2, 1)]);
    assert_eq!(unplaced(&episode), [(3, 0)]);
    let episode = packed(sequence(), 1, 3);
    assert_eq!(arrivals(&episode), [0, 4]);
    assert_eq!(aside(&episode), [(1, 1), (2, 1), (3, 1)]);
    assert!(matches!(episode.ending, Ending::OthersSetAside));
}

#[test]
fn the_largest_of_the_buffer_is_set_aside_first_and_of_several_the_earliest() {
    let episode = packed(plates(&[6, 6, 8, 4]), 2, 2);
    assert_eq!(arrivals(&episode), [0, 3]);
    assert_eq!(aside(&episode), [(2, 1), (1, 2)]);
    let episode = packed(plates(&[6, 7, 7, 4]), 2, 1);
    assert_eq!(aside(&episode), [(1, 1)]);
    assert_eq!(arrivals(&episode), [0, 3]);
    assert_eq!(unplaced(&episode), [(2, 0)]);
}

/// A bar of 12 units: standing, which is higher than the container, and lying.
fn bar(arrival: usize) -> [Candidate; 2] {
    let lying = Candidate {
        pose: 1,
        ..Candidate::new(arrival, block(4, 1, 2))
    };
    [Candidate::new(arrival, block(1, 1, 12)), lying]
}

#[test]
fn an_item_is_packed_once_in_the_pose_that_fits() {
    let sequence: Vec<Candidate> = (0..3).flat_map(bar).collect();
    let episode = packed(sequence, 2, 0);
    assert_eq!(arrivals(&episode), [0, 1, 2]);
    let mut steps = episode.steps.iter();
    assert!(steps.all(|step| step.candidate.pose == 1));
    assert!(matches!(episode.ending, Ending::AllPacked));
}

#[test]
fn an_item_in_several_poses_is_set_aside_as_one_and_has_one_reason() {
    let sequence = || -> Vec<Candidate> {
        let full = [Candidate::new(0, block(4, 4, 9))];
        let later = [Candidate::new(3, block(4, 4, 1))];
        let items = full.into_iter().chain(bar(1)).chain(bar(2));
        items.chain(later).collect()
    };
    let episode = packed(sequence(), 2, 0);
    assert_eq!(unplaced(&episode), [(1, 0), (2, 0)]);
    let episode = packed(sequence(), 2, 1);
    assert_eq!(aside(&episode), [(1, 1)]);
    assert_eq!(arrivals(&episode), [0, 3]);
    assert_eq!(unplaced(&episode), [(2, 0)]);
    let episode = packed(sequence(), 2, 2);
    assert_eq!(aside(&episode), [(1, 1), (2, 2)]);
    assert!(matches!(episode.ending, Ending::OthersSetAside));
}
