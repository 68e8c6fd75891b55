//! Point cloud files to heightmaps, as a user runs it.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a failing test")]

use std::path::PathBuf;

use serde_json::Value;

mod command;

use command::{ppnpack, refused};

fn json(arguments: &[&str]) -> Value {
    command::json(&ppnpack(&[arguments, &["--json"]].concat()))
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn name(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().to_owned()
    }

    /// Writes an ASCII cloud.
    fn cloud(&self, name: &str, points: &[[f64; 3]]) -> String {
        let header = format!(
            "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH {}\nHEIGHT 1\nDATA ascii\n",
            points.len()
        );
        let lines = points.iter().map(|[x, y, z]| format!("{x} {y} {z}\n"));
        std::fs::write(self.path(name), header + &lines.collect::<String>()).unwrap();
        self.name(name)
    }
}

#[test]
fn the_example_is_calibrated_and_perceived() {
    let folder = Folder::new();
    let output = ppnpack(&["perceive", "--example", &folder.name("example")]);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let advice = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        advice.contains("ppnpack calibrate") && advice.contains("ppnpack perceive"),
        "{advice}"
    );

    let (empty, packed) = (
        folder.name("example/empty.pcd"),
        folder.name("example/packed.pcd"),
    );
    let (calibration, out) = (folder.name("calibration.toml"), folder.name("out"));
    let found = json(&["calibrate", &empty, "--out", &calibration]);
    for (side, length_m) in [("x_m", 0.32), ("y_m", 0.32), ("z_m", 0.30)] {
        let measured_m = found["measured_container"][side].as_f64().unwrap();
        assert!((measured_m - length_m).abs() < 0.0005, "{found}");
        assert_eq!(found["container"][side], length_m, "in whole millimetres");
    }
    // The camera is tilted: it may look past a wall.
    let walls_seen = found["residuals"]["walls_seen"].as_u64();
    assert!(walls_seen >= Some(3), "{found}");

    // What the advice says works, word for word.
    let line = advice
        .lines()
        .find(|line| line.contains("ppnpack perceive"))
        .unwrap();
    let arguments: Vec<String> = line
        .split_whitespace()
        .skip(1)
        .map(|word| {
            if word.ends_with("calibration.toml") {
                calibration.clone()
            } else {
                word.to_owned()
            }
        })
        .collect();
    let mut arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    arguments.extend(["--out", &out]);
    let seen = json(&arguments);
    assert_eq!(seen["clouds"][0]["path"], packed);
    assert_eq!(seen["clouds"][0]["height"], 480);
    assert!(seen["points_inside"].as_u64().unwrap() > 20_000, "{seen}");
    assert_eq!(seen["cells"], 32 * 32);
    let greatest_m = seen["greatest_height_m"].as_f64().unwrap();
    assert!((0.02..0.28).contains(&greatest_m), "{seen}");
    let unknown = seen["unknown_cells"].as_f64().unwrap() / seen["cells"].as_f64().unwrap();
    assert!(unknown < 0.35, "{seen}");
    assert_eq!(seen["doubts"].as_array().unwrap().len(), 0, "{seen}");

    // A container that is not where the calibration says is doubted.
    let moved = folder.path("moved.toml");
    let file = std::fs::read_to_string(folder.path("calibration.toml")).unwrap();
    let (before, pose) = file.split_once("position_m = [").unwrap();
    let (x_m, after) = pose.split_once(',').unwrap();
    let x_m: f64 = x_m.trim().parse().unwrap();
    let file = format!("{before}position_m = [{},{after}", x_m + 0.03);
    std::fs::write(&moved, file).unwrap();
    let moved = moved.to_str().unwrap();
    let doubtful = arguments
        .iter()
        .map(|word| if *word == calibration { moved } else { word });
    let doubtful: Vec<&str> = doubtful.collect();
    let doubts = json(&doubtful)["doubts"].to_string();
    assert!(doubts.contains("the top of the wall at x = 0"), "{doubts}");

    let mut names: Vec<_> = folder
        .path("out")
        .read_dir()
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["heightmap.png", "summary.json", "surface.png"]);

    // With its size known, and for people.
    let output = ppnpack(&[
        "calibrate",
        &empty,
        "--container",
        "32x32x30cm",
        "--out",
        &calibration,
    ]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        text.contains("Inner size") && text.contains("of 4 seen"),
        "{text}"
    );
    let file = std::fs::read_to_string(folder.path("calibration.toml")).unwrap();
    assert!(
        file.contains("container = { x_m = 0.32, y_m = 0.32, z_m = 0.3 }"),
        "{file}"
    );

    // The container that is not empty is no calibration.
    refused(
        &["calibrate", &packed, "--out", &calibration],
        &["packed.pcd", "not empty"],
    );
    refused(
        &[
            "calibrate",
            &empty,
            "--container",
            "32x32x20cm",
            "--out",
            &calibration,
        ],
        &["z side"],
    );
}

#[test]
fn a_cloud_in_the_container_s_frame_needs_no_options() {
    let folder = Folder::new();
    let cloud = folder.cloud(
        "cloud.pcd",
        &[[0.105, 0.105, 0.05], [0.205, 0.105, 0.1], [0.5, 0.5, 0.0]],
    );
    let out = folder.name("out");
    let seen = json(&["perceive", &cloud, "--out", &out]);
    assert_eq!(seen["points_measured"], 3);
    assert_eq!(seen["points_inside"], 2);
    assert_eq!(seen["unknown_cells"], 32 * 32 - 2);
    assert_eq!(seen["greatest_height_m"], 0.1);
    let output = ppnpack(&["perceive", &cloud, "--out", &out]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        text.contains("1022 of 1024") && text.contains("heightmap.png"),
        "{text}"
    );
    assert!(text.contains("only 2 of 1024 cells are seen"), "{text}");
}

#[test]
fn clouds_of_several_sensors_make_one_map() {
    let folder = Folder::new();
    // More than a cell of points, a millimetre apart.
    let patch = |x_m: f64, y_m: f64, z_m: f64| -> Vec<[f64; 3]> {
        let along = |from_m: f64| (0..14).map(move |step| from_m + 0.001 * f64::from(step));
        let rows = along(x_m).flat_map(|x_m| along(y_m).map(move |y_m| [x_m, y_m, z_m]));
        rows.collect()
    };
    let one = folder.cloud("one.pcd", &patch(0.0985, 0.0985, 0.05));
    // Upside down, a metre above a corner.
    let two = folder.cloud("two.pcd", &patch(0.1985, -0.1115, 0.901));
    let out = folder.name("out");
    let seen = json(&[
        "perceive",
        &one,
        &two,
        "--container-from-sensor",
        "0,0,0,0,0,0,1",
        "--container-from-sensor",
        "0,0,1,1,0,0,0",
        "--out",
        &out,
    ]);
    assert_eq!(seen["points_inside"], 2 * 14 * 14);
    assert_eq!(seen["greatest_height_m"], 0.1);
    let twice = [
        "perceive",
        &one,
        &two,
        "--container-from-sensor",
        "0,0,1,1,0,0,0",
    ];
    refused(&twice, &["1 times for 2 clouds"]);
}

#[test]
fn wrong_input_is_refused() {
    let folder = Folder::new();
    let cloud = folder.cloud("cloud.pcd", &[[0.105, 0.105, 0.05]]);
    let (out, missing) = (folder.name("out"), folder.name("missing.pcd"));
    std::fs::write(folder.path("broken.ply"), "ply\nformat ascii 1.0\n").unwrap();
    std::fs::write(folder.path("broken.toml"), "container_from_sensor = 1\n").unwrap();
    std::fs::write(folder.path("no.toml"), "x = \n").unwrap();
    let (ply, toml, no) = (
        folder.name("broken.ply"),
        folder.name("broken.toml"),
        folder.name("no.toml"),
    );
    refused(&["perceive"], &["CLOUD"]);
    refused(
        &["perceive", &missing, "--out", &out],
        &["missing.pcd cannot be read"],
    );
    refused(&["perceive", &ply, "--out", &out], &["broken.ply", "PLY"]);
    refused(
        &["calibrate", &missing, "--out", &out],
        &["missing.pcd cannot be read"],
    );
    refused(
        &["calibrate", &cloud, "--out", &out],
        &["cloud.pcd", "1 measured points"],
    );
    let posed = |pose: &str, parts: &[&str]| {
        refused(
            &[
                "perceive",
                &cloud,
                "--out",
                &out,
                "--container-from-sensor",
                pose,
            ],
            parts,
        );
    };
    posed("1,2,3", &["seven numbers"]);
    posed("0,0,0,0,0,0,3", &["unit quaternion"]);
    posed("nowhere.toml", &["nowhere.toml is no calibration file"]);
    posed(&toml, &["broken.toml is no calibration file"]);
    posed(&no, &["no.toml is no calibration file"]);
    refused(
        &["perceive", &cloud, "--out", &out, "--noise", "2m"],
        &["noise_m"],
    );
    refused(
        &["perceive", &cloud, "--out", &out, "--cell", "1m"],
        &["cell"],
    );
    refused(
        &["perceive", &cloud, "--out", &out, "--point-radius", "1cm"],
        &["point_radius_m"],
    );
    assert!(!folder.path("out").exists(), "nothing is written");
}

/// Points on the upper side of a box on a table, and on the table around it, 2 mm apart.
fn box_on_a_table(sides_m: [f64; 3]) -> Vec<[f64; 3]> {
    let steps = |half_m: f64| {
        let count = (half_m / 0.002).round() as i32;
        (-count..=count).map(|step| f64::from(step) * 0.002)
    };
    let [x_m, y_m, z_m] = sides_m;
    let table = steps(0.15).flat_map(|x| steps(0.15).map(move |y| (x, y)));
    table
        .map(|(x, y)| {
            let is_on_box = x.abs() <= x_m / 2.0 && y.abs() <= y_m / 2.0;
            [x, y, if is_on_box { z_m } else { 0.0 }]
        })
        .collect()
}

#[test]
fn what_lies_in_a_cloud_is_recognised_or_called_unknown() {
    let folder = Folder::new();
    let meshes = folder.path("meshes");
    std::fs::create_dir(&meshes).unwrap();
    // A box of 10 x 6 x 4 cm, as a mesh that stands on its end.
    let mut text = String::new();
    for corner in 0..8 {
        let at = |axis: usize, side: f64| side * (f64::from(corner >> axis & 1) - 0.5);
        text += &format!("v {} {} {}\n", at(0, 0.04), at(1, 0.06), at(2, 0.10));
    }
    text += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    std::fs::write(meshes.join("box.obj"), text).unwrap();
    let meshes = meshes.to_str().unwrap();
    let pose = "0,0,0.9,1,0,0,0";
    let recognised = |name: &str, sides_m: [f64; 3]| {
        // As seen from 90 cm above, looking down.
        let seen = box_on_a_table(sides_m);
        let seen: Vec<[f64; 3]> = seen.iter().map(|[x, y, z]| [*x, -y, 0.9 - z]).collect();
        let cloud = folder.cloud(name, &seen);
        json(&[
            "recognise",
            &cloud,
            "--catalogue",
            meshes,
            "--container-from-sensor",
            pose,
        ])
    };
    let known = recognised("known.pcd", [0.10, 0.06, 0.04]);
    let items = known["items"].as_array().unwrap();
    assert_eq!(items.len(), 1, "{known}");
    assert_eq!(items[0]["object"], "box", "{known}");
    let position = items[0]["pose"]["position_m"].as_array().unwrap();
    let position: Vec<f64> = position
        .iter()
        .map(|value| value.as_f64().unwrap())
        .collect();
    assert!(
        position[0].abs() < 0.003 && position[1].abs() < 0.003,
        "{position:?}"
    );
    assert!((position[2] - 0.02).abs() < 0.003, "{position:?}");

    let other = recognised("other.pcd", [0.16, 0.12, 0.09]);
    assert_eq!(other["items"][0]["object"], Value::Null, "{other}");
    assert!(other["items"][0]["unknown"].is_string());

    let cloud = folder.name("known.pcd");
    let arguments = [
        "recognise",
        &cloud,
        "--catalogue",
        meshes,
        "--region",
        "0,0,0,1,1,0",
    ];
    refused(&arguments, &["second corner"]);
    let missing = folder.name("missing.pcd");
    refused(
        &["recognise", &missing, "--catalogue", meshes],
        &["missing.pcd"],
    );
}
