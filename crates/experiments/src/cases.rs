//! The sequences that an experiment packs.

use std::ops::Range;
use std::path::PathBuf;

use clap::Args;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_cli::failure::{Failure, Outcome};
use ppnpack_cli::sequence::{Sequence, SequenceFile};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

/// Sequences of a file that are packed, with defaults for the first one and their number.
#[derive(Debug, Args)]
pub(crate) struct SequenceOptions<const FIRST: u32, const CASES: u32> {
    /// A .npy file of sequences, int64 [sequences, length], of object indices
    #[arg(long, value_name = "FILE")]
    sequences: PathBuf,

    /// The first sequence
    #[arg(long, value_name = "NUMBER", default_value_t = FIRST)]
    pub(crate) first: u32,

    /// How many sequences
    #[arg(long, value_name = "COUNT", default_value_t = CASES, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) cases: u32,
}

impl<const FIRST: u32, const CASES: u32> SequenceOptions<FIRST, CASES> {
    pub(crate) fn read(&self, catalogue: &Catalogue) -> Outcome<Vec<Case>> {
        let file = SequenceFile::read(&self.sequences, catalogue)?;
        cases(&file, self.first, self.cases)
    }

    pub(crate) fn said(&self) -> Value {
        json!({ "first_case": self.first, "cases": self.cases })
    }
}

pub(crate) struct Case {
    pub(crate) number: u32,
    pub(crate) sequence: Sequence,
}

impl Case {
    pub(crate) fn name(&self) -> String {
        format!("{:05}", self.number)
    }

    /// The seed of its run, of an experiment with this one.
    pub(crate) fn seed(&self, of_experiment: u64) -> u64 {
        of_experiment.wrapping_add(u64::from(self.number))
    }
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

/// The first random stream of an experiment's sequences. Those below are a dataset's
/// ([`ppnpack_dataset::draw`]): no network is tried on sequences that it learnt from.
const FIRST_STREAM: u64 = 1 << 32;

/// Random sequences of these numbers, of objects numbered below `objects`, each as likely as any
/// other; they depend on the seed and their number alone.
pub(crate) fn draw(seed: u64, numbers: Range<u32>, length: u32, objects: usize) -> Vec<Case> {
    let sequences = numbers.map(|number| {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(FIRST_STREAM + u64::from(number));
        let drawn = (0..length).map(|_| random.random_range(0..objects.max(1)));
        let sequence = Sequence {
            from: format!("sequence {number} of seed {seed}"),
            objects: drawn.collect(),
        };
        Case { number, sequence }
    });
    sequences.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Length of a part that is not shared by chance: one in 50 to the eighth.
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
        for Case { sequence, .. } in draw(0, 0..20, 50, 50) {
            assert!(
                !sequence.objects.windows(SHARED).any(is_learnt),
                "{}",
                sequence.from
            );
        }
    }
}
