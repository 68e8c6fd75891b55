//! Experiments, data sets and documents, end to end.

#![cfg(test)]

mod dataset;
mod documents;
mod experiment;
mod physical;
#[path = "../printed.rs"]
mod printed;
mod ranges;
#[path = "../sequences.rs"]
mod sequences;

use std::path::Path;
use std::process::{Command, Output};

use printed::{errors, is_refused, json, text};
use serde_json::Value;

/// The program, with one cache for all tests: the objects are prepared once.
fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ppnpack-experiments"));
    let cache = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cache");
    command.env("XDG_CACHE_HOME", cache);
    command
}

/// Runs the program with these words behind its name.
fn ppnpack(words: &str) -> Output {
    let mut command = program();
    command.args(words.split_whitespace()).output().unwrap()
}

/// Makes the page of results by a program in `experiments`; gives its text, and the results with
/// what their runs came to.
fn page(program: &str, results: &Path, options: &[&str]) -> (String, Value) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut command = Command::new("python3");
    command.arg(root.join("experiments").join(program).with_extension("py"));
    let made = command.arg(results).args(options).output().unwrap();
    assert!(made.status.success(), "{program}: {}", errors(&made));
    let text = std::fs::read_to_string(results.with_extension("md")).unwrap();
    let kept = std::fs::read(results).unwrap();
    (text, serde_json::from_slice(&kept).unwrap())
}

/// Writes a box of these sides, in metres, as a mesh file.
fn write_box(folder: &Path, name: &str, sides_m: [f64; 3]) {
    let mut text = String::new();
    for corner in 0..8 {
        let at = |axis: usize| sides_m[axis] * (f64::from(corner >> axis & 1) - 0.5);
        text += &format!("v {} {} {}\n", at(0), at(1), at(2));
    }
    for face in [
        "1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6",
    ] {
        text += &format!("f {face}\n");
    }
    std::fs::write(folder.join(format!("{name}.obj")), text).unwrap();
}
