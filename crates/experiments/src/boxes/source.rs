//! The boxes that arrive.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::surface::{LONGEST, Sides};

/// What is drawn for an instance.
#[derive(Debug, Clone, Copy)]
enum Drawn {
    Boxes,
    Futures,
}

/// One sequence of boxes; it has streams of its own of one generator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Instance {
    pub(super) seed: u64,
    pub(super) number: u32,
}

impl Instance {
    /// Its boxes, without an end.
    pub(super) fn boxes(&self) -> Boxes {
        Boxes(self.random(Drawn::Boxes))
    }

    /// What futures are drawn from; it has nothing of the boxes that arrive.
    pub(super) fn futures(&self) -> Boxes {
        Boxes(self.random(Drawn::Futures))
    }

    fn random(&self, drawn: Drawn) -> ChaCha8Rng {
        let of_drawn = match drawn {
            Drawn::Boxes => 0,
            Drawn::Futures => 1,
        };
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(u64::from(self.number) << 2 | of_drawn);
        random
    }
}

/// Boxes with sides that are uniform and independent.
#[derive(Debug, Clone)]
pub(super) struct Boxes(ChaCha8Rng);

impl Iterator for Boxes {
    type Item = Sides;

    fn next(&mut self) -> Option<Sides> {
        let [x, y, z] = [0; 3].map(|_| self.0.random_range(1..=LONGEST));
        Some(Sides { x, y, z })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn instance(number: u32) -> Instance {
        Instance { seed: 7, number }
    }

    #[test]
    fn an_instance_is_the_same_each_time_and_no_two_streams_are() {
        let first = |boxes: Boxes| boxes.take(40).collect::<Vec<_>>();
        let mut known = Vec::new();
        for number in 0..20 {
            let instance = instance(number);
            assert_eq!(first(instance.boxes()), first(instance.boxes()));
            known.extend([first(instance.boxes()), first(instance.futures())]);
        }
        for (index, one) in known.iter().enumerate() {
            assert!(known.iter().skip(index + 1).all(|other| other != one));
        }
    }

    #[test]
    fn all_sides_are_equally_likely() {
        let mut counts = [0_u32; LONGEST as usize + 1];
        for sides in instance(0).boxes().take(10_000) {
            for side in [sides.x, sides.y, sides.z] {
                counts[usize::from(side)] += 1;
            }
        }
        assert_eq!(counts[0], 0);
        // Six standard deviations of a share of a fifth of 30,000.
        let even = |count: &u32| count.abs_diff(6_000) < 420;
        assert!(counts.iter().skip(1).all(even), "{counts:?}");
    }
}
