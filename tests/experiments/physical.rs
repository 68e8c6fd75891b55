//! The robot cell, simulated with its sensors: from objects on a tray to a session that knows where
//! they lie.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::{is_refused, json, ppnpack, write_box};

/// Folders of two boxes that are not known, and of one that is.
fn boxes(folder: &Path) -> [PathBuf; 2] {
    let of = |name: &str| {
        let path = folder.join(name);
        std::fs::create_dir(&path).unwrap();
        path
    };
    let (unseen, known) = (of("unseen"), of("known"));
    write_box(&unseen, "slab", [0.14, 0.09, 0.045]);
    write_box(&unseen, "bar", [0.12, 0.06, 0.05]);
    write_box(&known, "block", [0.08, 0.07, 0.06]);
    [unseen, known]
}

/// Makes runs with all three boxes; gives what is printed.
fn physical(boxes: &[PathBuf; 2], out: &Path, options: &str) -> Value {
    let [unseen, known] = boxes.each_ref().map(|path| path.display());
    json(&ppnpack(&format!(
        "experiment physical --unseen {unseen} --known {known} --unseen-count 2 --drops 0 --missed-picks 0 --json --out {} {options}",
        out.display()
    )))
}

/// Makes one run on three boxes, and gives the results of all contenders.
fn experiment(options: &str) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let boxes = boxes(folder.path());
    let out = &folder.path().join("out");
    let results = physical(&boxes, out, &format!("--runs 1 {options}"));
    for contender in ["physical-test", "tried", "tried-dense"] {
        for file in ["tray.png", "packed.png", "heightmap.png"] {
            let path = out.join(contender).join(file);
            assert!(path.exists(), "{}", path.display());
        }
    }
    results
}

/// The items of all runs of a contender.
fn items(line: &Value) -> impl Iterator<Item = &Value> {
    let records = line["records"].as_array().unwrap().iter();
    records.flat_map(|record| record["items"].as_array().unwrap())
}

/// Whether an object was taken for itself.
fn is_right(item: &Value) -> bool {
    item["seen_as"]["object"]["name"] == item["object"]
}

/// The results of each contender; where a network runs here, it is the last.
fn lines(results: &Value) -> &[Value] {
    let lines = results["lines"].as_array().unwrap();
    let methods = lines.iter().filter_map(|line| line["method"].as_str());
    let methods: Vec<&str> = methods.collect();
    let expected = ["physical test", "tried", "tried, dense"];
    assert!(methods.starts_with(&expected), "{methods:?}");
    lines
}

#[test]
fn known_objects_are_recognised_packed_and_found_again() {
    let results = experiment("");
    let grid = &results["settings"]["grid"];
    assert_eq!(grid["cell_m"], 0.005);
    assert_eq!(grid["yaws"], 8);
    for line in lines(&results) {
        assert_packed_and_found_again(line);
    }
}

fn assert_packed_and_found_again(line: &Value) {
    let method = &line["method"];
    assert_eq!(items(line).count(), 3, "{method}");
    let run = &line["records"][0];
    assert_eq!(run["deepest_overlap_m"], 0.0, "{method}");
    for item in items(line) {
        let placed = &item["end"]["placed"];
        assert_eq!(placed["is_inside"], true, "{method}: {item:?}");
        let tilt_rad = placed["tilt_rad"].as_f64().unwrap();
        assert!(tilt_rad < 30_f64.to_radians(), "{method}: {item:?}");
        assert!(is_right(item), "{method}: {item:?}");
        let found = &item["found"];
        let is_found = found["kind"] == "as_planned" || found["kind"] == "moved";
        assert!(is_found, "{method}: {item:?}");
        let off_m = found["position_off_m"].as_f64().unwrap();
        assert!(off_m < 0.005, "{method}: {item:?}");
    }
    for decision in run["decisions"].as_array().unwrap() {
        let cycle_s = decision["cycle_s"].as_f64().unwrap();
        assert!(cycle_s > 0.5, "{method}: {decision:?}");
    }
}

#[test]
fn strangers_are_packed_as_unknown_items() {
    let results = experiment("--strangers --arm none --cell 1cm --yaws 4");
    let grid = &results["settings"]["grid"];
    assert_eq!(grid["cell_m"], 0.01);
    assert_eq!(grid["yaws"], 4);
    for line in lines(&results) {
        let method = &line["method"];
        assert_eq!(items(line).count(), 3, "{method}");
        for item in items(line) {
            assert!(item["end"]["placed"].is_object(), "{method}: {item:?}");
            // What is not in the catalogue cannot be found again, and that is said.
            if item["is_known"] == true {
                assert!(is_right(item), "{method}: {item:?}");
            } else {
                assert_eq!(item["seen_as"], "unknown", "{method}: {item:?}");
                assert_eq!(item["found"]["kind"], "unclear", "{method}: {item:?}");
            }
        }
        let strangers = items(line).filter(|item| item["is_known"] == false);
        assert_eq!(strangers.count(), 2, "{method}");
    }
}

/// The runs that are kept in a folder of results, in the order of their text.
fn kept(out: &Path) -> Vec<String> {
    let groups = out.join("runs").read_dir().unwrap();
    let files = groups.flat_map(|group| group.unwrap().path().read_dir().unwrap());
    let paths = files.map(|file| file.unwrap().path());
    let runs = paths.filter(|path| !path.ends_with("settings.json"));
    let runs = runs.map(|path| std::fs::read_to_string(path).unwrap());
    let mut runs: Vec<String> = runs.collect();
    runs.sort();
    runs
}

#[test]
fn the_whole_takes_over_the_runs_of_its_ranges() {
    let folder = tempfile::tempdir().unwrap();
    let boxes = boxes(folder.path());
    let out = folder.path().join("out");
    let make = |range: &str| {
        let coarse = "--arm none --cell 1cm --yaws 4";
        physical(&boxes, &out, &format!("{coarse} {range}"))
    };
    make("--runs 1 --first 0");
    make("--runs 1 --first 1");
    let made = kept(&out);
    // None is made anew: each has times of its own.
    let results = make("--runs 2 --first 0");
    assert_eq!(kept(&out), made);
    let lines = lines(&results);
    assert_eq!(made.len(), 2 * lines.len());
    for line in lines {
        assert_eq!(line["records"].as_array().unwrap().len(), 2);
        assert_eq!(items(line).count(), 6);
    }
}

#[test]
fn too_few_objects_and_unknown_arms_are_refused() {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    write_box(folders[0].path(), "slab", [0.14, 0.09, 0.045]);
    write_box(folders[1].path(), "block", [0.08, 0.07, 0.06]);
    let [unseen, known] = folders.each_ref().map(|folder| folder.path().display());
    let refused = |options: &str, part: &str| {
        let physical = format!("experiment physical --unseen {unseen} --runs 1 {options}");
        is_refused(&ppnpack(&physical), &[part]);
    };
    let twice = format!("--arm none --known {unseen}");
    refused(&twice, "both --unseen and --known");
    refused(&format!("--arm no-such-arm --known {known}"), "nachi-mz07l");
    refused(&format!("--arm none --known {known}"), "too few for a run");
}
