//! Catalogues, exit codes, and one clear line for every bad input.

use std::path::Path;

use serde_json::Value;

use crate::cube::cube_ply;
use crate::support::{alone, fails, has, json, packed, ppnpack, refused, text};

#[test]
fn without_the_experiments_the_remedy_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for words in ["experiment --help", "dataset --length 3", "train"] {
        let output = alone(&folder, words);
        fails(&output, 1, &["cargo build --bin ppnpack-experiments"]);
    }
    let help = text(&ppnpack("--help"));
    has(&help, &["experiment", "dataset"]);
}

#[test]
fn wrong_options_are_refused() {
    for (words, parts) in [
        (
            "pack --proposals random:0",
            &["0", "above 0 and at most 100"][..],
        ),
        ("pack --proposals network:101", &["101"]),
        ("pack --proposals random:nan", &["NaN"]),
        (
            "pack --proposals all:5",
            &["bounded, all, random and network"],
        ),
        (
            "pack --proposals most",
            &["bounded, all, random and network"],
        ),
        ("pack --container 32x32x-30cm", &["--container", "above 0"]),
        ("pack --container 32x32", &["three lengths"]),
        ("pack --container 32x32x30", &["did you mean 32x32x30cm?"]),
        ("pack --cell 0", &["--cell", "above 0"]),
        ("pack --cell 1m", &["cell"]),
        ("pack --cell 1um", &["'um' is no unit"]),
        ("pack --yaws 0", &["yaws"]),
        ("pack --buffer 0", &["--buffer"]),
        ("pack --set-aside -1", &["-1"]),
        ("pack --poses 0", &["--poses"]),
        ("pack --poses 7", &["--poses"]),
        ("up --poses 7", &["--poses"]),
        ("up --view middles", &["--view middles"]),
        (
            "pack --view /nowhere.toml",
            &["--view", "exact, middles and camera"],
        ),
        (
            "pack --items unobtainium",
            &["unobtainium", "catalogue list"],
        ),
        (
            "pack --physics /nowhere.json",
            &["--physics", "/nowhere.json"],
        ),
        (
            "record --out out --without clouds",
            &["--without", "cloud, "],
        ),
        ("sort", &["sort"]),
    ] {
        refused(words, parts);
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("settings.toml");
    for (option, text, named) in [
        ("physics", "settle_time_s = -1.0", "settling phase"),
        ("physics", "settle_s = 1.0", "settle_s"),
        ("view", "cameras = 3", "camera.cameras"),
        ("view", "camera = 1", "line 1"),
    ] {
        std::fs::write(&file, text).unwrap();
        refused(&format!("pack --{option} {}", file.display()), &[named]);
    }
}

#[test]
fn a_folder_of_meshes_packs() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cube.ply"), cube_ply(&[])).unwrap();
    let catalogue = folder.path().display();
    let summary = packed(&format!("pack --catalogue {catalogue} --random 4")).summary;
    assert_eq!(summary["packed"]["items"], 4);
    let volume = summary["packed"]["meshes_m3"].as_f64().unwrap();
    assert!((volume - 4.0 * 0.05_f64.powi(3)).abs() < 1e-9, "{volume}");
    let list = format!("catalogue list --catalogue {catalogue} --json");
    let listed = json(&ppnpack(&list));
    assert_eq!(listed[0]["name"], "cube");
    for (command, parts) in [
        (
            "list",
            ["cube", "5.0 x 5.0 x 5.0 cm", "125 cm³", "anything"],
        ),
        (
            "check",
            [
                "ok   ",
                "cube.ply: 12 triangles",
                "125 cm³",
                "1 of 1 objects can be packed",
            ],
        ),
    ] {
        let command = format!("catalogue {command} --catalogue {catalogue}");
        let told = text(&ppnpack(&command));
        has(&told, &parts);
    }
}

#[test]
fn broken_meshes_are_refused_by_name_and_reason() {
    let open = "3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n";
    let flat = [
        ("0 0 0.05\n", "0 0 0\n"),
        ("0.05 0 0.05\n", "0.05 0 0\n"),
        ("0.05 0.05 0.05\n", "0.05 0.05 0\n"),
        ("0 0.05 0.05\n", "0 0.05 0\n"),
    ];
    let nan = "v nan 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n";
    for (name, content, reason) in [
        (
            "nan.ply",
            cube_ply(&[("0.05 0 0\n", "nan 0 0\n")]),
            "vertex (number 1) that is not finite",
        ),
        ("nan.obj", nan.to_owned(), "finite"),
        (
            "open.ply",
            cube_ply(&[("element face 12", "element face 7"), (open, "")]),
            "is not closed",
        ),
        ("flat.ply", cube_ply(&flat), "has no thickness"),
        (
            "huge.ply",
            cube_ply(&[("0.05 0.05 0.05\n", "50 50 50\n")]),
            "unit",
        ),
        (
            "cut.ply",
            cube_ply(&[("3 3 0 4\n3 3 4 7\n", "")]),
            "complete",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(name), content).unwrap();
        std::fs::write(folder.path().join("good.ply"), cube_ply(&[])).unwrap();
        let catalogue = folder.path().display();
        let out = folder.path().join("out");
        let pack = format!("pack --catalogue {catalogue} --out {}", out.display());
        refused(&pack, &[name, reason]);
        assert!(!out.exists(), "{name}: nothing is written");
        let check = format!("catalogue check --catalogue {catalogue}");
        refused(&check, &["1 of 2 objects cannot be packed"]);
    }
}

#[test]
fn missing_and_empty_folders_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let empty = folder.path().to_str().unwrap();
    refused("pack --catalogue /nowhere", &["/nowhere", "folder"]);
    refused(&format!("pack --catalogue {empty}"), &[empty, ".ply"]);
    refused(&format!("catalogue check --catalogue {empty}"), &[empty]);
    refused("catalogue show --catalogue /nowhere", &["/nowhere"]);
}

#[test]
fn broken_sequences_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sequences.npy");
    let pack = format!("pack --sequence {}", file.display());
    let write = |last: i64| {
        let rows = ndarray::array![[0_i64, 1, 2], [3, 4, last]];
        ndarray_npy::write_npy(&file, &rows).unwrap();
    };
    write(500);
    refused(&pack, &["sequence 1", "500", "position 2"]);
    write(5);
    refused(&format!("{pack}:2"), &["no sequence 2", "0 to 1"]);
    let content = std::fs::read(&file).unwrap();
    std::fs::write(&file, &content[..content.len() - 5]).unwrap();
    refused(&pack, &["sequences.npy"]);
    std::fs::write(&file, b"not numpy").unwrap();
    refused(&pack, &["sequences.npy"]);
    refused("pack --sequence /nowhere.npy", &["/nowhere.npy"]);
}

#[test]
fn a_sequence_of_a_file_is_packed_by_its_number() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sequences.npy");
    let rows = ndarray::array![[0_i64, 1, 2], [3, 4, 5]];
    ndarray_npy::write_npy(&file, &rows).unwrap();
    let grid = "--cell 1cm --yaws 4 --tries 0";
    let pack = format!("pack {grid} --sequence {}", file.display());
    let objects = |number: &str| -> Value {
        let summary = packed(&format!("{pack}{number}")).summary;
        summary["settings"]["sequence"]["objects"].clone()
    };
    assert_eq!(objects(""), serde_json::json!([0, 1, 2]));
    assert_eq!(objects(":1"), serde_json::json!([3, 4, 5]));
}

#[test]
fn a_full_disk_fails_and_leaves_nothing_that_looks_whole() {
    // /dev/full refuses every write; a folder cannot be made below it either.
    if !Path::new("/dev/full").exists() {
        eprintln!("skipped: there is no /dev/full");
        return;
    }
    let output = ppnpack("pack --random 2 --out /dev/full/out");
    fails(&output, 1, &["/dev/full/out cannot be written"]);
}

#[test]
fn the_poses_of_objects_are_listed_with_their_numbers() {
    let folder = tempfile::tempdir().unwrap();
    // 5 x 5 x 2 cm.
    let slab = cube_ply(&[
        ("0 0 0.05\n", "0 0 0.02\n"),
        ("0.05 0 0.05\n", "0.05 0 0.02\n"),
        ("0.05 0.05 0.05\n", "0.05 0.05 0.02\n"),
        ("0 0.05 0.05\n", "0 0.05 0.02\n"),
    ]);
    std::fs::write(folder.path().join("slab.ply"), slab).unwrap();
    let catalogue = folder.path().display();
    let list = format!("catalogue list --poses 4 --catalogue {catalogue}");
    let listed = json(&ppnpack(&format!("{list} --json")));
    let poses = &listed[0]["poses"];
    let (flat, upright) = (&poses[0], &poses[1]);
    assert_eq!(poses.as_array().unwrap().len(), 2, "{listed}");
    let numbers = (flat["pose"].as_u64(), upright["pose"].as_u64());
    assert_eq!(numbers, (Some(0), Some(1)));
    assert_eq!(flat["up"].to_string(), "[0.0,0.0,1.0]");
    assert!(flat["probability"].as_f64() > upright["probability"].as_f64());
    assert!((upright["extents_m"][2].as_f64().unwrap() - 0.05).abs() < 1e-9);
    let table = text(&ppnpack(&list));
    has(&table, &["Probability", "0.00 0.00 1.00"]);
}

#[test]
fn the_builtin_catalogue_is_whole_and_can_be_shown() {
    let folder = tempfile::tempdir().unwrap();
    let sheet = folder.path().join("sheet.png");
    let show = format!("catalogue show --tile 48 --out {}", sheet.display());
    text(&ppnpack(&show));
    assert!(std::fs::read(&sheet).unwrap().starts_with(b"\x89PNG"));
    let checked = json(&ppnpack("catalogue check --json"));
    let checked = checked.as_array().unwrap();
    assert!(checked.len() >= 90 && checked.iter().all(|object| object["ok"] == true));
}
