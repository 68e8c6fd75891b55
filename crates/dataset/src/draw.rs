//! Drawing sequences of objects.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A drawn sequence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Drawn {
    /// Indices into the catalogue, in the order of arrival.
    pub objects: Vec<u32>,
    /// The seed of everything else that is random while the sequence is packed.
    pub seed: u64,
}

/// Draws sequence number `sequence`: `length` objects out of `objects`, each as likely as any
/// other.
///
/// Every sequence has a random stream of its own, so it depends on nothing but these numbers.
pub fn draw(seed: u64, sequence: u32, length: u32, objects: u32) -> Drawn {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(u64::from(sequence));
    let seed = random.next_u64();
    let objects = (0..length).map(|_| random.random_range(0..objects.max(1)));
    Drawn {
        seed,
        objects: objects.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sequences_differ_by_seed_and_number_and_repeat() {
        let first = draw(1, 0, 80, 77);
        assert_eq!(first, draw(1, 0, 80, 77));
        assert_ne!(first.objects, draw(1, 1, 80, 77).objects);
        assert_ne!(first.objects, draw(2, 0, 80, 77).objects);
        assert_ne!(first.seed, draw(1, 1, 80, 77).seed);
        assert!(first.objects.iter().all(|object| *object < 77));
    }
}
