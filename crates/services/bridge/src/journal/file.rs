//! The file of a journal.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use redb::{Builder, Database};

use super::database::Fault;

/// Memory for pages of the database.
const CACHE_BYTES: usize = 16 << 20;

/// Opens a journal, and begins it where there is none.
pub(super) fn open(path: &Path) -> Result<Database, Fault> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    // What another program changed in the file is found here, and not taken for what was written.
    let database = Builder::new()
        .set_cache_size(CACHE_BYTES)
        .set_check_integrity_on_open(true)
        .create(path)?;
    Ok(database)
}

/// Gives a damaged journal another name.
pub(super) fn put_aside(path: &Path, fault: &Fault) -> Result<(), Fault> {
    let aside = free_name(path);
    fs::rename(path, &aside)?;
    tracing::error!(
        journal = %path.display(),
        kept_as = %aside.display(),
        %fault,
        "the journal is damaged: it was put aside and a new one begun; cells that it is needed for begin empty, and \
         what was planned for them is stale"
    );
    Ok(())
}

fn free_name(path: &Path) -> PathBuf {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH);
    let millis = since_1970.map_or(0, |since_1970| since_1970.as_millis());
    let name = |count: u32| {
        let mut name = path.as_os_str().to_owned();
        name.push(format!(".damaged-{millis}-{count}"));
        PathBuf::from(name)
    };
    let free = (0..1000).map(name).find(|name| !name.exists());
    free.unwrap_or_else(|| name(1000))
}
