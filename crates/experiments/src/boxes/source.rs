//! The boxes that arrive.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::surface::{LONGEST, Sides};

/// One sequence of boxes; it has streams of its own of one generator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Instance {
    pub(super) seed: u64,
    pub(super) number: u32,
}

impl Instance {
    pub(super) fn boxes(&self) -> Boxes {
        Boxes(self.random(0))
    }

    /// Gives the generator of futures, which has nothing of the boxes that arrive.
    pub(super) fn futures(&self) -> Boxes {
        Boxes(self.random(1))
    }

    fn random(&self, stream: u64) -> ChaCha8Rng {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(u64::from(self.number) << 2 | stream);
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
