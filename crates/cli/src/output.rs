//! Result files: written whole or not at all.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use comfy_table::Table;
use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use tempfile::{NamedTempFile, TempDir};

/// Writes a file so that it either has all of its content or does not change.
///
/// # Errors
/// What kept it from being written, with the path and a remedy.
pub fn write_whole(path: &Path, content: &[u8]) -> anyhow::Result<()> {
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    let write = || -> std::io::Result<()> {
        std::fs::create_dir_all(folder)?;
        let mut file = NamedTempFile::new_in(folder)?;
        file.write_all(content)?;
        file.as_file().sync_all()?;
        readable_by_all(file.as_file())?;
        file.persist(path)?;
        Ok(())
    };
    write().with_context(|| cannot_write(path))
}

/// Temporary files are private; results are not.
fn readable_by_all(file: &std::fs::File) -> std::io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        file.set_permissions(std::fs::Permissions::from_mode(0o644))?;
    }
    Ok(())
}

fn cannot_write(path: &Path) -> String {
    format!(
        "{} cannot be written: free some space, or choose another --out",
        path.display()
    )
}

/// A folder of result files that appear in their place only when all of them are complete.
#[derive(Debug)]
pub(crate) struct StagedFolder {
    target: PathBuf,
    staging: TempDir,
    names: Vec<String>,
}

impl StagedFolder {
    /// Prepares to write into `target`, which is created where it does not exist.
    pub(crate) fn new(target: &Path) -> anyhow::Result<Self> {
        let create = || -> std::io::Result<TempDir> {
            std::fs::create_dir_all(target)?;
            tempfile::Builder::new()
                .prefix(".unfinished-")
                .tempdir_in(target)
        };
        let staging = create().with_context(|| cannot_write(target))?;
        Ok(Self {
            target: target.to_owned(),
            staging,
            names: Vec::new(),
        })
    }

    /// Adds a file.
    pub(crate) fn add(&mut self, name: &str, content: &[u8]) -> anyhow::Result<()> {
        let write = || -> std::io::Result<()> {
            let mut file = std::fs::File::create(self.staging.path().join(name))?;
            file.write_all(content)?;
            file.sync_all()
        };
        write().with_context(|| cannot_write(&self.target.join(name)))?;
        self.names.push(name.to_owned());
        Ok(())
    }

    /// Moves all files to their place, in the order in which they were added.
    pub(crate) fn publish(self) -> anyhow::Result<()> {
        for name in &self.names {
            let target = self.target.join(name);
            std::fs::rename(self.staging.path().join(name), &target)
                .with_context(|| cannot_write(&target))?;
        }
        Ok(())
    }
}

/// A table for the terminal.
pub(crate) fn table() -> Table {
    let mut table = Table::new();
    table.load_style(UTF8_HORIZONTAL_ONLY);
    table
}

/// Prints a value as JSON on standard output.
///
/// # Errors
/// That it cannot be written.
pub fn print_json(value: &impl serde::Serialize) -> anyhow::Result<()> {
    let text = serde_json::to_string(value)?;
    print_line(&text)
}

/// Prints a line on standard output. That the reader went away is no failure: it has what it wanted.
///
/// # Errors
/// That it cannot be written for another reason.
pub fn print_line(text: &str) -> anyhow::Result<()> {
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(error).context("standard output cannot be written")
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn an_unwritable_place_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        write_whole(&file, b"x").unwrap();
        let error = write_whole(&file.join("below"), b"x").unwrap_err();
        assert!(format!("{error:#}").contains("below cannot be written"));
    }
}
