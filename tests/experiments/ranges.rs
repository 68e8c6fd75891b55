//! Experiments whose ranges are made apart, and put together.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::{json, page, ppnpack};

/// Makes an experiment at once, and as two ranges that keep their runs in one folder: the whole
/// made of those has the same runs, and results, bit for bit, and a page is made of them. `count`
/// names the option of how many there are, of which there are 0 to `all` from `first` on.
pub(crate) fn is_the_same_as_ranges(experiment: &str, count: &str, [first, all]: [u32; 2]) {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let kept = at("kept");
    let named = experiment.split(' ').next().unwrap();
    let make = |name: &str, [first, all]: [u32; 2], more: &str| {
        let out = at(name).display().to_string();
        let range = format!("--json --out {out} --first {first} {count} {all}");
        let printed = json(&ppnpack(&format!("experiment {experiment} {range} {more}")));
        // What is printed is kept.
        let kept = std::fs::read(at(name).join(named).with_extension("json")).unwrap();
        let kept: Value = serde_json::from_slice(&kept).unwrap();
        assert_eq!(kept, printed, "{experiment}");
        timeless(printed)
    };
    let single = make("single", [first, all], "");
    let once = runs(&at("single").join("runs"));
    let together = format!("--runs {}", kept.display());
    let half = all.div_ceil(2);
    make("a", [first, half], &together);
    let of_a = runs(&kept);
    assert!(of_a.len() < once.len(), "{experiment}");
    make("b", [first + half, all - half], &together);
    assert_eq!(runs(&kept), once, "{experiment}");
    assert_eq!(make("all", [first, all], &together), single, "{experiment}");
    let program = match named {
        "table1" | "table4" | "pareto" => "tables",
        // That learns, and needs more than Python alone.
        "value" => return,
        other => other,
    };
    let results = at("all").join(named).with_extension("json");
    let (text, _) = page(program, &results, &["--runs", kept.to_str().unwrap()]);
    assert!(text.contains("|---|"), "{text}");
}

/// Results without times, at any depth, and without what made them: those are the machine's.
fn timeless(results: Value) -> Value {
    match results {
        Value::Object(fields) => {
            let fields = fields.into_iter();
            let is_time = |name: &str| name.ends_with("_s") || name.starts_with("decision_");
            let kept = fields.filter(|(name, _)| !is_time(name) && name != "origin");
            kept.map(|(name, value)| (name, timeless(value))).collect()
        }
        Value::Array(values) => values.into_iter().map(timeless).collect(),
        other => other,
    }
}

/// The runs of a folder by name, without their times.
fn runs(folder: &Path) -> BTreeMap<String, Value> {
    let files = walkdir(folder).into_iter();
    let runs = files.filter(|path| path.extension().is_some_and(|end| end == "json"));
    let named = |path: PathBuf| {
        let run = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        let name = path.strip_prefix(folder).unwrap();
        (name.to_string_lossy().into_owned(), timeless(run))
    };
    runs.map(named).collect()
}

/// The files in a folder, at any depth.
fn walkdir(folder: &Path) -> Vec<PathBuf> {
    let entries = folder.read_dir().unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let files = paths.flat_map(|path| match path.is_dir() {
        true => walkdir(&path),
        false => vec![path],
    });
    files.collect()
}
