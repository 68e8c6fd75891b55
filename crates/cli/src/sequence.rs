//! Sequences of objects: from a file, named one by one, or at random.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use ndarray::Array2;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::object::CatalogueObject;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::ranking::step::Candidate;
use ppnpack_robot::station::ArmStation;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::failure::{Failure, Outcome};
use crate::report::Unplaceable;

/// The objects that arrive, in their order.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Sequence")]
pub(crate) struct SequenceOptions {
    /// A .npy file of sequences, int64 [sequences, length], of object indices, and which one, from
    /// 0 [default: the first]
    #[arg(long, value_name = "FILE[:NUMBER]", value_parser = parse_numbered, conflicts_with_all = ["items", "random"])]
    sequence: Option<(PathBuf, usize)>,

    /// The objects by name or index, separated by commas
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        conflicts_with = "random"
    )]
    items: Vec<String>,

    /// How many objects to draw at random, see --seed [default: 80]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    random: Option<u32>,
}

/// Object indices in the order of arrival, and their source.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Sequence {
    /// Their source, in words.
    pub from: String,
    /// The indices.
    pub objects: Vec<usize>,
}

impl SequenceOptions {
    /// Gives the names of the only objects that are needed; none where there may be others.
    pub(crate) fn names(&self) -> &[String] {
        match self.items.iter().any(|item| item.parse::<usize>().is_ok()) {
            true => &[],
            false => &self.items,
        }
    }

    pub(crate) fn sequence(&self, catalogue: &Catalogue, seed: u64) -> Outcome<Sequence> {
        if let Some((path, number)) = &self.sequence {
            return SequenceFile::read(path, catalogue)?.get(*number);
        }
        if !self.items.is_empty() {
            let objects = self.items.iter().map(|item| find(catalogue, item));
            return Ok(Sequence {
                from: "--items".to_owned(),
                objects: objects.collect::<Result<_, _>>()?,
            });
        }
        let count = self.random.unwrap_or(80);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let objects = (0..count).map(|_| random.random_range(0..catalogue.len()));
        Ok(Sequence {
            from: format!("{count} at random, seed {seed}"),
            objects: objects.collect(),
        })
    }
}

impl Sequence {
    /// Takes out the objects that an arm cannot hold or lift in any of their poses, and gives each
    /// with its place and the reason in the first pose.
    pub(crate) fn set_aside(
        &mut self,
        catalogue: &Catalogue,
        station: &ArmStation,
    ) -> Vec<Unplaceable> {
        let mut set_aside = Vec::new();
        let mut check = station.check();
        let mut arrival = 0..;
        self.objects.retain(|index| {
            let arrival = arrival.next().unwrap_or_default();
            let Some(object) = catalogue.get(*index) else {
                return true;
            };
            let mut refusal = None;
            for candidate in object.candidates(arrival) {
                match check.lift(&candidate, &catalogue.resolution) {
                    Ok(_) => return true,
                    Err(refused) => refusal = refusal.or(Some(refused)),
                }
            }
            let Some(refusal) = refusal else {
                return true;
            };
            set_aside.push(Unplaceable {
                arrival,
                item: object.item.name().to_string(),
                reason: refusal.to_string(),
            });
            false
        });
        set_aside
    }

    /// Gives the items in the order of their arrival, with all that the catalogue knows of them,
    /// each in all of its poses.
    pub fn candidates(&self, catalogue: &Catalogue) -> Vec<Candidate> {
        let objects = self.of(catalogue).enumerate();
        let candidates = objects.flat_map(|(arrival, object)| object.candidates(arrival));
        candidates.collect()
    }

    /// Gives the items themselves, each in its first pose.
    pub fn items(&self, catalogue: &Catalogue) -> Vec<Arc<Item>> {
        let objects = self.of(catalogue);
        objects.map(|object| object.item.clone()).collect()
    }

    fn of<'a>(&'a self, catalogue: &'a Catalogue) -> impl Iterator<Item = &'a CatalogueObject> {
        let objects = self.objects.iter();
        objects.filter_map(move |index| catalogue.get(*index))
    }
}

/// A file of sequences, checked against a catalogue.
pub struct SequenceFile {
    path: PathBuf,
    rows: Array2<i64>,
}

impl SequenceFile {
    /// Reads a .npy file, int64 [sequences, length], of object indices.
    pub fn read(path: &Path, catalogue: &Catalogue) -> Outcome<Self> {
        let rows: Array2<i64> = ndarray_npy::read_npy(path).map_err(|error| {
            Failure::input(format_args!(
                "{} cannot be read as sequences: {error}; an int64 .npy array of two dimensions is needed",
                path.display()
            ))
        })?;
        let outside = rows.indexed_iter().find(|(_, object)| {
            usize::try_from(**object).map_or(true, |index| index >= catalogue.len())
        });
        if let Some(((row, column), object)) = outside {
            return Err(Failure::input(format_args!(
                "{}: sequence {row} names object {object} at position {column}, but the catalogue has objects \
                 0 to {}; give the catalogue that the sequences were made for",
                path.display(),
                catalogue.len().saturating_sub(1)
            )));
        }
        Ok(Self {
            path: path.to_owned(),
            rows,
        })
    }

    /// Counts its sequences.
    pub fn count(&self) -> usize {
        self.rows.nrows()
    }

    /// Gives one of its sequences.
    pub fn get(&self, index: usize) -> Outcome<Sequence> {
        if index >= self.count() {
            return Err(Failure::input(format_args!(
                "there is no sequence {index}: {} has 0 to {}",
                self.path.display(),
                self.count().saturating_sub(1)
            )));
        }
        let row = self.rows.row(index);
        let objects = row.iter().copied().map(usize::try_from);
        Ok(Sequence {
            from: format!("sequence {index} of {}", self.path.display()),
            objects: objects.filter_map(Result::ok).collect(),
        })
    }
}

/// Parses the name of a file, and the number behind it.
fn parse_numbered(text: &str) -> Result<(PathBuf, usize), std::convert::Infallible> {
    let numbered = text.rsplit_once(':');
    let numbered = numbered.and_then(|(file, number)| Some((file.into(), number.parse().ok()?)));
    Ok(numbered.unwrap_or_else(|| (text.into(), 0)))
}

fn find(catalogue: &Catalogue, name: &str) -> Outcome<usize> {
    let by_name = catalogue.find(name).map(|(index, _)| index);
    let by_index = || name.parse().ok().filter(|index| *index < catalogue.len());
    let list = "`ppnpack catalogue list` names them";
    let none = || format!("--items: the catalogue has no object '{name}'; {list}");
    by_name
        .or_else(by_index)
        .ok_or_else(|| Failure::input(none()))
}
