//! The command end to end, as a user runs it: results, exit codes, and one clear line for every bad input.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

#[path = "../crates/packing/tests/golden/cases.rs"]
mod golden;

fn ppnpack(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ppnpack"));
    command.args(arguments).env("XDG_CACHE_HOME", cache());
    command.output().unwrap()
}

/// One cache for all tests: the objects are prepared once.
fn cache() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("cache")
}

/// Runs a command that must be refused with exit code 2 and a message that has all of these parts.
fn refused(arguments: &[&str], parts: &[&str]) {
    let output = ppnpack(arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    for part in parts {
        assert!(
            error.contains(part),
            "{arguments:?}: '{part}' is not in: {error}"
        );
    }
    assert!(!error.contains("panicked"), "{error}");
    // The command's own errors take one line; those of the command line's parser come with a hint.
    if error.starts_with("ppnpack: ") {
        assert_eq!(error.trim_end().lines().count(), 1, "{error}");
    }
}

fn json(output: &Output) -> Value {
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    serde_json::from_slice(&output.stdout).unwrap()
}

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

#[test]
fn the_same_seed_packs_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, threads: &str| {
        let out = folder.path().join(name);
        let out = out.to_str().unwrap();
        let arguments = [
            "pack",
            "--random",
            "10",
            "--seed",
            "5",
            "--json",
            "--threads",
            threads,
            "--out",
            out,
        ];
        let mut summary = json(&ppnpack(&arguments));
        for timed in ["decision_s", "stages_s", "took_s", "settings"] {
            summary.as_object_mut().unwrap().remove(timed);
        }
        summary
    };
    assert_eq!(run("one", "1"), run("two", "2"));
}

#[test]
fn without_libtorch_the_network_gives_way_to_the_exhaustive_search_with_the_reason() {
    // Alone in a folder, the command finds no program with the network beside it.
    let folder = tempfile::tempdir().unwrap();
    let alone = folder.path().join("ppnpack");
    std::fs::copy(env!("CARGO_BIN_EXE_ppnpack"), &alone).unwrap();
    let run = |proposals: &str, out: &str| {
        let out = folder.path().join(out);
        let mut command = Command::new(&alone);
        command.args(["pack", "--random", "6", "--json", "--proposals", proposals]);
        command.arg("--out").arg(out).env("XDG_CACHE_HOME", cache());
        json(&command.output().unwrap())
    };
    let (all, network) = (run("all", "all"), run("network", "network"));
    assert_eq!(all["packed"], network["packed"]);
    let degraded = network["degraded"].as_array().unwrap();
    assert_eq!(degraded.len(), 1, "{network}");
    let reason = degraded.first().unwrap()["reason"].as_str().unwrap();
    assert!(
        reason.contains("cargo build --release --bin ppnpack-torch"),
        "{reason}"
    );
    let auto = run("auto", "auto");
    let costs = auto["settings"]["costs"].as_array().unwrap();
    assert_eq!(costs.last().unwrap()["decision_s"], Value::Null);
    assert_eq!(auto["degraded"], serde_json::json!([]));
}

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
fn published_tries_end_a_packing_and_are_refused_by_the_stack() {
    let folder = tempfile::tempdir().unwrap();
    let options = "pack --conditions reference --heuristic random --order shuffled --proposals tries --json --out";
    let mut arguments: Vec<&str> = options.split(' ').collect();
    let out = folder.path().join("out");
    arguments.push(out.to_str().unwrap());
    let summary = json(&ppnpack(&arguments));
    assert_eq!(summary["ending"]["kind"], "nothing-fits", "{summary}");
    assert_eq!(summary["steps_widened"], 0);
    let items = summary["ending"]["items"].as_array().unwrap();
    let reasons = items.iter().map(|item| item["reason"].as_str().unwrap());
    assert_eq!(reasons.clone().count(), 5);
    for reason in reasons {
        assert!(reason.contains("placements that were tried"), "{reason}");
    }
    let tries = &summary["settings"]["method"]["proposals"];
    assert_eq!(
        *tries,
        serde_json::json!({"from": "tries", "yaws": 3, "positions": 9})
    );
    let none = ["pack", "--proposals", "tries", "--try-positions", "0"];
    refused(&none, &["--try-positions"]);
    refused(&["up", "--proposals", "tries"], &["--proposals tries"]);
}

#[test]
fn coarse_and_random_proposals_pack_on_fine_grids() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let grid = [
        "--cell",
        "5mm",
        "--yaws",
        "8",
        "--out",
        out.to_str().unwrap(),
    ];
    for (proposals, k) in [("coarse", "5"), ("random", "20")] {
        let pack = [
            "pack",
            "--random",
            "8",
            "--json",
            "--proposals",
            proposals,
            "--k",
            k,
        ];
        let summary = json(&ppnpack(&[&pack[..], &grid].concat()));
        assert!(
            summary["packed"]["items"].as_u64().unwrap() >= 5,
            "{summary}"
        );
        assert_eq!(
            summary["settings"]["method"]["proposals"]["from"],
            proposals
        );
    }
    let coarser = ["pack", "--proposals", "coarse", "--proposal-cell", "2m"];
    refused(&coarser, &["cells of the grid make no coarse cell"]);
    refused(
        &["pack", "--proposals", "coarse", "--proposal-yaws", "0"],
        &["--proposal-yaws"],
    );
}

#[test]
fn other_grids_containers_and_methods_pack() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    for extra in [
        &[
            "--container",
            "40x25x16cm",
            "--cell",
            "5mm",
            "--yaws",
            "8",
            "--buffer",
            "2",
        ][..],
        &[
            "--heuristic",
            "dbl",
            "--order",
            "bbox",
            "--stability",
            "published",
        ],
        &["--heuristic", "hm", "--proposals", "random", "--k", "20"],
        &["--heuristic", "mta", "--weight", "touching_area=2"],
        &[
            "--heuristic",
            "first-fit",
            "--order",
            "arrival",
            "--settle",
            "2",
            "--release-height",
            "5mm",
        ],
        &[
            "--heuristic",
            "random",
            "--order",
            "shuffled",
            "--stability",
            "none",
        ],
        &["--items", "tennis_ball,0", "--height-unit", "1mm"],
    ] {
        let base = [
            "pack",
            "--random",
            "5",
            "--json",
            "--out",
            out.to_str().unwrap(),
        ];
        let base = if extra[0] == "--items" {
            &[&base[..1], &base[3..]].concat()
        } else {
            &base[..]
        };
        let summary = json(&ppnpack(&[base, extra].concat()));
        assert!(
            summary["packed"]["items"].as_u64().unwrap() >= 1,
            "{extra:?}: {summary}"
        );
    }
}

#[test]
fn an_arm_packs_what_it_can_reach_and_tells_its_cycle_times() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, arm: &[&str]| {
        let out = folder.path().join(name);
        let mut arguments = vec!["pack", "--random", "16", "--seed", "3", "--json", "--out"];
        arguments.push(out.to_str().unwrap());
        arguments.extend(arm);
        let summary = json(&ppnpack(&arguments));
        let placements = std::fs::read_to_string(out.join("placements.csv")).unwrap();
        let page = std::fs::read_to_string(out.join("report.html")).unwrap();
        (summary, placements, page)
    };
    let (without, placements, page) = run("without", &[]);
    assert!(without.get("arm").is_none() && without["settings"]["method"].get("arm").is_none());
    assert!(!placements.contains("cycle_s") && !page.contains("Cycle"));

    let (summary, placements, page) = run("with", &["--arm", "nachi-mz07l"]);
    let arm = &summary["arm"];
    let set_aside = arm["set_aside"].as_array().unwrap();
    let packed = summary["items_placed"].as_u64().unwrap();
    assert!(packed >= 4, "{summary}");
    assert_eq!(summary["items_in_sequence"], 16 - set_aside.len());
    assert!(!set_aside.is_empty());
    for item in set_aside {
        assert!(
            item["reason"]
                .as_str()
                .unwrap()
                .contains("cannot be picked"),
            "{item}"
        );
    }
    let refused = arm["refused"].as_object().unwrap();
    let refused: u64 = refused.values().map(|count| count.as_u64().unwrap()).sum();
    assert!(arm["checks"].as_u64().unwrap() >= packed + refused);
    let mean_s = arm["cycle_s"]["mean"].as_f64().unwrap();
    assert!((1.0..5.0).contains(&mean_s), "{mean_s}");
    let mut lines = placements.lines();
    assert!(lines.next().unwrap().ends_with(",cycle_s"));
    let times_s = lines.map(|line| line.rsplit(',').next().unwrap().parse::<f64>().unwrap());
    let sum_s: f64 = times_s.sum();
    assert!((sum_s / packed as f64 - mean_s).abs() < 1e-6);
    for part in ["Cycle (s)", "cycle per item", "Set aside", "NACHI"] {
        assert!(page.contains(part), "{part}");
    }

    // A container that is too far away: nothing can be placed, and each item has the reason.
    let place = ["--arm-base", "-150cm,16cm,10cm", "--set-aside", "0"];
    let far = [&["--arm", "nachi-mz07l"][..], &place].concat();
    let (summary, ..) = run("far", &far);
    assert_eq!(summary["items_placed"], 0);
    let item = &summary["ending"]["items"][0];
    let reason = item["reason"].as_str().unwrap();
    assert!(
        reason.contains("not possible for the arm") && reason.contains("reach"),
        "{reason}"
    );
}

#[test]
fn the_arms_are_listed_and_others_refused_with_their_names() {
    let listed = ppnpack(&["pack", "--arm", "list"]);
    let listed = String::from_utf8(listed.stdout).unwrap();
    let names: Vec<&str> = listed.lines().collect();
    assert!(names.contains(&"nachi-mz07l"), "{names:?}");
    let help = ppnpack(&["pack", "--help"]);
    let help = String::from_utf8(help.stdout).unwrap();
    assert!(names.iter().all(|name| help.contains(name)), "{help}");
    for command in ["pack", "up"] {
        refused(&[command, "--arm", "r2d2"], &["r2d2", names[0], names[1]]);
    }
    let nachi = |more: &[&'static str]| [&["pack", "--arm", "nachi-mz07l"], more].concat();
    refused(&["pack", "--arm", "absent.toml"], &["absent.toml"]);
    refused(&["pack", "--arm-base", "0,0,0"], &["--arm"]);
    refused(&nachi(&["--arm-base", "1,2"]), &["three lengths"]);
    refused(&nachi(&["--arm-pick", "1,2,300m"]), &["pick.position_m[2]"]);
    refused(
        &nachi(&["--arm-cell", "absent.toml"]),
        &["--arm-cell", "absent.toml"],
    );
    let folder = tempfile::tempdir().unwrap();
    let cell = folder.path().join("cell.toml");
    std::fs::write(&cell, "[cell]\nclearance_mm = 3").unwrap();
    let cell = [
        "pack",
        "--arm",
        "nachi-mz07l",
        "--arm-cell",
        cell.to_str().unwrap(),
    ];
    refused(&cell, &["cell.toml", "clearance_mm"]);
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
    refused(&["pack", "--effort", "5"], &["--effort", "no unit of time"]);
    refused(&["pack", "--effort", "0ms"], &["--effort", "from 1 ms"]);
    refused(
        &["pack", "--effort", "20ms", "--tries", "3"],
        &["--effort", "--tries"],
    );
    refused(&["pack", "--above-rim=-1mm"], &["--above-rim", "negative"]);
    refused(&["pack", "--leniency", "0.5"], &["leniency", "1"]);
    refused(&["pack", "--weight", "distance"], &["there is no '='"]);
    refused(
        &["pack", "--weight", "distanse=1"],
        &["no such weight", "distance"],
    );
    refused(
        &["pack", "--weight", "distance=nan"],
        &["--weight distance=nan", "no finite number"],
    );
    refused(
        &["pack", "--weight", "distance=-1"],
        &["distance", "at least 0"],
    );
    refused(
        &["pack", "--items", "unobtainium"],
        &["unobtainium", "catalogue list"],
    );
    refused(&["pack", "--heuristic", "best"], &["--heuristic"]);
    refused(&["pack", "--settle", "-1"], &["--settle"]);
    refused(
        &["pack", "--physics", "/nowhere.json"],
        &["--physics /nowhere.json"],
    );
    refused(&["sort"], &["sort"]);
}

#[test]
fn objects_larger_than_the_container_are_named_as_such() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let arguments = [
        "pack",
        "--container",
        "3x3x3cm",
        "--items",
        "tennis_ball",
        "--json",
        "--out",
        out.to_str().unwrap(),
    ];
    let summary = json(&ppnpack(&arguments));
    assert_eq!(summary["items_placed"], 0);
    let item = &summary["set_aside"][0];
    assert_eq!(item["item"], "tennis_ball");
    assert!(
        item["reason"].as_str().unwrap().contains("too large"),
        "{summary}"
    );
}

#[test]
fn what_fits_nowhere_is_set_aside_and_the_packing_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let items = "crisps_tube,tuna_can";
        let mut arguments = vec!["pack", "--container", "12x12x12cm", "--items", items];
        arguments.extend(["--buffer", "1", "--json", "--out", out.to_str().unwrap()]);
        arguments.extend(more);
        let summary = json(&ppnpack(&arguments));
        let page = std::fs::read_to_string(out.join("report.html")).unwrap();
        (summary, page)
    };
    let (summary, page) = run("ended", &["--set-aside", "0"]);
    assert_eq!(summary["items_placed"], 0);
    assert_eq!(summary["set_aside"], serde_json::json!([]));
    assert_eq!(summary["ending"]["kind"], "nothing-fits");
    assert!(!page.contains("Set aside for the next container"));

    let (summary, page) = run("went-on", &["--set-aside", "2"]);
    assert_eq!(summary["items_placed"], 1);
    assert_eq!(summary["ending"]["kind"], "others-set-aside");
    assert_eq!(summary["settings"]["set_aside"], 2);
    let set_aside = summary["set_aside"].as_array().unwrap();
    assert_eq!(set_aside.len(), 1);
    assert_eq!(set_aside[0]["arrival"], 0);
    assert_eq!(set_aside[0]["item"], "crisps_tube");
    let reason = set_aside[0]["reason"].as_str().unwrap();
    assert!(reason.contains("too large"), "{reason}");
    for part in [
        "<h2>Set aside for the next container",
        "1 of at most 2 items",
    ] {
        assert!(page.contains(part), "{part}");
    }
}

#[test]
fn an_item_that_is_too_high_as_it_stands_is_packed_lying() {
    let folder = tempfile::tempdir().unwrap();
    let run = |poses: &str| {
        let out = folder.path().join(poses);
        let mut arguments = vec!["pack", "--container", "26x12x10cm", "--items"];
        arguments.extend(["crisps_tube", "--stability", "none", "--poses", poses]);
        arguments.extend(["--turn-time", "4500ms", "--json"]);
        arguments.extend(["--out", out.to_str().unwrap()]);
        let summary = json(&ppnpack(&arguments));
        let placements = std::fs::read_to_string(out.join("placements.csv")).unwrap();
        let page = std::fs::read_to_string(out.join("report.html")).unwrap();
        (summary, placements, page)
    };
    let (summary, ..) = run("1");
    assert_eq!(summary["items_placed"], 0);
    let (summary, placements, page) = run("2");
    assert_eq!(summary["items_placed"], 1);
    assert_eq!(summary["items_in_other_pose"], 1);
    assert_eq!(summary["turning_s"], 4.5);
    assert_eq!(summary["settings"]["poses"], 2);
    let mut lines = placements.lines();
    let field = |line: &str| line.split(',').nth(3).map(str::to_owned);
    assert_eq!(lines.next().and_then(field).as_deref(), Some("pose"));
    assert_eq!(lines.next().and_then(field).as_deref(), Some("1"));
    assert!(page.contains("in another pose than that in which it was offered: 1 of 1 items"));
    assert!(page.contains("1 of 1 items; turning takes 4.5 s, 4.5 s an item packed"));
}

/// A cube of 5 cm as ASCII PLY, with replacements to break it.
fn cube_ply(replace: &[(&str, &str)]) -> String {
    let mut ply = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n\
        element face 12\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0\n0.05 0 0\n0.05 0.05 0\n0 0.05 0\n0 0 0.05\n0.05 0 0.05\n0.05 0.05 0.05\n0 0.05 0.05\n\
        3 0 2 1\n3 0 3 2\n3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n"
        .to_owned();
    for (from, to) in replace {
        assert!(ply.contains(from), "{from}");
        ply = ply.replacen(from, to, 1);
    }
    ply
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
fn evaluate_prints_what_the_golden_cases_say() {
    let golden = &golden::cases()[7];
    let folder = tempfile::tempdir().unwrap();
    let case = folder.path().join("case.npz");
    let mut npz = ndarray_npy::NpzWriter::new(std::fs::File::create(&case).unwrap());
    npz.add_array("container", &golden.container).unwrap();
    npz.add_array("object_top", &golden.top).unwrap();
    npz.add_array("object_bottom", &golden.bottom).unwrap();
    npz.finish().unwrap();
    for (heuristic, expected) in [
        ("sdf", &golden.sdf),
        ("dbl", &golden.dbl),
        ("hm", &golden.hm),
    ] {
        let arguments = [
            "evaluate",
            "--case",
            case.to_str().unwrap(),
            "--heuristic",
            heuristic,
            "--json",
        ];
        let found = json(&ppnpack(&arguments));
        let mut compared = 0;
        for ((x, y), height) in golden
            .drop
            .indexed_iter()
            .filter(|(_, height)| **height >= 0)
        {
            assert_eq!(found["drop"][x][y], *height);
            assert_eq!(found["fits"][x][y], 1);
            let value = found["value"][x][y].as_f64().unwrap();
            let error = f64::from(value as f32) - f64::from(expected[[x, y]]);
            assert!(error.abs() <= 1e-3, "{heuristic} at {x}, {y}: {value}");
            compared += 1;
        }
        assert!(compared > 0);
    }
}

#[test]
fn broken_cases_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("case.npz");
    std::fs::write(&file, b"PK no").unwrap();
    refused(
        &["evaluate", "--case", file.to_str().unwrap()],
        &["case.npz", "no complete .npz file"],
    );
    refused(&["evaluate", "--case", "/nowhere.npz"], &["/nowhere.npz"]);
    let mut npz = ndarray_npy::NpzWriter::new(std::fs::File::create(&file).unwrap());
    npz.add_array("container", &ndarray::array![[0_i16, -4]])
        .unwrap();
    npz.finish().unwrap();
    refused(
        &["evaluate", "--case", file.to_str().unwrap()],
        &["object_top"],
    );
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
