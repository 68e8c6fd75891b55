//! Data that lies beside the repository, in `../shared`, not in it.

use std::path::{Path, PathBuf};

/// A file or folder there; `None` where it is absent: the test is named as skipped, and fails where `CI` is set.
pub(crate) fn shared(path: &str) -> Option<PathBuf> {
    let repository = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let found = Path::new(repository).join("../shared").join(path);
    if found.exists() {
        return Some(found);
    }
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    assert!(
        std::env::var_os("CI").is_none(),
        "{test}: no ../shared/{path}"
    );
    eprintln!("skipped: {test}: no ../shared/{path}");
    None
}
