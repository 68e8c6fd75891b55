//! Finished runs on disk: a killed experiment goes on where it was, and ranges are put together.

use std::path::{Path, PathBuf};

use clap::Args;
use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_files::write_whole;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use crate::results::{OutOptions, with};
use crate::workers;

/// Options of results and finished runs, and of how many runs are made at once.
#[derive(Debug, Args)]
pub(crate) struct RunsOptions {
    /// Folder of finished runs, so that a killed experiment goes on, and one over a whole range
    /// takes over what was made of its parts [default: runs in --out]
    #[arg(long, value_name = "DIR")]
    runs: Option<PathBuf>,

    /// Runs made at once; one per core at most, so that decision times stay those of a free core
    /// [default: one per core]
    #[arg(long, value_name = "COUNT")]
    workers: Option<usize>,

    #[command(flatten)]
    out: OutOptions,
}

impl RunsOptions {
    fn workers(&self) -> usize {
        let cores = workers::default_count();
        self.workers.unwrap_or(cores).clamp(1, cores)
    }

    /// The runs of an experiment that are kept under these settings.
    pub(crate) fn kept(&self, experiment: &str, settings: &impl Serialize) -> Outcome<Runs> {
        let usual = || self.out.folder(experiment).join("runs");
        let folder = self.runs.clone().unwrap_or_else(usual);
        Runs::new(&folder, settings, self.workers())
    }

    /// Publishes the results of an experiment; a program in `experiments` makes the page of its
    /// runs.
    pub(crate) fn publish(&self, name: &str, results: Value, program: &str) -> Outcome {
        let results = with(results, json!({ "workers": self.workers() }));
        let runs = self.runs.iter();
        let runs: String = runs
            .map(|runs| format!(" --runs {}", runs.display()))
            .collect();
        self.out.publish(name, results, program, &runs)
    }
}

#[derive(Debug)]
pub(crate) struct Runs {
    folder: PathBuf,
    workers: usize,
}

#[derive(Serialize)]
struct Key<'a, S> {
    /// The hash of the program: what another build decides is not mixed in.
    program: &'a str,
    settings: &'a S,
}

impl Runs {
    /// The runs of these settings and this program; a change of either starts a new folder.
    pub(crate) fn new(folder: &Path, settings: &impl Serialize, workers: usize) -> Outcome<Self> {
        let program = program().or_run()?;
        let key = Key {
            program: &program,
            settings,
        };
        let key = serde_json::to_vec(&key).or_run()?;
        let folder = folder.join(hash(&key, 16));
        write_whole(&folder.join("settings.json"), &key)?;
        Ok(Self { folder, workers })
    }

    pub(crate) fn name(&self) -> String {
        let name = self.folder.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    }

    /// Makes all, but those that are there and right, and gives them in their order.
    pub(crate) fn make<J: Sync, R: Serialize + DeserializeOwned + Send + Sync>(
        &self,
        all: &[J],
        name: impl Fn(&J) -> String + Sync,
        is_right: impl Fn(&J, &R) -> bool + Sync,
        make: impl Fn(&J) -> Outcome<R> + Sync,
    ) -> Outcome<Vec<R>> {
        workers::map("Packing", all, self.workers, |job| {
            self.finish(&name(job), |run| is_right(job, run), || make(job))
        })
    }

    /// A finished run, or what `make` gives, which is then finished. One that cannot be read counts
    /// as not finished, as does one that is not `right`.
    fn finish<R: Serialize + DeserializeOwned>(
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
}

/// The first letters of the hash of some bytes, to name files by.
pub(crate) fn hash(bytes: &[u8], letters: usize) -> String {
    let mut hash = blake3::hash(bytes).to_hex().to_string();
    hash.truncate(letters);
    hash
}

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
        let runs = |settings: u32| Runs::new(folder.path(), &settings, 1).unwrap();
        assert_eq!(finish(&runs(1), 5), 5);
        assert_eq!(finish(&runs(1), 6), 5);
        assert_eq!(finish(&runs(2), 7), 7);
    }

    #[test]
    fn a_truncated_run_counts_as_not_finished_as_does_a_wrong_one() {
        let folder = tempfile::tempdir().unwrap();
        let runs = Runs::new(folder.path(), &1, 1).unwrap();
        assert_eq!(finish(&runs, 5), 5);
        std::fs::write(runs.folder.join("a.json"), b"\"").unwrap();
        assert_eq!(finish(&runs, 6), 6);
        let other = runs.finish("a", |run| *run == 8, || Ok(7));
        assert_eq!(other.unwrap(), 7);
    }
}
