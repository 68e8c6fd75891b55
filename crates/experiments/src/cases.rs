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

/// The first random stream of an experiment's sequences. Those below are a dataset's ([`ppnpack_dataset::draw`]), so that with one seed
/// for both no network is tried on sequences that it learnt from.
const FIRST_STREAM: u64 = 1 << 32;

/// `count` random sequences of objects numbered below `objects`, each as likely as any other; they depend on the seed and their
/// number alone.
pub(crate) fn draw(seed: u64, count: u32, length: u32, objects: usize) -> Vec<Sequence> {
    let sequences = (0..u64::from(count)).map(|case| {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(FIRST_STREAM + case);
        let drawn = (0..length).map(|_| random.random_range(0..objects.max(1)));
        Sequence {
            from: format!("sequence {case} of seed {seed}"),
            objects: drawn.collect(),
        }
    });
    sequences.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As long as is not shared by chance: one in 50 to the eighth.
    const SHARED: usize = 8;

    #[test]
    fn an_experiment_packs_no_sequence_of_a_dataset_of_the_same_seed() {
        let learnt = (0..20_u32).map(|sequence| ppnpack_dataset::draw(0, sequence, 80, 50).objects);
        let learnt: Vec<Vec<usize>> = learnt
            .map(|objects| objects.into_iter().map(|object| object as usize).collect())
            .collect();
        let is_learnt = |part: &[usize]| {
            let mut windows = learnt.iter().flat_map(|objects| objects.windows(SHARED));
            windows.any(|window| window == part)
        };
        assert!(is_learnt(&learnt[7][3..3 + SHARED]));
        for sequence in draw(0, 20, 50, 50) {
            assert!(
                !sequence.objects.windows(SHARED).any(is_learnt),
                "{}",
                sequence.from
            );
        }
    }

    #[test]
    fn sequences_differ_by_seed_and_number_and_repeat() {
        let objects = |seed| draw(seed, 3, 50, 77).into_iter().map(|drawn| drawn.objects);
        let [first, second, third]: [Vec<usize>; 3] =
            objects(1).collect::<Vec<_>>().try_into().unwrap();
        assert!(first != second && second != third && first != third);
        assert!(objects(1).next() == Some(first.clone()));
        assert!(objects(2).next() != Some(first));
    }
}
