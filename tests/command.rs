//! The program as a user runs it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

pub(crate) fn ppnpack(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ppnpack"));
    command.args(arguments).env("XDG_CACHE_HOME", cache());
    command.output().unwrap()
}

/// One cache for all tests: the objects are prepared once.
pub(crate) fn cache() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("cache")
}

/// Runs a command that must be refused with exit code 2 and a message that has all of these parts.
pub(crate) fn refused(arguments: &[&str], parts: &[&str]) {
    let output = ppnpack(arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    for part in parts {
        assert!(
            error.contains(part),
            "{arguments:?}: '{part}' is not in: {error}"
        );
    }
    assert!(!error.contains("panicked"), "{error}");
    // The command's own errors take one line; those of the command line's parser come with a hint.
    if error.starts_with("ppnpack: ") {
        assert_eq!(error.trim_end().lines().count(), 1, "{error}");
    }
}

pub(crate) fn json(output: &Output) -> Value {
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    serde_json::from_slice(&output.stdout).unwrap()
}
