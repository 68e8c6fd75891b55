//! The report of a packing: figures, pictures and a page that plays it.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

use crate::cube::cube_ply;
use crate::support::{Packed, has, names, packed};

#[test]
fn packing_the_builtin_set_writes_a_whole_report() {
    let packed = packed("pack --random 12 --seed 3");
    let summary = &packed.summary;
    assert_eq!(summary["items_in_sequence"], 12);
    let count = summary["packed"]["items"].as_u64().unwrap();
    assert!(count >= 8, "{summary}");
    assert!(summary["floor_compactness"].as_f64().unwrap() > 0.1);
    let files = [
        "heightmap.png",
        "packed.png",
        "placements.csv",
        "report.html",
        "summary.json",
    ];
    assert_eq!(names(packed.folder.path()), files);
    let written = std::fs::read(packed.folder.path().join("summary.json")).unwrap();
    let written: Value = serde_json::from_slice(&written).unwrap();
    assert_eq!(written["packed"], summary["packed"]);
    let page = packed.page();
    let parts = [
        "data:image/png;base64,",
        "<svg",
        "prefers-color-scheme: dark",
        "@media print",
        &format!("{count} of 12 items are packed"),
    ];
    has(&page, &parts);
    for foreign in ["src=\"http", "href=\"http", "url("] {
        assert!(!page.contains(foreign), "the page opens offline: {foreign}");
    }
    assert!(page.len() < 3_000_000, "{} bytes", page.len());
    let placed = summary["items_placed"].as_u64().unwrap() as usize;
    assert_eq!(packed.placements().len(), placed + 1);
    plays_every_step(&packed, placed);
}

/// The page's viewer has as many steps, with shapes that can be drawn, where each was planned and
/// what each moved.
fn plays_every_step(packed: &Packed, steps: usize) {
    let playback = packed.playback();
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
    has(&packed.page(), &[&format!("max={0} value={0}", 2 * steps)]);
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
    let grid = "--random 2 --cell 1cm --yaws 4 --tries 0";
    let catalogue = folder.path().display();
    let packed = packed(&format!("pack {grid} --catalogue {catalogue}"));
    let page = packed.page();
    assert!(!page.contains("<img src=x"));
    assert!(page.contains("1 &lt;img src=x onerror=&#x27;a()&#x27;&gt;&amp;&quot;b&quot;"));
    let steps = packed.summary["items_placed"].as_u64().unwrap() as usize;
    plays_every_step(&packed, steps);
    assert_eq!(packed.playback()["steps"][0]["item"], name);
}
