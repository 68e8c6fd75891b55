//! `ppnpack dataset` end to end: whole files whatever happens, and one clear line for every bad input.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use ppnpack_dataset::{Dataset, Split, draw};
use tempfile::TempDir;

use super::{errors, is_refused, json, program, write_box};

/// The boxes that are packed, in metres.
const BOXES: [[f64; 3]; 3] = [[0.08, 0.06, 0.04], [0.05, 0.05, 0.10], [0.12, 0.04, 0.03]];

/// A folder of meshes, made once and only a few: every run loads them all.
static CATALOGUE: LazyLock<TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    for (index, sides_m) in BOXES.iter().enumerate() {
        write_box(folder.path(), &format!("box{index}"), *sides_m);
    }
    folder
});

fn command(out: &Path, words: &str) -> Command {
    let catalogue = CATALOGUE.path().display();
    let asked = format!(
        "dataset --length 3 --buffer 2 --catalogue {catalogue} --out {} {words}",
        out.display()
    );
    let mut command = program();
    command.args(asked.split_whitespace());
    command.env("XDG_CACHE_HOME", CATALOGUE.path().join("cache"));
    command
}

fn ppnpack(out: &Path, words: &str) -> Output {
    command(out, words).output().unwrap()
}

/// Every file of a folder with its content, but for half-written ones.
fn content(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap();
    let files = entries.map(|entry| {
        let path = entry.unwrap().path();
        let name = PathBuf::from(path.file_name().unwrap());
        (name, std::fs::read(&path).unwrap())
    });
    let whole = files.filter(|(name, _)| !name.to_string_lossy().starts_with('.'));
    whole.collect()
}

#[test]
fn a_killed_run_goes_on_and_ends_with_the_same_files() {
    let folder = tempfile::tempdir().unwrap();
    let (straight, killed) = (folder.path().join("straight"), folder.path().join("killed"));
    let asked = "--sequences 25 --values --json";
    let summary = json(&ppnpack(&straight, &format!("{asked} --workers 3")));

    let mut child = command(&killed, &format!("{asked} --workers 1"))
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let first = killed.join("sequence-00000.safetensors.zst");
    let started = Instant::now();
    while !first.exists() {
        let waited = started.elapsed();
        assert!(waited < Duration::from_secs(120), "no sequence appears");
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!killed.join("sequence-00024.safetensors.zst").exists());
    let kept = std::fs::metadata(&first).unwrap().modified().unwrap();

    let again = ppnpack(&killed, asked);
    assert_eq!(json(&again), summary);
    assert_eq!(content(&killed), content(&straight));
    let modified = std::fs::metadata(&first).unwrap().modified().unwrap();
    assert_eq!(modified, kept, "the finished sequence is kept");

    std::fs::write(&first, b"half").unwrap();
    let repaired = ppnpack(&killed, asked);
    assert_eq!(json(&repaired), summary);
    let error = errors(&repaired);
    assert!(error.contains("sequence-00000"), "{error}");
    assert_eq!(content(&killed), content(&straight));
}

#[test]
fn a_dataset_of_ranges_is_that_of_a_single_run() {
    let [single, first, all] = [(); 3].map(|()| tempfile::tempdir().unwrap());
    let asked = "--sequences 6 --json";
    json(&ppnpack(single.path(), asked));
    for (folder, from, cases, played) in [(&first, 0, 4, 4), (&all, 4, 10, 2)] {
        let range = format!("{asked} --first {from} --cases {cases}");
        let summary = json(&ppnpack(folder.path(), &range));
        assert_eq!(summary["played"], played);
    }
    for (name, file) in content(first.path()) {
        std::fs::write(all.path().join(name), file).unwrap();
    }
    let summary = json(&ppnpack(all.path(), asked));
    assert_eq!(summary["sequences"], 6);
    assert_eq!(content(all.path()), content(single.path()));
}

#[test]
fn a_dataset_has_what_was_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("data");
    let summary = json(&ppnpack(&out, "--sequences 10 --seed 5 --json"));
    let dataset = Dataset::open(&out).unwrap();
    assert_eq!(summary["hash"], dataset.hash());
    assert_eq!(summary["sequences"], 10);
    let load = |split| dataset.load(split, true, &|_, _| {}).unwrap();
    let steps = [Split::Train, Split::Test].map(load);
    assert_eq!(summary["steps"], steps.iter().map(Vec::len).sum::<usize>());
    let objects = u32::try_from(dataset.items().len()).unwrap();
    for step in steps.iter().flatten() {
        let drawn = draw(5, step.sequence, 3, objects);
        let mut held = step.candidates.iter();
        assert!(held.all(|held| drawn.objects.contains(&held.object)));
        assert!(step.candidates.len() <= 2 && step.heightmap.len() == 32 * 32);
        let mut held = step.candidates.iter();
        assert!(held.any(|held| held.best().next().is_some()));
    }
    let [train, _] = steps;
    let first = train[0].candidates.iter();
    let first: Vec<u32> = first.map(|held| held.object).collect();
    assert!(draw(5, 0, 3, objects).objects.starts_with(&first));
}

#[test]
fn folders_and_sequences_that_must_not_be_used_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("data");
    let refused = |words: &str, parts: &[&str]| is_refused(&ppnpack(&out, words), parts);
    assert!(ppnpack(&out, "--sequences 1").status.success());
    let seed = "seed is 0 there, 1 is asked for";
    let parts = ["other settings", seed, "has_values is false there"];
    refused("--sequences 1 --seed 1 --values", &parts);
    let objects = u32::try_from(Dataset::open(&out).unwrap().items().len()).unwrap();

    // The file's sequences are longer than those that are drawn.
    let file = folder.path().join("test.npy");
    let mut known = draw(0, 3, 3, objects).objects;
    known.push(0);
    let row = known.into_iter().map(i64::from).collect();
    let rows = ndarray::Array2::from_shape_vec((1, 4), row).unwrap();
    ndarray_npy::write_npy(&file, &rows).unwrap();
    let never = format!("--never {}", file.display());
    let parts = ["sequence 3 is sequence 0 of", "choose another seed"];
    refused(&format!("--sequences 4 {never}"), &parts);
    let drawn = ppnpack(&out, &format!("--sequences 3 {never}"));
    assert!(drawn.status.success());
    refused("--never /nowhere.npy", &["/nowhere.npy"]);
    std::fs::write(out.join("settings.json"), b"{").unwrap();
    refused("--sequences 3", &["settings.json is damaged"]);
}
