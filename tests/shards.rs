//! Experiments that are made by shards.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Output;

use serde_json::Value;

/// Makes an experiment at once, and as two shards that are merged: both have the same runs, and results, bit for bit.
pub(crate) fn is_the_same_as_shards(ppnpack: fn(&[&str]) -> Output, experiment: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let succeed = |arguments: &[&str]| {
        let output = ppnpack(arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{arguments:?}: {error}");
        output.stdout
    };
    let make = |name: &str, more: &[&str]| {
        let out = at(name);
        let options = ["--json", "--out", out.to_str().unwrap()];
        let printed = succeed(&[&["experiment"][..], experiment, &options, more].concat());
        timeless(serde_json::from_slice(&printed).unwrap())
    };
    let single = make("single", &[]);
    make("a", &["--shard", "0/2"]);
    make("b", &["--shard", "1/2"]);
    let kept = ["a", "b", "all", "single"].map(|name| at(name).join("runs"));
    let [a, b, all, _] = kept.each_ref().map(|path| path.to_str().unwrap());
    succeed(&["experiment", "merge", a, b, "--into", all]);
    let [a, b, all, once] = kept.each_ref().map(|path| runs(path));
    assert_eq!(all, once, "{experiment:?}");
    let is_part = |part: &BTreeMap<String, Value>| part.len() < all.len();
    assert!(is_part(&a) && is_part(&b), "{experiment:?}");
    assert_eq!(make("all", &[]), single, "{experiment:?}");
}

/// Results without times, at any depth, and without what made them: those are the machine's.
fn timeless(results: Value) -> Value {
    match results {
        Value::Object(fields) => {
            let fields = fields.into_iter();
            let kept = fields.filter(|(name, _)| !name.ends_with("_s") && name != "origin");
            kept.map(|(name, value)| (name, timeless(value))).collect()
        }
        Value::Array(values) => values.into_iter().map(timeless).collect(),
        other => other,
    }
}

/// The runs of a folder by name, without their times.
pub(crate) fn runs(folder: &Path) -> BTreeMap<String, Value> {
    let files = walkdir(folder).into_iter();
    let runs = files.filter(|path| path.extension().is_some_and(|end| end == "json"));
    let named = |path: PathBuf| {
        let run = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        let name = path.strip_prefix(folder).unwrap();
        (name.to_string_lossy().into_owned(), timeless(run))
    };
    runs.map(named).collect()
}

fn walkdir(folder: &Path) -> Vec<PathBuf> {
    let entries = folder.read_dir().unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    paths
        .flat_map(|path| {
            if path.is_dir() {
                walkdir(&path)
            } else {
                vec![path]
            }
        })
        .collect()
}
