//! The sequences that an experiment packs.

use ppnpack_cli::failure::{Failure, Outcome};
use ppnpack_cli::sequence::{Sequence, SequenceFile};

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
