//! Episodes in which items are set aside, and in which items come in several poses.

use ppnpack_packing::streams::buffer::Buffer;
use ppnpack_packing::streams::episode::{Ending, Episode, IdealCell, Play, play};

use crate::support::*;

/// 4 x 4 cells, 10 units high, one yaw.
fn grid() -> Grid {
    grid_of([4, 4], 0.01, 10, 1)
}

/// Plates that fill the container's floor.
fn plates(heights: &[Units]) -> Vec<Candidate> {
    Candidate::sequence(heights.iter().map(|height| block(&grid(), [4, 4], *height)))
}

/// Packs a sequence in the order of arrival, without physics; whatever fits is valid.
fn packed(sequence: Vec<Candidate>, buffer: usize, set_aside: usize) -> Episode {
    let grid = grid();
    let search = Box::new(searching(&grid, Heuristic::Sdfm, Order::Arrival, false));
    let mut planner = Planner::new(Box::new(ProposeAll), search, vec![], Order::Arrival, 0);
    let how = Play {
        set_aside,
        ..Play::with_buffer(buffer)
    };
    let mut cell = IdealCell::new(&grid);
    play(&grid, &mut planner, &mut cell, sequence, how, &mut ()).unwrap()
}

/// Asserts which arrivals were packed, set aside before which steps, and fit nowhere at the end.
fn assert_came_of(episode: &Episode, packed: &[usize], aside: &[(usize, u64)], unplaced: &[usize]) {
    let steps = episode.steps.iter().map(|step| step.candidate.arrival);
    assert_eq!(steps.collect::<Vec<_>>(), packed);
    let items = episode.set_aside.iter();
    let items = items.map(|item| (item.candidate.arrival, item.step));
    assert_eq!(items.collect::<Vec<_>>(), aside);
    let fits_nowhere: Vec<usize> = match &episode.ending {
        Ending::NothingFits(items) => {
            assert!(items.iter().all(|(held, _)| held.pose == 0));
            items.iter().map(|(held, _)| held.arrival).collect()
        }
        Ending::AllPacked => {
            assert!(aside.is_empty());
            vec![]
        }
        Ending::OthersSetAside => {
            assert!(!aside.is_empty());
            vec![]
        }
    };
    assert_eq!(fits_nowhere, unplaced);
}

#[test]
fn what_does_not_fit_is_set_aside_and_later_ones_are_packed_as_often_as_may_be() {
    for (heights, set_aside, packed_ones, aside, unplaced) in [
        // Where nothing may be set aside, the first that does not fit ends the episode.
        (&[6, 6, 4][..], 0, &[0][..], &[][..], &[1][..]),
        (&[6, 6, 4], 1, &[0, 2], &[(1, 1)], &[]),
        // Where all fit, nothing is set aside.
        (&[4, 4, 2], 3, &[0, 1, 2], &[], &[]),
        (&[6, 6, 5, 6, 4], 2, &[0], &[(1, 1), (2, 1)], &[3]),
        (&[6, 6, 5, 6, 4], 3, &[0, 4], &[(1, 1), (2, 1), (3, 1)], &[]),
    ] {
        let episode = packed(plates(heights), 1, set_aside);
        assert_came_of(&episode, packed_ones, aside, unplaced);
        assert_eq!(episode.metrics.packed.items, packed_ones.len());
        let mut reasons = episode.set_aside.iter().map(|item| &item.reason);
        assert!(reasons.all(|reason| *reason == Some(Reason::NoFit)));
    }
}

#[test]
fn the_largest_of_the_buffer_is_set_aside_first_and_of_several_the_earliest() {
    let episode = packed(plates(&[6, 6, 8, 4]), 2, 2);
    assert_came_of(&episode, &[0, 3], &[(2, 1), (1, 2)], &[]);
    let episode = packed(plates(&[6, 7, 7, 4]), 2, 1);
    assert_came_of(&episode, &[0, 3], &[(1, 1)], &[2]);
}

/// A bar of 12 units: standing, which is higher than the container, and lying.
fn bar(arrival: usize) -> [Candidate; 2] {
    let lying = Candidate {
        pose: 1,
        ..Candidate::new(arrival, block(&grid(), [4, 1], 2))
    };
    [Candidate::new(arrival, block(&grid(), [1, 1], 12)), lying]
}

#[test]
fn an_item_is_packed_once_in_the_pose_that_fits() {
    let episode = packed((0..3).flat_map(bar).collect(), 2, 0);
    assert_came_of(&episode, &[0, 1, 2], &[], &[]);
    let mut steps = episode.steps.iter();
    assert!(steps.all(|step| step.candidate.pose == 1));
}

#[test]
fn an_item_in_several_poses_is_set_aside_as_one_and_has_one_reason() {
    let sequence = || -> Vec<Candidate> {
        let full = [Candidate::new(0, block(&grid(), [4, 4], 9))];
        let later = [Candidate::new(3, block(&grid(), [4, 4], 1))];
        let items = full.into_iter().chain(bar(1)).chain(bar(2));
        items.chain(later).collect()
    };
    for (set_aside, packed_ones, aside, unplaced) in [
        (0, &[0][..], &[][..], &[1, 2][..]),
        (1, &[0, 3], &[(1, 1)], &[2]),
        (2, &[0, 3], &[(1, 1), (2, 2)], &[]),
    ] {
        assert_came_of(
            &packed(sequence(), 2, set_aside),
            packed_ones,
            aside,
            unplaced,
        );
    }
}

#[test]
fn the_capacity_of_a_buffer_counts_items_whatever_their_poses() {
    let cell = block(&grid(), [1, 1], 1);
    let sequence = |poses: &[usize]| -> Vec<Candidate> {
        let items = poses.iter().enumerate();
        let items = items.flat_map(|(arrival, poses)| (0..*poses).map(move |pose| (arrival, pose)));
        let candidate = |(arrival, pose)| Candidate {
            pose,
            ..Candidate::new(arrival, Arc::clone(&cell))
        };
        items.map(candidate).collect()
    };
    let held = |buffer: &Buffer| -> Vec<(usize, usize)> {
        let candidates = buffer.candidates().iter();
        candidates.map(|held| (held.arrival, held.pose)).collect()
    };
    let mut buffer = Buffer::new(sequence(&[1, 3, 2, 1]), 2);
    assert_eq!(held(&buffer), [(0, 0), (1, 0), (1, 1), (1, 2)]);
    assert_eq!(buffer.items().count(), 2);
    let taken = buffer.take(2).unwrap();
    assert_eq!((taken.arrival, taken.pose), (1, 1));
    assert_eq!(held(&buffer), [(0, 0), (2, 0), (2, 1)]);
    buffer.take(0).unwrap();
    assert_eq!(held(&buffer), [(2, 0), (2, 1), (3, 0)]);
    assert!(buffer.take(3).is_none());
    buffer.take(1).unwrap();
    buffer.take(0).unwrap();
    assert!(buffer.candidates().is_empty() && buffer.take(0).is_none());
    // One at least.
    assert_eq!(held(&Buffer::new(sequence(&[2, 1]), 0)), [(0, 0), (0, 1)]);
}
