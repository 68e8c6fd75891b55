//! What a program printed, as tests read it.

use std::process::Output;

use serde_json::Value;

/// What it printed on standard error.
pub(crate) fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// What a program that succeeded printed.
pub(crate) fn text(output: &Output) -> String {
    assert!(output.status.success(), "{}", errors(output));
    String::from_utf8(output.stdout.clone()).unwrap()
}

pub(crate) fn json(output: &Output) -> Value {
    serde_json::from_str(&text(output)).unwrap()
}

/// Asserts that it refused its input with exit code 2 and a message that has all of these parts.
pub(crate) fn is_refused(output: &Output, parts: &[&str]) {
    let error = errors(output);
    assert_eq!(output.status.code(), Some(2), "{error}");
    for part in parts {
        assert!(error.contains(part), "'{part}' is not in: {error}");
    }
    assert!(!error.contains("panicked"), "{error}");
    // The program's own errors take one line; those of the command line's parser come with a hint.
    if error.starts_with("ppnpack: ") {
        assert_eq!(error.trim_end().lines().count(), 1, "{error}");
    }
}
