//! Finished runs of an experiment, kept on disk so that a killed experiment goes on where it was.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::failure::{OrRun, Outcome};
use crate::output::write_whole;

/// A folder of finished runs that all depended on the same settings.
#[derive(Debug)]
pub(super) struct Runs {
    folder: PathBuf,
}

impl Runs {
    /// The runs made with these settings: a change of any of them starts anew, in a folder of its own.
    pub(super) fn new(folder: &Path, settings: &impl Serialize) -> Outcome<Self> {
        let settings = serde_json::to_vec(settings).or_run()?;
        let key = blake3::hash(&settings).to_hex();
        let folder = folder.join(key.get(..16).unwrap_or("settings"));
        write_whole(&folder.join("settings.json"), &settings)?;
        Ok(Self { folder })
    }

    /// A finished run; one that cannot be read counts as not finished.
    pub(super) fn load<R: DeserializeOwned>(&self, name: &str) -> Option<R> {
        let content = std::fs::read(self.path(name)).ok()?;
        serde_json::from_slice(&content).ok()
    }

    /// Keeps a finished run.
    pub(super) fn save(&self, name: &str, run: &impl Serialize) -> Outcome {
        Ok(write_whole(
            &self.path(name),
            &serde_json::to_vec(run).or_run()?,
        )?)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.json"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_found_again_under_the_same_settings_alone() {
        let folder = tempfile::tempdir().unwrap();
        let runs = Runs::new(folder.path(), &1).unwrap();
        runs.save("a", &[1.5, 2.5]).unwrap();
        let again = Runs::new(folder.path(), &1).unwrap();
        assert_eq!(again.load::<Vec<f64>>("a"), Some(vec![1.5, 2.5]));
        let other = Runs::new(folder.path(), &2).unwrap();
        assert_eq!(other.load::<Vec<f64>>("a"), None);
    }

    #[test]
    fn a_truncated_run_counts_as_not_finished() {
        let folder = tempfile::tempdir().unwrap();
        let runs = Runs::new(folder.path(), &1).unwrap();
        runs.save("a", &[1.5, 2.5]).unwrap();
        std::fs::write(runs.path("a"), b"[1.5,").unwrap();
        assert_eq!(runs.load::<Vec<f64>>("a"), None);
    }
}
