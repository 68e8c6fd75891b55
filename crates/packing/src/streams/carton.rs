//! Orders whose items are all known, and the carton that is to take them: what rules it out before
//! any is placed, and the sequences in which to try them.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::kernel::grid::Grid;
use crate::kernel::item::ItemView;
use crate::kernel::random;
use crate::ranking::step::Candidate;

/// Why a carton cannot take an order, whatever the sequence.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RuledOut {
    /// The items are heavier than it may hold.
    #[error("the items weigh {mass_kg:.2} kg, and it may hold {max_kg:.2} kg")]
    Weight {
        /// Mass of the items, in kilograms.
        mass_kg: f64,
        /// The greatest mass that it may hold, in kilograms.
        max_kg: f64,
    },
    /// Items are too large for it alone.
    #[error("too large for it in every pose")]
    Size {
        /// Their places in the order.
        arrivals: Vec<usize>,
    },
    /// The items have more volume than it has.
    #[error("the items have {items_cm3:.0} cm³, and it has {carton_cm3:.0} cm³")]
    Volume {
        /// Volume of the items' meshes, in cubic centimetres.
        items_cm3: f64,
        /// Its inner volume, in cubic centimetres.
        carton_cm3: f64,
    },
}

/// Says what rules a carton out for these items, each in all of its poses; a mass that is not known
/// counts as none.
pub fn ruled_out(grid: &Grid, items: &[Candidate], max_kg: Option<f64>) -> Option<RuledOut> {
    let offered = || items.chunk_by(|a, b| a.arrival == b.arrival);
    let first = || offered().filter_map(<[Candidate]>::first);
    let mass_kg: f64 = first().filter_map(Candidate::weighs_kg).sum();
    if let Some(max_kg) = max_kg.filter(|max_kg| mass_kg > *max_kg) {
        return Some(RuledOut::Weight { mass_kg, max_kg });
    }
    let is_too_large = |poses: &&[Candidate]| !poses.iter().any(|held| fits_alone(held, grid));
    let too_large = offered().filter(is_too_large);
    let too_large = too_large.filter_map(<[Candidate]>::first);
    let arrivals: Vec<usize> = too_large.map(|held| held.arrival).collect();
    if !arrivals.is_empty() {
        return Some(RuledOut::Size { arrivals });
    }
    let items_cm3 = 1e6 * first().map(|held| held.item.mesh_volume_m3()).sum::<f64>();
    let carton_cm3 = 1e6 * grid.container().volume_m3();
    (items_cm3 > carton_cm3).then_some(RuledOut::Volume {
        items_cm3,
        carton_cm3,
    })
}

/// Says whether an item lies within an empty container in a pose, at some yaw.
fn fits_alone(held: &Candidate, grid: &Grid) -> bool {
    let fits =
        |view: &ItemView| view.nx() <= grid.nx() && view.ny() <= grid.ny() && view.fits_at(grid, 0);
    held.item.views().iter().any(fits)
}

/// A sequence in which to try the items of an order.
#[derive(Debug, Clone)]
pub struct Sequence {
    /// The items, each in all of its poses.
    pub items: Vec<Candidate>,
    /// How many of the waiting ones a step may choose from.
    pub buffer: usize,
}

/// The sequences in which to try the items of an order, one after another.
///
/// In the first a step may choose among all. In the second the items come by falling size, and
/// after that what was left out comes earlier, as much else is drawn.
#[derive(Debug, Clone)]
pub struct Sequences {
    /// The items, each in all of its poses, by falling urgency.
    items: Vec<Vec<Candidate>>,
    seed: u64,
    given: u64,
}

impl Sequences {
    /// The sequences of these items.
    pub fn new(items: &[Candidate], seed: u64) -> Self {
        let items = items.chunk_by(|a, b| a.arrival == b.arrival);
        let mut items: Vec<Vec<Candidate>> = items.map(<[Candidate]>::to_vec).collect();
        items.sort_by_key(|poses| std::cmp::Reverse(least_box(poses)));
        Self {
            items,
            seed,
            given: 0,
        }
    }

    /// Gives the next sequence.
    pub fn next_sequence(&mut self) -> Sequence {
        let number = self.given;
        self.given += 1;
        if number >= 2 {
            self.shuffle(number);
        }
        Sequence {
            items: self.items.concat(),
            buffer: if number == 0 { self.items.len() } else { 1 },
        }
    }

    /// Hears which items were left out of the last sequence: they are more urgent from now on.
    pub fn left_out(&mut self, arrivals: &[usize]) {
        let is_left = |poses: &Vec<Candidate>| {
            let first = poses.first();
            first.is_some_and(|held| arrivals.contains(&held.arrival))
        };
        // Stable: both parts stay as they were.
        self.items.sort_by_key(|poses| !is_left(poses));
    }

    /// Moves items by some places.
    fn shuffle(&mut self, number: u64) {
        let mut drawn = ChaCha8Rng::seed_from_u64(random::mix(self.seed, number));
        let reach = 1.0 + self.items.len() as f64 / 4.0;
        let items = std::mem::take(&mut self.items).into_iter().enumerate();
        let places =
            items.map(|(place, poses)| (place as f64 + reach * drawn.random::<f64>(), poses));
        let mut places: Vec<(f64, Vec<Candidate>)> = places.collect();
        places.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        self.items = places.into_iter().map(|(_, poses)| poses).collect();
    }
}

/// Gives the number of voxels of the smallest box around an item, over its poses and yaws.
fn least_box(poses: &[Candidate]) -> u64 {
    let views = poses.iter().flat_map(|held| held.item.views());
    views.map(ItemView::box_voxel_count).min().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::kernel::item::{Item, ViewSurfaces};

    /// A block of so many cells, as high as it is long, as the item of an arrival.
    fn block(arrival: usize, side: usize) -> Candidate {
        let height = side as i16 * 5;
        let cells = side * side;
        let surfaces = ViewSurfaces::of_cells(side, side, vec![height; cells], vec![0; cells]);
        let yaws = vec![surfaces; 4];
        let volume_m3 = (side as f64 * 0.01).powi(3);
        let item = Item::new("block", yaws, volume_m3).unwrap();
        let mut held = Candidate::new(arrival, Arc::new(item));
        held.mass_kg = Some(1.0);
        held
    }

    fn arrivals(sequence: &Sequence) -> Vec<usize> {
        sequence.items.iter().map(|held| held.arrival).collect()
    }

    #[test]
    fn what_cannot_be_is_said_with_the_reason() {
        let grid = Grid::reference();
        let items = [block(0, 10), block(1, 33), block(1, 40), block(2, 34)];
        assert_eq!(ruled_out(&grid, &items[..1], Some(1.0)), None);
        let arrivals = vec![1, 2];
        assert_eq!(
            ruled_out(&grid, &items, None),
            Some(RuledOut::Size { arrivals })
        );
        let heavy = ruled_out(&grid, &items, Some(2.5));
        assert!(matches!(heavy, Some(RuledOut::Weight { mass_kg: 3.0, .. })));
        let many: Vec<Candidate> = (0..2).map(|arrival| block(arrival, 30)).collect();
        let much = ruled_out(&grid, &many, None);
        assert!(matches!(much, Some(RuledOut::Volume { .. })), "{much:?}");
    }

    #[test]
    fn a_larger_pose_beside_one_that_fits_rules_nothing_out() {
        let items = [block(0, 10), block(0, 40)];
        assert_eq!(ruled_out(&Grid::reference(), &items, None), None);
    }

    #[test]
    fn sequences_begin_with_all_to_choose_from_and_then_go_by_size() {
        let items = [block(0, 4), block(1, 9), block(2, 6)];
        let mut sequences = Sequences::new(&items, 0);
        let (first, second) = (sequences.next_sequence(), sequences.next_sequence());
        assert_eq!((first.buffer, second.buffer), (3, 1));
        assert_eq!(arrivals(&second), [1, 2, 0]);
    }

    #[test]
    fn what_was_left_out_comes_earlier_and_a_seed_draws_the_same() {
        let items: Vec<Candidate> = (0..8).map(|arrival| block(arrival, 12 - arrival)).collect();
        let run = |seed: u64| {
            let mut sequences = Sequences::new(&items, seed);
            sequences.next_sequence();
            sequences.left_out(&[7]);
            let later: Vec<Vec<usize>> = (0..4)
                .map(|_| arrivals(&sequences.next_sequence()))
                .collect();
            later
        };
        assert_eq!(run(1)[0], [7, 0, 1, 2, 3, 4, 5, 6]);
        assert_eq!(run(1), run(1));
        assert_ne!(run(1), run(2));
        for mut sequence in run(3) {
            sequence.sort_unstable();
            assert_eq!(sequence, [0, 1, 2, 3, 4, 5, 6, 7]);
        }
    }
}
