//! Parts of an experiment that run apart, on several machines.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// The most parts of an experiment.
const MOST: u32 = 100_000;

/// One of several parts of an experiment: every so-many-th of its sequences.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub(crate) struct Shard {
    /// From 0, as the pods of an indexed job are numbered.
    index: u32,
    count: u32,
}

/// Something that names no shard.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a shard is I/N, with I from 0 to below N, and N at most {MOST}: 0/4 is the first of four")]
pub(crate) struct NoShard;

impl Shard {
    /// How many there are.
    pub(crate) fn count(self) -> u32 {
        self.count
    }

    /// All shards of as many as this one is of.
    pub(crate) fn all(self) -> impl Iterator<Item = Self> {
        let count = self.count;
        (0..count).map(move |index| Self { index, count })
    }

    /// Whether the sequence of this number is of it.
    pub(crate) fn has(self, number: usize) -> bool {
        number % self.count as usize == self.index as usize
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}/{}", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = NoShard;

    fn from_str(text: &str) -> Result<Self, NoShard> {
        let (index, count) = text.split_once('/').ok_or(NoShard)?;
        let number = |digits: &str| digits.parse::<u32>().map_err(|_| NoShard);
        let (index, count) = (number(index)?, number(count)?);
        if index < count && count <= MOST {
            Ok(Self { index, count })
        } else {
            Err(NoShard)
        }
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}

impl TryFrom<String> for Shard {
    type Error = NoShard;

    fn try_from(text: String) -> Result<Self, NoShard> {
        text.parse()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_sequence_is_of_one_shard() {
        let first: Shard = "0/3".parse().unwrap();
        assert_eq!(first.all().count(), 3);
        for number in 0..20 {
            let holders = first.all().filter(|shard| shard.has(number)).count();
            assert_eq!(holders, 1, "{number}");
        }
    }

    #[test]
    fn a_shard_is_written_as_it_is_read() {
        for text in ["0/1", "3/4"] {
            assert_eq!(text.parse::<Shard>().unwrap().to_string(), text);
        }
        for text in ["", "1", "1/1", "4/4", "0/0", "-1/2", "a/b", "0/100001"] {
            assert_eq!(text.parse::<Shard>(), Err(NoShard), "{text}");
        }
    }
}
