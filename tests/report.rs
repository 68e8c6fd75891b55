//! What a packing leaves in its folder: figures, pictures and a page that plays it.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

#[allow(dead_code, reason = "nothing is refused here")]
mod command;
mod cube;

use command::{json, ppnpack};
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
