//! Packing by command: what is chosen where, with which options.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::process::Command;

use ppnpack_packing::grid::GridSettings;
use ppnpack_packing::method::{Method, SET_ASIDE};
use ppnpack_planner::CellSettings;
use serde_json::Value;

mod command;

use command::{cache, json, ppnpack, refused};

#[test]
fn what_is_not_said_is_the_same_for_the_command_the_planner_and_the_files_to_deploy() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let pack = ["pack", "--random", "1", "--json", "--out"];
    let summary = json(&ppnpack(&[&pack[..], &[out.to_str().unwrap()]].concat()));
    let packed = &summary["settings"];
    let usual = Method::default();
    let of_one_pose = serde_json::to_value(usual.clone().for_poses(1)).unwrap();
    assert_eq!(packed["method"], of_one_pose);
    let grid = GridSettings::default().build().unwrap();
    assert_eq!(packed["grid"], serde_json::to_value(grid).unwrap());
    assert_eq!(packed["set_aside"], SET_ASIDE);
    let cell = CellSettings::default();
    let planned = (&cell.method, cell.grid, cell.set_aside);
    assert_eq!(planned, (&usual, GridSettings::default(), SET_ASIDE));
    let deployed = include_str!("../deploy/configuration/planner.toml");
    let deployed: toml::Value = toml::from_str(deployed).unwrap();
    let deployed = deployed["service"]["cells"]["cell-1"].clone();
    assert_eq!(deployed.try_into::<CellSettings>().unwrap(), cell);
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
}

#[test]
fn published_tries_end_a_packing_and_are_refused_by_the_stack() {
    let folder = tempfile::tempdir().unwrap();
    let method = folder.path().join("method.toml");
    let tries = "proposals = { from = \"tries\", yaws = 3, positions = 9 }";
    let text = format!("heuristic = \"random\"\norder = \"shuffled\"\n{tries}");
    std::fs::write(&method, text).unwrap();
    let method = ["--method", method.to_str().unwrap()];
    let out = folder.path().join("out");
    let options = ["pack", "--conditions", "reference", "--json", "--out"];
    let arguments = [&options[..], &[out.to_str().unwrap()], &method].concat();
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
    refused(&[&["up"], &method[..]].concat(), &["random tries"]);
}

#[test]
fn random_proposals_pack_on_fine_grids() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let options = "pack --random 8 --json --proposals random --k 20 --cell 5mm --yaws 8 --out";
    let mut arguments: Vec<&str> = options.split(' ').collect();
    arguments.push(out.to_str().unwrap());
    let summary = json(&ppnpack(&arguments));
    let packed = summary["packed"]["items"].as_u64().unwrap();
    assert!(packed >= 5, "{summary}");
    let from = &summary["settings"]["method"]["proposals"]["from"];
    assert_eq!(from, "random");
}

#[test]
fn other_grids_containers_and_methods_pack() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let packed = |options: &str, method: &str| {
        let file = folder.path().join("method.json");
        std::fs::write(&file, method).unwrap();
        let mut arguments: Vec<&str> = options.split(' ').collect();
        arguments.extend(["--method", file.to_str().unwrap(), "--json", "--out"]);
        arguments.push(out.to_str().unwrap());
        let summary = json(&ppnpack(&arguments));
        assert!(
            summary["packed"]["items"].as_u64().unwrap() >= 1,
            "{options}: {summary}"
        );
        summary["settings"]["method"].clone()
    };
    packed(
        "pack --random 5 --container 40x25x16cm --cell 5mm --yaws 8 --buffer 2",
        "{}",
    );
    packed("pack --items tennis_ball,0 --height-unit 1mm", "{}");
    let coarse = "pack --random 5 --cell 1cm --yaws 4";
    for method in [
        r#"{"heuristic": "dbl", "order": "bbox-volume", "stability": "published"}"#,
        r#"{"heuristic": "hm", "proposals": {"from": "random", "percent": 20.0}}"#,
        r#"{"heuristic": "mta", "weights": {"touching_area": 2.0}}"#,
        r#"{"heuristic": "random", "order": "shuffled", "stability": "none"}"#,
    ] {
        let used = packed(coarse, method);
        let asked: Value = serde_json::from_str(method).unwrap();
        assert_eq!(used["heuristic"], asked["heuristic"]);
    }
    let physics = format!("{coarse} --settle 2 --release-height 5mm");
    packed(
        &physics,
        r#"{"heuristic": "first-fit", "order": "arrival"}"#,
    );
}

#[test]
fn options_win_over_the_file_of_the_method_and_what_is_wrong_in_it_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("method.toml");
    let method = ["--method", file.to_str().unwrap()];
    std::fs::write(&file, "buffer = 3\nseed = 4").unwrap();
    let out = folder.path().join("out");
    let options = "pack --random 1 --cell 1cm --yaws 4 --buffer 2 --json --out";
    let mut arguments: Vec<&str> = options.split(' ').collect();
    arguments.push(out.to_str().unwrap());
    arguments.extend(method);
    let used = &json(&ppnpack(&arguments))["settings"]["method"];
    assert_eq!((&used["buffer"], &used["seed"]), (&2.into(), &4.into()));
    for (text, named) in [
        ("bufer = 3", "bufer"),
        ("buffer = 0", "the buffer"),
        ("weights = { distance = nan }", "distance"),
        (
            "proposals = { from = \"tries\", yaws = 0, positions = 9 }",
            "yaws that are tried",
        ),
        ("heuristic = \"best\"", "best"),
        ("trial = { limits = { slide_m = -1.0 } }", "slide"),
        ("trial = { above_rim_m = -0.001 }", "above the rim"),
        ("weights = { distance = -1.0 }", "distance"),
        ("weights = { distanse = 1.0 }", "distanse"),
        (
            "proposals = { from = \"network\", percent = 5.0, coarsening = { cells = 1, yaws = 1 } }",
            "--proposals network",
        ),
    ] {
        std::fs::write(&file, text).unwrap();
        refused(&[&["pack"], &method[..]].concat(), &["--method", named]);
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
        arguments.extend(["crisps_tube", "--poses", poses]);
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
