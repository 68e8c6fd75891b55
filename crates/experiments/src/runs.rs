//! Finished runs of an experiment, kept on disk so that a killed experiment goes on where it was.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use serde::de::DeserializeOwned;

use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_cli::output::{print_json, print_line};
use ppnpack_files::write_whole;

use crate::shard::Shard;
use crate::workers;

/// The settings of a folder of runs, beside them.
pub(crate) const SETTINGS_FILE: &str = "settings.json";

/// How the marks of finished shards end, beside the runs.
pub(crate) const SHARD_EXTENSION: &str = "shard";

/// Where finished runs are kept.
#[derive(Debug, Args)]
pub(crate) struct RunsOption {
    /// Where finished sequences are kept, so that a killed run goes on [default: runs in --out]
    #[arg(long, value_name = "DIR")]
    runs: Option<PathBuf>,
}

impl RunsOption {
    pub(crate) fn folder(&self, out: &Path) -> PathBuf {
        self.runs.clone().unwrap_or_else(|| out.join("runs"))
    }
}

/// Which runs are made here.
#[derive(Debug, Args)]
pub(crate) struct ShardOption {
    /// Make every N-th run alone, from the I-th on, counted from 0, and no tables: `ppnpack experiment merge` puts the runs of all shards
    /// together
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
}

impl ShardOption {
    /// The part with its runs in this folder.
    pub(crate) fn part(&self, runs: PathBuf) -> Part {
        Part {
            runs,
            shard: self.shard,
        }
    }
}

/// Where finished runs are kept, and which of them are made here.
#[derive(Debug, Args)]
pub(crate) struct ShardOptions {
    #[command(flatten)]
    runs: RunsOption,

    #[command(flatten)]
    shard: ShardOption,
}

impl ShardOptions {
    pub(crate) fn part(&self, out: &Path) -> Part {
        self.shard.part(self.runs.folder(out))
    }
}

/// The part of an experiment that is made here: all of it, or a shard.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Part {
    pub(crate) runs: PathBuf,
    pub(crate) shard: Option<Shard>,
}

impl Part {
    /// Those of all sequences that are of this part.
    pub(crate) fn of<T>(&self, all: impl IntoIterator<Item = T>) -> impl Iterator<Item = T> {
        let shard = self.shard;
        let numbered = all.into_iter().enumerate();
        let own = numbered.filter(move |(number, _)| shard.is_none_or(|it| it.has(*number)));
        own.map(|(_, one)| one)
    }

    /// Makes those of all runs that are of this part, `workers` at once, in the folder `kept`; gives them in their order, or `None`
    /// where they are a shard.
    pub(crate) fn make<J: Sync, R: Send + Sync>(
        &self,
        kept: &Runs,
        all: &[J],
        workers: usize,
        make: impl Fn(&J) -> Outcome<R> + Sync,
    ) -> Outcome<Option<Vec<R>>> {
        let own: Vec<&J> = self.of(all).collect();
        let made = workers::map("Packing", &own, workers, |job| make(job))?;
        self.finish(kept, made)
    }

    /// The runs of a folder, of which all of this part are made now; `None` where they are a shard, which is marked as finished.
    pub(crate) fn finish<R>(&self, kept: &Runs, made: Vec<R>) -> Outcome<Option<Vec<R>>> {
        let Some(shard) = self.shard else {
            return Ok(Some(made));
        };
        kept.finish_shard(shard)?;
        Ok(None)
    }

    /// Says what is to be done with the runs of a shard.
    pub(crate) fn tell(&self, as_json: bool) -> Outcome {
        if as_json {
            return Ok(print_json(self)?);
        }
        let folder = self.runs.display();
        Ok(print_line(&format!(
            "The runs of this shard are in {folder}: `ppnpack experiment merge` puts those of all shards together"
        ))?)
    }
}

/// A folder of finished runs that all depended on the same settings and were made by the same program.
#[derive(Debug)]
pub(crate) struct Runs {
    folder: PathBuf,
}

/// What a folder of runs is named by.
#[derive(Serialize)]
struct Key<'a, S> {
    /// The hash of the program: what another build decides is not mixed in.
    program: &'a str,
    settings: &'a S,
}

impl Runs {
    /// The runs made with these settings by this program: a change of any of them starts anew, in a folder of its own.
    pub(crate) fn new(folder: &Path, settings: &impl Serialize) -> Outcome<Self> {
        let program = program().or_run()?;
        let key = Key {
            program: &program,
            settings,
        };
        let folder = folder.join(hash(&key, 16)?);
        let key = serde_json::to_vec(&key).or_run()?;
        write_whole(&folder.join(SETTINGS_FILE), &key)?;
        Ok(Self { folder })
    }

    /// A finished run, or what `make` gives, which is then finished. One that cannot be read counts as not finished, as
    /// does one that is not `right`.
    pub(crate) fn finish<R: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        right: impl FnOnce(&R) -> bool,
        make: impl FnOnce() -> Outcome<R>,
    ) -> Outcome<R> {
        let path = self.folder.join(format!("{name}.json"));
        let content = std::fs::read(&path).unwrap_or_default();
        let kept: Option<R> = serde_json::from_slice(&content).ok();
        if let Some(run) = kept.filter(right) {
            return Ok(run);
        }
        let run = make()?;
        write_whole(&path, &serde_json::to_vec(&run).or_run()?)?;
        Ok(run)
    }

    /// Notes that all runs of a shard are finished.
    pub(crate) fn finish_shard(&self, shard: Shard) -> Outcome {
        let name = shard.to_string().replace('/', "-of-");
        let path = self.folder.join(name).with_extension(SHARD_EXTENSION);
        Ok(write_whole(&path, &serde_json::to_vec(&shard).or_run()?)?)
    }
}

/// The first letters of the hash of a value, to name files by.
pub(crate) fn hash(value: &impl Serialize, letters: usize) -> Outcome<String> {
    let hash = blake3::hash(&serde_json::to_vec(value).or_run()?);
    let mut hash = hash.to_hex().to_string();
    hash.truncate(letters);
    Ok(hash)
}

/// The hash of this program.
pub(crate) fn program() -> std::io::Result<String> {
    let program = std::fs::File::open(std::env::current_exe()?)?;
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(program)?;
    Ok(hasher.finalize().to_hex().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finish(runs: &Runs, number: u32) -> u32 {
        runs.finish("a", |_| true, || Ok(number)).unwrap()
    }

    #[test]
    fn runs_are_found_again_under_the_same_settings_alone() {
        let folder = tempfile::tempdir().unwrap();
        let runs = |settings: u32| Runs::new(folder.path(), &settings).unwrap();
        assert_eq!(finish(&runs(1), 5), 5);
        assert_eq!(finish(&runs(1), 6), 5);
        assert_eq!(finish(&runs(2), 7), 7);
    }

    #[test]
    fn a_truncated_run_counts_as_not_finished_as_does_a_wrong_one() {
        let folder = tempfile::tempdir().unwrap();
        let runs = Runs::new(folder.path(), &1).unwrap();
        assert_eq!(finish(&runs, 5), 5);
        std::fs::write(runs.folder.join("a.json"), b"\"").unwrap();
        assert_eq!(finish(&runs, 6), 6);
        let other = runs.finish("a", |run| *run == 8, || Ok(7));
        assert_eq!(other.unwrap(), 7);
    }
}
