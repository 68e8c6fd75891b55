//! The network end to end: training that a kill does not change, packing with it, and what happens without it.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a failing test")]

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;

fn ppnpack(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ppnpack-torch"));
    let cache = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cache");
    command.args(arguments).env("XDG_CACHE_HOME", cache);
    command
}

fn run(arguments: &[&str]) -> Output {
    ppnpack(arguments).output().unwrap()
}

fn succeed(arguments: &[&str]) -> Output {
    let output = run(arguments);
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    output
}

/// A dataset of a few steps, with a sequence each for validation and for the test split.
fn dataset(folder: &Path) -> PathBuf {
    recorded(folder, &["--values"])
}

fn recorded(folder: &Path, more: &[&str]) -> PathBuf {
    let out = folder.join("dataset");
    let mut arguments = vec!["dataset", "--sequences", "10", "--length", "6"];
    arguments.extend(["--buffer", "2", "--out", out.to_str().unwrap()]);
    arguments.extend(more);
    succeed(&arguments);
    out
}

const SMALL: [&str; 9] = [
    "train", "--widths", "4,4", "--head", "4", "--batch", "4", "--epochs", "3",
];

/// The card of a trained network.
fn card(folder: &Path) -> Value {
    let card = std::fs::read(folder.join("model.json")).unwrap();
    serde_json::from_slice(&card).unwrap()
}

fn training<'a>(dataset: &'a Path, out: &'a Path, more: &[&'a str]) -> Vec<&'a str> {
    let mut arguments = SMALL.to_vec();
    arguments.extend(["--dataset", dataset.to_str().unwrap()]);
    arguments.extend(["--out", out.to_str().unwrap()]);
    arguments.extend(more);
    arguments
}

#[test]
fn a_training_killed_and_resumed_ends_like_one_that_was_not() {
    let folder = tempfile::tempdir().unwrap();
    let dataset = dataset(folder.path());
    let (whole, killed) = (folder.path().join("whole"), folder.path().join("killed"));
    succeed(&training(&dataset, &whole, &[]));

    let mut child = ppnpack(&training(&dataset, &killed, &[]))
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap().starts_with("epoch 1:")));
    // SIGKILL: nothing can be saved any more.
    child.kill().unwrap();
    child.wait().unwrap();
    succeed(&training(&dataset, &killed, &["--resume"]));

    let weights = |folder: &Path| std::fs::read(folder.join("model.safetensors")).unwrap();
    assert!(weights(&whole) == weights(&killed), "the weights differ");
    let (of_whole, of_killed) = (card(&whole), card(&killed));
    for part in ["accuracy", "validation", "test", "epoch"] {
        assert_eq!(of_whole[part], of_killed[part], "{part}");
    }
    // One sequence in ten is held out for validation, another one is the test split.
    assert_eq!(of_whole["validation"]["sequences"], 1, "{of_whole}");
    assert_eq!(of_whole["test"]["sequences"], 1, "{of_whole}");
    assert_eq!(of_whole["accuracy"], of_whole["test"]["proposed"]);
    assert!(killed.join("epochs.json").exists());
    // A checkpoint of another training is not gone on with.
    let other = training(&dataset, &killed, &["--resume", "--seed", "9"]);
    let refused = run(&other);
    assert!(!refused.status.success());
    let message = String::from_utf8_lossy(&refused.stderr);
    assert!(message.contains("checkpoint"), "{message}");
    // What was trained can propose.
    let model = whole.join("model.safetensors");
    let summary = pack(folder.path(), &["--model", model.to_str().unwrap()]);
    assert_eq!(summary["degraded"], serde_json::json!([]), "{summary}");
}

#[test]
fn the_test_split_is_looked_at_when_validation_has_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let dataset = dataset(folder.path());
    let out = folder.path().join("out");
    let misfits = ["--misfit-weight", "0.5"];
    let refused = run(&training(&dataset, &out, &misfits));
    let message = String::from_utf8_lossy(&refused.stderr);
    assert!(message.contains("--loss-over all"), "{message}");
    assert_eq!(refused.status.code(), Some(2));
    let over_all = ["--loss-over", "all", "--schedule", "constant"];
    let over_all = [&over_all[..], &misfits].concat();
    let weights = || std::fs::read(out.join("model.safetensors")).unwrap();
    succeed(&training(
        &dataset,
        &out,
        &[&over_all[..], &["--no-test"]].concat(),
    ));
    let (chosen, before) = (card(&out), weights());
    assert!(chosen["test"].is_null() && chosen["accuracy"] == serde_json::json!([]));
    // The weights are those of the epoch that does best on the validation split over all placements.
    let epochs: Vec<Value> =
        serde_json::from_slice(&std::fs::read(out.join("epochs.json")).unwrap()).unwrap();
    let share = |epoch: &Value| {
        let answers = &epoch["validation"]["accuracies"]["over_all"];
        answers[0]["share"].as_f64().unwrap()
    };
    let most = epochs.iter().map(share).fold(0.0, f64::max);
    let best = epochs.iter().find(|epoch| share(epoch) == most).unwrap();
    assert_eq!(chosen["epoch"], best["epoch"]);
    assert_eq!(chosen["training"]["misfit_weight"], 0.5);
    assert_eq!(chosen["validation"], best["validation"]["accuracies"]);

    succeed(&training(
        &dataset,
        &out,
        &[&over_all[..], &["--resume"]].concat(),
    ));
    let tested = card(&out);
    assert!(
        weights() == before,
        "looking at the test split changed the weights"
    );
    assert_eq!(tested["validation"], chosen["validation"]);
    assert_eq!(tested["test"]["over_all"].as_array().unwrap().len(), 5);
}

/// The table of ablations, by the program that trains.
fn table_3(dataset: &Path, out: &Path, more: &[&str]) -> Output {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments/table3.py");
    let mut command = Command::new("python3");
    command.arg(script);
    command.args(["--program", env!("CARGO_BIN_EXE_ppnpack-torch")]);
    command.arg("--dataset").arg(dataset).arg("--out").arg(out);
    command.args(more).output().unwrap()
}

#[test]
fn table_3_refuses_a_dataset_without_values_before_it_trains() {
    let folder = tempfile::tempdir().unwrap();
    let dataset = recorded(folder.path(), &[]);
    let out = folder.path().join("table3");
    let refused = table_3(&dataset, &out, &[]);
    assert_eq!(refused.status.code(), Some(2));
    let message = String::from_utf8_lossy(&refused.stderr);
    assert!(message.contains("ppnpack dataset --values"), "{message}");
    assert!(!out.exists(), "something was trained");
}

#[test]
fn table_3_tests_what_validation_chose() {
    let folder = tempfile::tempdir().unwrap();
    let dataset = dataset(folder.path());
    let out = folder.path().join("table3");
    let small = [
        "--epochs", "1", "--widths", "4,4", "--head", "4", "--batch", "8",
    ];
    let asked = [&["--seeds", "2", "--cut-off", "10,40"], &small[..]].concat();
    let made = table_3(&dataset, &out, &asked);
    let message = String::from_utf8_lossy(&made.stderr);
    assert!(made.status.success(), "{message}");
    let results = std::fs::read(out.join("table3.json")).unwrap();
    let results: Value = serde_json::from_slice(&results).unwrap();
    let lines = results["lines"].as_array().unwrap();
    assert_eq!(lines.len(), 4);
    for line in lines {
        assert_eq!(line["cards"].as_array().unwrap().len(), 2);
        assert!(line["over_all"]["1"]["mean"].is_number(), "{line}");
        let is_regression = line["cards"][0]["training"]["loss"] == "mse";
        let tried = line["tried"].as_array().unwrap();
        assert_eq!(tried.len(), if is_regression { 2 } else { 0 });
        if is_regression {
            let cut_off = &line["cards"][1]["training"]["cut_off"];
            assert_eq!(*cut_off, line["cut_off"]);
        }
    }
    // The paper's figures stand beside the paper's question alone.
    let page = std::fs::read_to_string(out.join("table3.md")).unwrap();
    assert_eq!(page.matches("[81.0]").count(), 1, "{page}");
    assert_eq!(page.matches("cut off at 40").count(), 2, "{page}");
    // Each row has two tested networks; of the regressions, one recipe was tried and left untested.
    let networks = out.join("networks");
    let seeds = |path: &Path| std::fs::read_dir(path).unwrap().count();
    for (network, recipes) in [("full", 1), ("no-ranking", 2)] {
        let found = std::fs::read_dir(networks.join(network)).unwrap();
        let mut found: Vec<usize> = found.map(|recipe| seeds(&recipe.unwrap().path())).collect();
        found.sort_unstable();
        assert_eq!(found.len(), recipes);
        assert_eq!(found.last(), Some(&2), "{network}: {found:?}");
        assert!(recipes == 1 || found.first() == Some(&1));
    }

    let refused = table_3(&dataset, &out, &["--validation", "0"]);
    let message = String::from_utf8_lossy(&refused.stderr);
    assert!(message.contains("no validation split"), "{message}");
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn a_loss_that_is_no_number_stops_the_training_and_keeps_the_batch() {
    let folder = tempfile::tempdir().unwrap();
    let dataset = dataset(folder.path());
    let out = folder.path().join("out");
    let output = run(&training(&dataset, &out, &["--learning-rate", "1e30"]));
    assert!(!output.status.success());
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("bad-batch.safetensors"), "{message}");
    assert!(out.join("bad-batch.safetensors").exists());
}

/// The grid that the shipped network learned on.
const OWN_GRID: [&str; 4] = ["--cell", "1cm", "--yaws", "4"];

/// Packs with the network, on its own grid where none is named; gives the summary.
fn pack(folder: &Path, more: &[&str]) -> Value {
    let out = folder.join("packed");
    let mut arguments = vec!["pack", "--random", "10", "--seed", "4", "--json"];
    arguments.extend(["--out", out.to_str().unwrap()]);
    if !more.contains(&"--proposals") {
        arguments.extend(["--proposals", "network"]);
    }
    if !more.contains(&"--yaws") {
        arguments.extend(OWN_GRID);
    }
    arguments.extend(more);
    serde_json::from_slice(&succeed(&arguments).stdout).unwrap()
}

#[test]
fn the_shipped_network_packs_on_its_own_grid_and_on_others() {
    let folder = tempfile::tempdir().unwrap();
    for grid in [
        &OWN_GRID[..],
        &["--cell", "2.5mm", "--yaws", "16"],
        &["--cell", "5mm", "--yaws", "8"],
        &["--container", "25x41x20cm", "--yaws", "3"],
    ] {
        let summary = pack(folder.path(), grid);
        assert_eq!(summary["degraded"], serde_json::json!([]), "{summary}");
        // What it packs it proposed itself.
        assert_eq!(summary["steps_widened"], 0, "{summary}");
        assert_eq!(
            summary["settings"]["method"]["proposals"]["from"],
            "network"
        );
        assert!(
            summary["packed"]["items"].as_u64().unwrap() >= 6,
            "{summary}"
        );
        assert!(summary["stages_s"]["propose"].as_f64().unwrap() > 0.0);
    }
}

#[test]
fn packing_with_the_network_repeats_itself() {
    let folder = tempfile::tempdir().unwrap();
    let packed = || {
        let mut summary = pack(folder.path(), &["--proposals", "network:3"]);
        for timed in ["decision_s", "stages_s", "took_s"] {
            summary.as_object_mut().unwrap().remove(timed);
        }
        summary
    };
    assert_eq!(packed(), packed());
}

#[test]
fn the_command_without_libtorch_hands_over_to_the_one_with_it() {
    let torch = Path::new(env!("CARGO_BIN_EXE_ppnpack-torch"));
    let program = torch.with_file_name("ppnpack");
    if !program.exists() {
        eprintln!("skipped: {} is not built", program.display());
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let output = Command::new(program)
        .args(["pack", "--random", "4", "--json", "--proposals", "network"])
        .args(["--out", out.to_str().unwrap()])
        .env(
            "XDG_CACHE_HOME",
            Path::new(env!("CARGO_TARGET_TMPDIR")).join("cache"),
        )
        .output()
        .unwrap();
    assert!(output.status.success());
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["degraded"], serde_json::json!([]), "{summary}");
}

#[test]
fn cuda_that_is_not_there_gives_way_to_the_exhaustive_search_with_the_reason() {
    if Path::new("/dev/nvidia0").exists() {
        eprintln!("skipped: there is a CUDA device");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("packed");
    let output = ppnpack(&["pack", "--random", "4", "--json", "--proposals", "network"])
        .args(["--out", out.to_str().unwrap()])
        .env("PPNPACK_TORCH", folder.path())
        .output()
        .unwrap();
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    let degraded = summary["degraded"].as_array().unwrap();
    let reason = degraded.first().unwrap()["reason"].as_str().unwrap();
    assert!(reason.contains("CUDA"), "{reason}");
}
