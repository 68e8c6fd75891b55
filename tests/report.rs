//! What a packing leaves in its folder: figures, pictures and a page that plays it; and packings compared.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

mod command;
mod cube;

use command::{json, ppnpack, refused};
use cube::cube_ply;

#[test]
fn packing_the_builtin_set_writes_a_whole_report() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("result");
    let arguments = [
        "pack",
        "--random",
        "12",
        "--seed",
        "3",
        "--json",
        "--out",
        out.to_str().unwrap(),
    ];
    let summary = json(&ppnpack(&arguments));
    assert_eq!(summary["items_in_sequence"], 12);
    assert!(
        summary["packed"]["items"].as_u64().unwrap() >= 8,
        "{summary}"
    );
    assert!(summary["floor_compactness"].as_f64().unwrap() > 0.1);
    let mut names: Vec<_> = out
        .read_dir()
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    let files = [
        "heightmap.png",
        "packed.png",
        "placements.csv",
        "report.html",
        "summary.json",
    ];
    assert_eq!(names, files);
    let written: Value =
        serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap();
    assert_eq!(written["packed"], summary["packed"]);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("data:image/png;base64,") && page.contains("<svg"));
    assert!(
        !page.contains("src=\"http") && !page.contains("href=\"http"),
        "the page opens offline"
    );
    let lines = std::fs::read_to_string(out.join("placements.csv"))
        .unwrap()
        .lines()
        .count();
    assert_eq!(lines as u64, summary["items_placed"].as_u64().unwrap() + 1);
    assert!(page.len() < 3_000_000, "{} bytes", page.len());
    let answer = format!("{} of 12 items are packed", summary["packed"]["items"]);
    assert!(page.contains(&answer), "{answer}");
    plays_every_step(&page, lines - 1);
}

/// The data of the page's viewer.
fn playback(page: &str) -> Value {
    let begin = "<script type=\"application/json\" id=playback-data>";
    let (_, data) = page.split_once(begin).unwrap();
    let (data, _) = data.split_once("</script>").unwrap();
    serde_json::from_str(data).unwrap()
}

/// The page's viewer has as many steps, with shapes that can be drawn, where each was planned and what each moved.
fn plays_every_step(page: &str, steps: usize) {
    let playback = playback(page);
    let models = playback["models"].as_array().unwrap();
    for model in models {
        let [vertices, triangles] = ["vertices", "triangles"].map(|of| numbers(&model[of]));
        assert!(vertices.len() >= 12 && vertices.len().is_multiple_of(3));
        assert!(triangles.len().is_multiple_of(3));
        let all_there = |corner: &u16| usize::from(*corner) < vertices.len() / 3;
        assert!(triangles.iter().all(all_there));
        let step_m = model["step_m"].as_f64().unwrap();
        let longest_m = f64::from(*vertices.iter().max().unwrap()) * step_m;
        assert!((0.005..0.6).contains(&longest_m), "{longest_m} m");
    }
    let played = playback["steps"].as_array().unwrap();
    assert_eq!(played.len(), steps);
    assert!(page.contains(&format!("max={0} value={0}", 2 * steps)));
    for (number, step) in played.iter().enumerate() {
        assert!((step["model"].as_u64().unwrap() as usize) < models.len());
        let container_m = &playback["container_m"];
        is_near_the_container(&step["planned"], container_m);
        // What is shown to move was placed then or before.
        for shift in step["shifts"].as_array().unwrap() {
            assert!(shift["item"].as_u64().unwrap() as usize <= number, "{step}");
            is_near_the_container(&shift["pose"], container_m);
        }
    }
    let of_itself = |(number, step): &(usize, &Value)| {
        let mut shifts = step["shifts"].as_array().unwrap().iter();
        shifts.any(|shift| shift["item"] == *number)
    };
    assert!(played.iter().enumerate().filter(of_itself).count() > 0);
}

/// A pose in whole numbers: tenths of millimetres, and ten-thousandths of a unit quaternion.
fn is_near_the_container(pose: &Value, container_m: &Value) {
    let part = |index: usize| pose[index].as_f64().unwrap() * 1e-4;
    let norm: f64 = (3..7).map(|index| part(index).powi(2)).sum();
    assert!((norm - 1.0).abs() < 1e-3, "{pose}");
    // Frames of items may lie outside of them, but not far.
    for axis in 0..3 {
        let end_m = container_m[axis].as_f64().unwrap();
        assert!(part(axis) > -0.5 && part(axis) < end_m + 0.5, "{pose}");
    }
}

/// The 16-bit numbers in a base64 text.
fn numbers(text: &Value) -> Vec<u16> {
    let bytes = STANDARD.decode(text.as_str().unwrap()).unwrap();
    let (pairs, []) = bytes.as_chunks::<2>() else {
        unreachable!("half a number");
    };
    pairs.iter().map(|pair| u16::from_le_bytes(*pair)).collect()
}

#[test]
fn names_of_items_are_text_in_the_report() {
    let folder = tempfile::tempdir().unwrap();
    let name = "<img src=x onerror='a()'>&\"b\"";
    let file = folder.path().join(format!("{name}.ply"));
    std::fs::write(file, cube_ply(&[])).unwrap();
    let out = folder.path().join("out");
    let mut arguments = vec!["pack", "--random", "2", "--cell", "1cm", "--yaws", "4"];
    arguments.extend(["--tries", "0", "--json"]);
    arguments.extend(["--catalogue", folder.path().to_str().unwrap()]);
    arguments.extend(["--out", out.to_str().unwrap()]);
    let summary = json(&ppnpack(&arguments));
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(!page.contains("<img src=x"));
    assert!(page.contains("1 &lt;img src=x onerror=&#39;a()&#39;&gt;&amp;&quot;b&quot;"));
    let steps = summary["items_placed"].as_u64().unwrap() as usize;
    plays_every_step(&page, steps);
    assert_eq!(playback(&page)["steps"][0]["item"], name);
}

/// Packs the same few items with further options into a folder; returns the summary.
fn pack_few(out: &Path, more: &[&str]) -> Value {
    let mut arguments = vec!["pack", "--items", "mug,bowl,tennis_ball,tuna_can"];
    arguments.extend(["--cell", "1cm", "--tries", "0", "--json"]);
    arguments.extend(["--out", out.to_str().unwrap()]);
    arguments.extend(more);
    json(&ppnpack(&arguments))
}

#[test]
fn packings_are_compared_by_settings_figures_and_choices() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let summary = pack_few(&path("one"), &["--yaws", "4"]);
    pack_few(&path("again"), &["--yaws", "4"]);
    pack_few(
        &path("other"),
        &["--yaws", "4", "--container", "40x40x30cm", "--buffer", "1"],
    );
    let [one, again, other, out] = ["one", "again", "other", "out"].map(path);
    let compare = |a: &Path, b: &Path| {
        let [a, b, out] = [a, b, out.as_path()].map(|path| path.to_str().unwrap());
        let compared = json(&ppnpack(&["compare", a, b, "--json", "--out", out]));
        let page = Path::new(out).join("compare.html");
        (compared, std::fs::read_to_string(page).unwrap())
    };
    let (same, page) = compare(&one, &again);
    assert_eq!(same["settings"], serde_json::json!([]));
    assert_eq!(same["parting"], Value::Null);
    assert_eq!(same["steps_in_common"], summary["items_placed"]);
    let figures = same["figures"].as_array().unwrap();
    let filled = figures
        .iter()
        .find(|figure| figure["pointer"] == "/utilisation");
    assert_eq!(filled.unwrap()["difference"], 0.0);
    assert_eq!(page.matches("data:image/png;base64,").count(), 2);
    assert!(page.contains("The settings are the same") && page.contains("Nowhere: all "));

    let (parted, page) = compare(&one, &other);
    let settings = parted["settings"].as_array().unwrap();
    let names: Vec<&str> = settings
        .iter()
        .map(|setting| setting["setting"].as_str().unwrap())
        .collect();
    assert!(names.contains(&"grid.container.x_m"), "{names:?}");
    assert!(names.iter().all(|name| !name.contains("yaws")), "{names:?}");
    let step = parted["parting"]["step"].as_u64();
    assert_eq!(step, parted["steps_in_common"].as_u64());
    assert!(page.contains("grid.container.x_m") && page.contains("fuller, by"));

    let [a, b, out] = [&one, &other, &out].map(|path| path.to_str().unwrap());
    let told = ppnpack(&["compare", a, b, "--out", out]);
    let told = String::from_utf8(told.stdout).unwrap();
    for part in [
        "Container filled (meshes), in %",
        "grid.container.x_m",
        "compare.html",
    ] {
        assert!(told.contains(part), "{part}: {told}");
    }
}

#[test]
fn what_is_no_run_or_one_of_another_version_is_not_compared() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let [run, empty, older, several] = ["run", "empty", "older", "several"].map(path);
    pack_few(&run, &["--yaws", "4"]);
    for folder in [&empty, &older, &several] {
        std::fs::create_dir(folder).unwrap();
    }
    let write = |folder: &Path, summary: &str| {
        std::fs::write(folder.join("summary.json"), summary).unwrap();
    };
    write(&older, r#"{"version": "0.0.1", "settings": {}}"#);
    let now = env!("CARGO_PKG_VERSION");
    write(
        &several,
        &format!(r#"{{"version": "{now}", "containers": [], "settings": {{}}}}"#),
    );
    let run = run.to_str().unwrap();
    let out = path("out");
    let cases: [(&Path, &[&str]); 3] = [
        (&empty, &["empty is no run", "summary.json", "--out"]),
        (&older, &["version 0.0.1", now, "pack again"]),
        (&several, &["several containers", "container-001"]),
    ];
    for (folder, parts) in cases {
        let folder = folder.to_str().unwrap();
        for [a, b] in [[run, folder], [folder, run]] {
            refused(&["compare", a, b, "--out", out.to_str().unwrap()], parts);
        }
    }
    write(&empty, "{");
    let empty = empty.to_str().unwrap();
    refused(&["compare", run, empty], &["summary.json", "no result"]);
    assert!(!out.exists(), "a page of what was refused");
}

#[test]
fn several_containers_are_packed_with_a_report_of_each() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("result");
    // Small ones, coarse and without tries, so that some are closed soon.
    let options = "pack --random 24 --seed 3 --container 20x20x15cm --cell 1cm --yaws 4 --tries 0 --open 2 --json --out";
    let mut arguments: Vec<&str> = options.split(' ').collect();
    arguments.push(out.to_str().unwrap());
    let summary = json(&ppnpack(&arguments));
    let containers = summary["containers"].as_array().unwrap();
    let is_closed = |line: &&Value| line["closed_because"].is_string();
    assert!(
        containers.iter().filter(is_closed).count() >= 1,
        "{summary}"
    );
    let left = summary["unplaceable"].as_array().unwrap().len();
    let placed = summary["items_placed"].as_u64().unwrap() as usize;
    assert_eq!(placed + left, 24, "{summary}");
    // Every item is in one container, and in the report of that.
    let mut arrivals = std::collections::BTreeSet::new();
    for line in containers {
        let folder = out.join(line["folder"].as_str().unwrap());
        assert!(folder.join("report.html").is_file() && folder.join("packed.png").is_file());
        let table = std::fs::read_to_string(folder.join("placements.csv")).unwrap();
        for placement in table.lines().skip(1) {
            let arrival = placement.split(',').nth(1).unwrap().to_owned();
            assert!(arrivals.insert(arrival), "{table}");
        }
        let report = std::fs::read(folder.join("summary.json")).unwrap();
        let report: Value = serde_json::from_slice(&report).unwrap();
        assert_eq!(report["packed"]["items"], line["items"]);
    }
    assert_eq!(arrivals.len(), placed);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("container-001/report.html"), "{page}");
    refused(
        &["pack", "--open", "2", "--set-aside", "3"],
        &["--open", "--set-aside"],
    );
    refused(&["pack", "--open", "0"], &["--open"]);
}

#[test]
fn a_result_folder_is_that_of_the_last_run_alone() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("result");
    let pack = |more: &[&str]| {
        let options = "pack --random 2 --cell 1cm --yaws 4 --tries 0 --json --out";
        let mut arguments: Vec<&str> = options.split(' ').collect();
        arguments.push(out.to_str().unwrap());
        arguments.extend(more);
        json(&ppnpack(&arguments))
    };
    let names = || {
        let entries = out.read_dir().unwrap().map(|entry| entry.unwrap());
        let names = entries.map(|entry| entry.file_name().into_string().unwrap());
        names.collect::<std::collections::BTreeSet<String>>()
    };
    pack(&[]);
    let of_one = names();
    assert!(of_one.contains("placements.csv"), "{of_one:?}");
    // As a run into three containers leaves it.
    let further = out.join("container-003");
    std::fs::create_dir(&further).unwrap();
    std::fs::copy(out.join("summary.json"), further.join("summary.json")).unwrap();
    let summary = pack(&["--open", "1"]);
    assert_eq!(summary["containers"].as_array().unwrap().len(), 1);
    let of_several = ["container-001", "report.html", "summary.json"];
    assert!(names().iter().eq(&of_several), "{:?}", names());
    pack(&[]);
    assert_eq!(names(), of_one);
}
