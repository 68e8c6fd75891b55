//! Point cloud files to heightmaps, poses and objects.

use std::path::PathBuf;

use ppnpack_clouds::{Cloud, to_pcd};
use serde_json::Value;
use tempfile::TempDir;

use crate::support::{self, has, names, ppnpack, refused, text};

fn json(words: &str) -> Value {
    support::json(&ppnpack(&format!("{words} --json")))
}

struct Folder(TempDir);

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

    /// Writes a file, and gives its name.
    fn file(&self, name: &str, content: &str) -> String {
        std::fs::write(self.path(name), content).unwrap();
        self.name(name)
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    fn cloud(&self, name: &str, points: &[[f64; 3]]) -> String {
        let header = format!(
            "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH {}\nHEIGHT 1\nDATA ascii\n",
            points.len()
        );
        let lines = points.iter().map(|[x, y, z]| format!("{x} {y} {z}\n"));
        self.file(name, &(header + &lines.collect::<String>()))
    }
}

#[test]
fn the_example_is_calibrated_and_perceived() {
    let folder = Folder::new();
    let example = folder.name("example");
    let advice = text(&ppnpack(&format!("perceive --example {example}")));
    let line = |of: &str| {
        let line = advice.lines().find(|line| line.contains(of)).unwrap();
        line.trim().strip_prefix("ppnpack ").unwrap()
    };
    let [empty, packed] = ["empty", "packed"].map(|of| folder.name(&format!("example/{of}.pcd")));
    // The advice works word for word.
    let found = json(line("ppnpack calibrate"));
    for (side, length_m) in [("x_m", 0.32), ("y_m", 0.32), ("z_m", 0.30)] {
        let measured_m = found["measured_container"][side].as_f64().unwrap();
        assert!((measured_m - length_m).abs() < 0.0005, "{found}");
        assert_eq!(found["container"][side], length_m, "in whole millimetres");
    }
    // The camera is tilted: it may look past a wall.
    let walls_seen = found["residuals"]["walls_seen"].as_u64();
    assert!(walls_seen >= Some(3), "{found}");

    let perceive = format!("{} --out {}", line("ppnpack perceive"), folder.name("out"));
    let seen = json(&perceive);
    assert_eq!(seen["clouds"][0]["path"], packed);
    assert_eq!(seen["clouds"][0]["height"], 480);
    assert!(seen["points_inside"].as_u64().unwrap() > 20_000, "{seen}");
    assert_eq!(seen["cells"], 32 * 32);
    let greatest_m = seen["greatest_height_m"].as_f64().unwrap();
    assert!((0.02..0.28).contains(&greatest_m), "{seen}");
    let unknown = seen["unknown_cells"].as_f64().unwrap() / seen["cells"].as_f64().unwrap();
    assert!(unknown < 0.35, "{seen}");
    assert_eq!(seen["doubts"].as_array().unwrap().len(), 0, "{seen}");
    let pictures = ["heightmap.png", "summary.json", "surface.png"];
    assert_eq!(names(&folder.path("out")), pictures);

    // A container that is not where the calibration says is doubted.
    let file = folder.read("example/calibration.toml");
    let (before, pose) = file.split_once("position_m = [").unwrap();
    let (x_m, after) = pose.split_once(',').unwrap();
    let x_m = x_m.parse::<f64>().unwrap() + 0.03;
    let moved = format!("{before}position_m = [{x_m},{after}");
    folder.file("example/calibration.toml", &moved);
    let doubts = json(&perceive)["doubts"].to_string();
    has(&doubts, &["the top of the wall at x = 0"]);

    // With its size known, and for people.
    let calibrate = format!("calibrate {empty} --out {}", folder.name("known.toml"));
    let told = text(&ppnpack(&format!("{calibrate} --container 32x32x30cm")));
    has(&told, &["Measured: 32.0 x 32.0 x ", "walls_seen = "]);
    let file = folder.read("known.toml");
    let parts = ["container = { x_m = 0.32, y_m = 0.32, z_m = 0.3 }"];
    has(&file, &parts);

    // A container that is not empty, of another size or that fits too badly is no calibration.
    let out = folder.name("refused.toml");
    refused(
        &format!("calibrate {packed} --out {out}"),
        &["packed.pcd", "not empty"],
    );
    let calibrate = format!("calibrate {empty} --out {out}");
    refused(&format!("{calibrate} --container 32x32x20cm"), &["z side"]);
    let limits = folder.file("limits.toml", "largest_rms_m = 1e-6");
    refused(&format!("{calibrate} --limits {limits}"), &["empty.pcd"]);
    assert!(!folder.path("refused.toml").exists());
}

#[test]
fn millimetres_are_read_by_their_unit_and_named_without_and_zeros_at_the_lens_are_holes() {
    let folder = Folder::new();
    let example = folder.name("example");
    text(&ppnpack(&format!("perceive --example {example}")));
    // The same cloud as cameras of the industry and as many drivers write it.
    let rewritten = |name: &str, file: &str, rewrite: fn(Cloud) -> Vec<u8>| {
        let cloud = ppnpack_clouds::read(&folder.path(name)).unwrap();
        std::fs::write(folder.path(file), rewrite(cloud)).unwrap();
        folder.name(file)
    };
    let millimetres = |cloud: Cloud| to_pcd(&cloud.in_units_of(1000.0));
    let empty = rewritten("example/empty.pcd", "empty.pcd", millimetres);
    let packed = rewritten("example/packed.pcd", "packed.pcd", millimetres);
    let zeros = rewritten("example/packed.pcd", "zeros.pcd", |cloud| {
        let mut bytes = to_pcd(&cloud);
        let body = bytes.len() - 12 * cloud.points_m().len();
        let points = bytes[body..].chunks_exact_mut(12);
        for (bytes, point) in points.zip(cloud.points_m()) {
            if point.x.is_nan() {
                bytes.fill(0);
            }
        }
        bytes
    });
    let out = folder.name("calibration.toml");
    let calibrate = |cloud: &str| format!("calibrate {cloud} --out {out}");
    let found = json(&calibrate(&format!("{example}/empty.pcd")))["container"].clone();
    assert_eq!(
        json(&format!("{} --unit mm", calibrate(&empty)))["container"],
        found
    );
    let mapper = format!("--container-from-sensor {out} --mapper {example}/mapper.toml");
    let perceive = |cloud: &str| format!("perceive {cloud} {mapper} --out {}", folder.name("out"));
    let seen = |words: &str| {
        let mut seen = json(words);
        for other in ["clouds", "took_s"] {
            seen.as_object_mut().unwrap().remove(other);
        }
        seen
    };
    let usual = seen(&perceive(&format!("{example}/packed.pcd")));
    assert_eq!(usual["doubts"], serde_json::json!([]), "{usual}");
    assert_eq!(seen(&perceive(&zeros)), usual);
    let scaled = seen(&format!("{} --unit mm", perceive(&packed)));
    assert_eq!(scaled["greatest_height_m"], usual["greatest_height_m"]);
    assert_eq!(scaled["doubts"], usual["doubts"]);
    for command in [calibrate(&empty), perceive(&packed)] {
        refused(&command, &["m from the sensor in the median", "--unit mm"]);
    }
    let recognise = format!("recognise {packed}");
    refused(&recognise, &["packed.pcd", "--cloud-unit mm"]);
}

#[test]
fn a_cloud_in_the_container_s_frame_needs_no_options() {
    let folder = Folder::new();
    let points = [[0.105, 0.105, 0.05], [0.205, 0.105, 0.1], [0.5, 0.5, 0.0]];
    let cloud = folder.cloud("cloud.pcd", &points);
    let perceive = format!("perceive {cloud} --out {}", folder.name("out"));
    let seen = json(&perceive);
    assert_eq!(seen["points_measured"], 3);
    assert_eq!(seen["points_inside"], 2);
    assert_eq!(seen["unknown_cells"], 32 * 32 - 2);
    assert_eq!(seen["greatest_height_m"], 0.1);
    let told = text(&ppnpack(&perceive));
    let parts = [
        "1022 of 1024",
        "heightmap.png",
        "only 2 of 1024 cells are seen",
    ];
    has(&told, &parts);
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
    let above = "--container-from-sensor 0,0,1,1,0,0,0";
    let perceive = format!("perceive {one} {two} --out {}", folder.name("out"));
    let seen = json(&format!(
        "{perceive} --container-from-sensor 0,0,0,0,0,0,1 {above}"
    ));
    assert_eq!(seen["points_inside"], 2 * 14 * 14);
    assert_eq!(seen["greatest_height_m"], 0.1);
    refused(&format!("{perceive} {above}"), &["1 times for 2 clouds"]);
}

#[test]
fn wrong_input_is_refused() {
    let folder = Folder::new();
    let cloud = folder.cloud("cloud.pcd", &[[0.105, 0.105, 0.05]]);
    let (out, missing) = (folder.name("out"), folder.name("missing.pcd"));
    let ply = folder.file("broken.ply", "ply\nformat ascii 1.0\n");
    let toml = folder.file("broken.toml", "container_from_sensor = 1\n");
    let no = folder.file("no.toml", "x = \n");
    refused("perceive", &["CLOUD"]);
    let perceive =
        |options: &str, parts: &[&str]| refused(&format!("perceive {options} --out {out}"), parts);
    perceive(&missing, &["missing.pcd cannot be read"]);
    perceive(&ply, &["broken.ply", "PLY"]);
    let calibrate = format!("calibrate {missing} --out {out}");
    refused(&calibrate, &["missing.pcd cannot be read"]);
    let parts = ["cloud.pcd", "1 measured points"];
    refused(&format!("calibrate {cloud} --out {out}"), &parts);
    for (pose, part) in [
        ("1,2,3", "seven numbers"),
        ("0,0,0,0,0,0,3", "unit quaternion"),
        ("nowhere.toml", "nowhere.toml is no calibration file"),
        (toml.as_str(), "broken.toml is no calibration file"),
        (no.as_str(), "no.toml is no calibration file"),
    ] {
        perceive(&format!("{cloud} --container-from-sensor {pose}"), &[part]);
    }
    for (settings, part) in [
        ("noise_m = 2.0", "noise_m"),
        ("point_radius_m = 0.01", "point_radius_m"),
        ("radius_m = 0.01", "radius_m"),
    ] {
        let mapper = folder.file("mapper.toml", settings);
        perceive(&format!("{cloud} --mapper {mapper}"), &[part]);
    }
    perceive(&format!("{cloud} --cell 1m"), &["cell"]);
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
    std::fs::create_dir(folder.path("meshes")).unwrap();
    // A box of 10 x 6 x 4 cm, as a mesh that stands on its end.
    let mut mesh = String::new();
    for corner in 0..8 {
        let at = |axis: usize, side: f64| side * (f64::from(corner >> axis & 1) - 0.5);
        mesh += &format!("v {} {} {}\n", at(0, 0.04), at(1, 0.06), at(2, 0.10));
    }
    mesh += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    folder.file("meshes/box.obj", &mesh);
    let catalogue = format!("--catalogue {}", folder.name("meshes"));
    let from_above = "--container-from-sensor 0,0,0.9,1,0,0,0";
    let recognised = |name: &str, sides_m: [f64; 3]| {
        // As seen from 90 cm above, looking down.
        let seen = box_on_a_table(sides_m);
        let seen: Vec<[f64; 3]> = seen.iter().map(|[x, y, z]| [*x, -y, 0.9 - z]).collect();
        let cloud = folder.cloud(name, &seen);
        json(&format!("recognise {cloud} {catalogue} {from_above}"))
    };
    let known = recognised("known.pcd", [0.10, 0.06, 0.04]);
    let items = known["items"].as_array().unwrap();
    assert_eq!(items.len(), 1, "{known}");
    assert_eq!(items[0]["object"], "box", "{known}");
    for (axis, at_m) in [0.0, 0.0, 0.02].into_iter().enumerate() {
        let found_m = items[0]["pose"]["position_m"][axis].as_f64().unwrap();
        assert!((found_m - at_m).abs() < 0.003, "{known}");
    }

    let cloud = folder.name("known.pcd");
    let told = text(&ppnpack(&format!(
        "recognise {cloud} {catalogue} {from_above}"
    )));
    has(&told, &["position (cm)", "box", "1 items and "]);

    let other = recognised("other.pcd", [0.16, 0.12, 0.09]);
    assert_eq!(other["items"][0]["object"], Value::Null, "{other}");
    assert!(other["items"][0]["unknown"].is_string());
    let flat = format!("recognise {cloud} {catalogue} --region 0,0,0,1,1,0");
    refused(&flat, &["second corner"]);
    let missing = format!("recognise {} {catalogue}", folder.name("missing.pcd"));
    refused(&missing, &["missing.pcd"]);
}
