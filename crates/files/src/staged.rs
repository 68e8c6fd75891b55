//! Files that appear together.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use tempfile::{Builder, TempDir};

use crate::{UNFINISHED, WriteError};

/// A folder of files that appear in their place only when all of them are complete.
#[derive(Debug)]
pub struct StagedFolder {
    target: PathBuf,
    staging: TempDir,
    names: Vec<String>,
}

impl StagedFolder {
    /// Prepares to write into `target`, which is created where it does not exist.
    ///
    /// # Errors
    /// [`WriteError`] names the folder.
    pub fn new(target: &Path) -> Result<Self, WriteError> {
        let create = || -> std::io::Result<TempDir> {
            std::fs::create_dir_all(target)?;
            Builder::new().prefix(UNFINISHED).tempdir_in(target)
        };
        Ok(Self {
            staging: create().map_err(WriteError::at(target))?,
            target: target.to_owned(),
            names: Vec::new(),
        })
    }

    /// Checks that files can be written into `target`, which need not be there yet. Leaves nothing.
    ///
    /// # Errors
    /// [`WriteError`] names the folder.
    pub fn check(target: &Path) -> Result<(), WriteError> {
        let mut there = target.ancestors().filter(|folder| folder.exists());
        let there = there.next().unwrap_or(Path::new("."));
        let made = Builder::new().prefix(UNFINISHED).tempdir_in(there);
        made.map(drop).map_err(WriteError::at(target))
    }

    /// Adds a file.
    ///
    /// # Errors
    /// [`WriteError`] names the file.
    pub fn add(&mut self, name: &str, content: &[u8]) -> Result<(), WriteError> {
        let write = || -> std::io::Result<()> {
            let mut file = File::create(self.staging.path().join(name))?;
            file.write_all(content)?;
            file.sync_all()
        };
        write().map_err(WriteError::at(&self.target.join(name)))?;
        self.names.push(name.to_owned());
        Ok(())
    }

    /// Moves all files to their place, in the order in which they were added.
    ///
    /// # Errors
    /// [`WriteError`] names the first file that cannot be moved.
    pub fn publish(self) -> Result<(), WriteError> {
        for name in &self.names {
            let target = self.target.join(name);
            std::fs::rename(self.staging.path().join(name), &target)
                .map_err(WriteError::at(&target))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_where_nothing_can_be_written_is_refused_and_nothing_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let (file, below) = (folder.path().join("file"), folder.path().join("a/b"));
        std::fs::write(&file, b"x").unwrap();
        StagedFolder::check(&below).unwrap();
        for place in [file.clone(), file.join("below")] {
            let error = StagedFolder::check(&place).unwrap_err();
            assert_eq!(error.path, place);
        }
        assert_eq!(folder.path().read_dir().unwrap().count(), 1);
    }

    #[test]
    fn files_appear_only_when_published() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("out");
        let mut staged = StagedFolder::new(&target).unwrap();
        staged.add("a.txt", b"one").unwrap();
        assert!(!target.join("a.txt").exists());
        staged.publish().unwrap();
        assert_eq!(std::fs::read(target.join("a.txt")).unwrap(), b"one");
        assert_eq!(
            target.read_dir().unwrap().count(),
            1,
            "the staging folder is gone"
        );
    }
}
