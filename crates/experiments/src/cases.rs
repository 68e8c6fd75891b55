//! The sequences that an experiment packs.

use ppnpack_cli::failure::{Failure, Outcome};
use ppnpack_cli::sequence::{Sequence, SequenceFile};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A sequence, by its number in the file.
pub(crate) struct Case {
    pub(crate) number: u32,
    pub(crate) sequence: Sequence,
}

/// `count` sequences of a file, from the one numbered `first` on.
///
/// # Errors
/// How many the file has, where those are more.
pub(crate) fn cases(sequences: &SequenceFile, first: u32, count: u32) -> Outcome<Vec<Case>> {
    let all = sequences.count();
    if u64::from(first) + u64::from(count) > all as u64 {
        return Err(Failure::input(format_args!(
            "--first {first} --cases {count}: the file has {all} sequences, numbered from 0"
        )));
    }
    let case = |number: u32| -> Outcome<Case> {
        let sequence = sequences.get(number as usize)?;
        Ok(Case { number, sequence })
    };
    (first..).take(count as usize).map(case).collect()
}

/// `count` random sequences of objects numbered below `objects`, each as likely as any other; they depend on the seed and their
/// number alone.
pub(crate) fn draw(seed: u64, count: u32, length: u32, objects: usize) -> Vec<Sequence> {
    let sequences = (0..u64::from(count)).map(|case| {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(case + 1);
        let drawn = (0..length).map(|_| random.random_range(0..objects.max(1)));
        Sequence {
            from: format!("sequence {case} of seed {seed}"),
            objects: drawn.collect(),
        }
    });
    sequences.collect()
}
