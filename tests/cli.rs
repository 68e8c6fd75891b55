//! The command end to end: catalogues, exit codes, and one clear line for every bad input.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::path::Path;
use std::process::Command;

mod command;
mod cube;

use command::{json, ppnpack, refused};
use cube::cube_ply;

#[test]
fn without_the_experiments_the_remedy_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let alone = folder.path().join("ppnpack");
    std::fs::copy(env!("CARGO_BIN_EXE_ppnpack"), &alone).unwrap();
    for arguments in [
        &["experiment", "--help"][..],
        &["dataset", "--length", "3"],
        &["train"],
    ] {
        let output = Command::new(&alone).args(arguments).output().unwrap();
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{error}");
        let remedy = "cargo build --release --bin ppnpack-experiments";
        assert!(error.contains(remedy), "{error}");
    }
    let help = String::from_utf8(ppnpack(&["--help"]).stdout).unwrap();
    assert!(help.contains("experiment") && help.contains("dataset"));
}

#[test]
fn wrong_options_are_refused() {
    refused(&["pack", "--k", "0"], &["0", "above 0 and at most 100"]);
    refused(&["pack", "--k", "101"], &["101"]);
    refused(&["pack", "--k", "nan"], &["NaN"]);
    refused(
        &["pack", "--container", "32x32x-30cm"],
        &["--container", "above 0"],
    );
    refused(&["pack", "--container", "32x32"], &["three lengths"]);
    refused(&["pack", "--cell", "0"], &["--cell", "above 0"]);
    refused(&["pack", "--cell", "1m"], &["cell"]);
    refused(&["pack", "--cell", "1um"], &["'um' is no unit"]);
    refused(&["pack", "--yaws", "0"], &["yaws"]);
    refused(&["pack", "--buffer", "0"], &["--buffer"]);
    refused(&["pack", "--set-aside", "-1"], &["-1"]);
    refused(&["pack", "--poses", "0"], &["--poses"]);
    refused(&["pack", "--poses", "7"], &["--poses"]);
    refused(&["up", "--poses", "7"], &["--poses"]);
    refused(&["pack", "--turn-time", "4"], &["--turn-time", "no unit"]);
    refused(
        &["pack", "--items", "unobtainium"],
        &["unobtainium", "catalogue list"],
    );
    refused(&["pack", "--settle", "-1"], &["--settle"]);
    refused(
        &["pack", "--physics", "/nowhere.json"],
        &["--physics /nowhere.json"],
    );
    refused(&["sort"], &["sort"]);
}

#[test]
fn a_folder_of_meshes_packs() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cube.ply"), cube_ply(&[])).unwrap();
    let catalogue = folder.path().to_str().unwrap();
    let out = folder.path().join("out");
    let out = out.to_str().unwrap();
    let arguments = [
        "pack",
        "--catalogue",
        catalogue,
        "--random",
        "4",
        "--json",
        "--out",
        out,
    ];
    let summary = json(&ppnpack(&arguments));
    assert_eq!(summary["packed"]["items"], 4);
    let volume = summary["packed"]["meshes_m3"].as_f64().unwrap();
    assert!((volume - 4.0 * 0.05_f64.powi(3)).abs() < 1e-9, "{volume}");
    let listed = json(&ppnpack(&[
        "catalogue",
        "list",
        "--catalogue",
        catalogue,
        "--json",
    ]));
    assert_eq!(listed[0]["name"], "cube");
}

#[test]
fn broken_meshes_are_refused_by_name_and_reason() {
    let broken: [(&str, String, &str); 6] = [
        (
            "nan.ply",
            cube_ply(&[("0.05 0 0\n", "nan 0 0\n")]),
            "nan 0 0",
        ),
        (
            "nan.obj",
            "v nan 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n".to_owned(),
            "finite",
        ),
        (
            "open.ply",
            cube_ply(&[
                ("element face 12", "element face 7"),
                ("3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n", ""),
            ]),
            "is not closed",
        ),
        (
            "flat.ply",
            cube_ply(&[
                ("0 0 0.05\n", "0 0 0\n"),
                ("0.05 0 0.05\n", "0.05 0 0\n"),
                ("0.05 0.05 0.05\n", "0.05 0.05 0\n"),
                ("0 0.05 0.05\n", "0 0.05 0\n"),
            ]),
            "has no thickness",
        ),
        (
            "huge.ply",
            cube_ply(&[("0.05 0.05 0.05\n", "50 50 50\n")]),
            "unit",
        ),
        (
            "cut.ply",
            cube_ply(&[("3 3 0 4\n3 3 4 7\n", "")]),
            "Unexpected end of file",
        ),
    ];
    for (name, content, reason) in broken {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(name), content).unwrap();
        std::fs::write(folder.path().join("good.ply"), cube_ply(&[])).unwrap();
        let catalogue = folder.path().to_str().unwrap();
        let out = folder.path().join("out");
        let arguments = [
            "pack",
            "--catalogue",
            catalogue,
            "--out",
            out.to_str().unwrap(),
        ];
        refused(&arguments, &[name, reason]);
        assert!(!out.exists(), "{name}: nothing is written");
        refused(
            &["catalogue", "check", "--catalogue", catalogue],
            &["1 of 2 objects cannot be packed"],
        );
    }
}

#[test]
fn missing_and_empty_folders_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let empty = folder.path().to_str().unwrap();
    refused(
        &["pack", "--catalogue", "/nowhere"],
        &["/nowhere", "folder"],
    );
    refused(&["pack", "--catalogue", empty], &[empty, ".ply"]);
    refused(&["catalogue", "check", "--catalogue", empty], &[empty]);
    refused(
        &["catalogue", "show", "--catalogue", "/nowhere"],
        &["/nowhere"],
    );
}

#[test]
fn broken_sequences_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sequences.npy");
    let path = file.to_str().unwrap();
    let rows = ndarray::array![[0_i64, 1, 2], [3, 4, 500]];
    ndarray_npy::write_npy(&file, &rows).unwrap();
    refused(
        &["pack", "--sequence", path],
        &["sequence 1", "500", "position 2"],
    );
    let rows = ndarray::array![[0_i64, 1, 2], [3, 4, 5]];
    ndarray_npy::write_npy(&file, &rows).unwrap();
    refused(
        &["pack", "--sequence", path, "--index", "2"],
        &["--index 2", "0 to 1"],
    );
    let content = std::fs::read(&file).unwrap();
    std::fs::write(&file, &content[..content.len() - 5]).unwrap();
    refused(&["pack", "--sequence", path], &["sequences.npy"]);
    std::fs::write(&file, b"not numpy").unwrap();
    refused(&["pack", "--sequence", path], &["sequences.npy"]);
    refused(&["pack", "--sequence", "/nowhere.npy"], &["/nowhere.npy"]);
}

#[test]
fn a_full_disk_fails_and_leaves_nothing_that_looks_whole() {
    // /dev/full refuses every write; a folder cannot be made below it either.
    if !Path::new("/dev/full").exists() {
        eprintln!("skipped: there is no /dev/full");
        return;
    }
    let output = ppnpack(&["pack", "--random", "2", "--out", "/dev/full/out"]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.contains("/dev/full/out cannot be written"), "{error}");
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
    let catalogue = folder.path().to_str().unwrap();
    let list = [
        "catalogue",
        "list",
        "--poses",
        "4",
        "--catalogue",
        catalogue,
    ];
    let listed = json(&ppnpack(&[&list[..], &["--json"]].concat()));
    let poses = &listed[0]["poses"];
    let (flat, upright) = (&poses[0], &poses[1]);
    assert_eq!(poses.as_array().unwrap().len(), 2, "{listed}");
    assert_eq!(
        (flat["pose"].as_u64(), upright["pose"].as_u64()),
        (Some(0), Some(1))
    );
    assert_eq!(flat["up"].to_string(), "[0.0,0.0,1.0]");
    assert!(flat["probability"].as_f64() > upright["probability"].as_f64());
    assert!((upright["extents_m"][2].as_f64().unwrap() - 0.05).abs() < 1e-9);
    let table = ppnpack(&list);
    let table = String::from_utf8(table.stdout).unwrap();
    assert!(
        table.contains("Probability") && table.contains("0.00 0.00 1.00"),
        "{table}"
    );
}

#[test]
fn the_builtin_catalogue_is_whole_and_can_be_shown() {
    let folder = tempfile::tempdir().unwrap();
    let sheet = folder.path().join("sheet.png");
    let arguments = [
        "catalogue",
        "show",
        "--tile",
        "48",
        "--out",
        sheet.to_str().unwrap(),
    ];
    assert!(ppnpack(&arguments).status.success());
    assert!(std::fs::read(&sheet).unwrap().starts_with(b"\x89PNG"));
    let checked = json(&ppnpack(&["catalogue", "check", "--json"]));
    let checked = checked.as_array().unwrap();
    assert!(checked.len() >= 90 && checked.iter().all(|object| object["ok"] == true));
}
