//! A small disk of its own that can be filled and freed.
//!
//! It is a file system in memory: mounting one needs root.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Result;

/// A file system in memory, unmounted when it is dropped.
#[derive(Debug)]
pub(crate) struct Disk {
    folder: PathBuf,
}

impl Disk {
    /// A disk of so many MiB at a folder, which is made; `None` where mounting is not allowed.
    pub(crate) fn mount(at: &Path, mib: u32) -> Result<Option<Self>> {
        std::fs::create_dir_all(at)?;
        let mut mount = Command::new("mount");
        mount.args(["-t", "tmpfs", "-o", &format!("size={mib}m"), "tmpfs"]);
        let mounted = mount.arg(at).output();
        let is_mounted = mounted.is_ok_and(|output| output.status.success());
        Ok(is_mounted.then(|| Self {
            folder: at.to_owned(),
        }))
    }

    pub(crate) fn fill(&self) -> Result<()> {
        let mut file = File::create(self.filler())?;
        for size in [65_536, 512, 1] {
            while file.write_all(&vec![0; size]).is_ok() {}
        }
        Ok(())
    }

    /// Takes away what filled it.
    pub(crate) fn free(&self) -> Result<()> {
        Ok(std::fs::remove_file(self.filler())?)
    }

    fn filler(&self) -> PathBuf {
        self.folder.join("filler")
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        let mut unmount = Command::new("umount");
        // What still has a file open there ends later.
        drop(unmount.arg("--lazy").arg(&self.folder).status());
    }
}
