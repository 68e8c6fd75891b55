//! Packing by command: what is chosen where, with which options.

use ppnpack_packing::kernel::grid::GridSettings;
use ppnpack_packing::planning::method::{Method, SET_ASIDE};
use ppnpack_planner::CellSettings;
use serde_json::{Value, json};

use crate::support::{Packed, alone, fails, has, packed, ppnpack, refused, text};

#[test]
fn what_is_not_said_is_the_same_for_the_command_the_planner_and_the_files_to_deploy() {
    let summary = packed("pack --random 1").summary;
    let settings = &summary["settings"];
    let usual = Method::default();
    let of_one_pose = serde_json::to_value(usual.clone().for_poses(1)).unwrap();
    assert_eq!(settings["method"], of_one_pose);
    let grid = GridSettings::default().build().unwrap();
    assert_eq!(settings["grid"], serde_json::to_value(grid).unwrap());
    assert_eq!(settings["set_aside"], SET_ASIDE);
    let cell = CellSettings::default();
    let planned = (&cell.method, cell.grid, cell.set_aside);
    assert_eq!(planned, (&usual, GridSettings::default(), SET_ASIDE));
    let deployed = include_str!("../../deploy/configuration/planner.toml");
    let deployed: toml::Value = toml::from_str(deployed).unwrap();
    let deployed = deployed["service"]["cells"]["cell-1"].clone();
    assert_eq!(deployed.try_into::<CellSettings>().unwrap(), cell);
}

#[test]
fn pack_has_few_options() {
    let help = text(&ppnpack("pack --help"));
    let lines = help.lines();
    let options = lines.filter(|line| line.trim_start().starts_with("--"));
    let options: Vec<&str> = options.collect();
    assert!(options.len() <= 25, "{options:#?}");
    // What matters first comes before the headings, and two examples last.
    let heading = help.find("\nObjects:").unwrap();
    let (first, others) = help.split_at(heading);
    for option in ["--catalogue", "--container", "--random", "--poses", "--out"] {
        assert!(first.contains(option) && !others.contains(&format!("\n      {option}")));
    }
    let examples = others.split_once("Examples:").unwrap().1;
    assert_eq!(examples.matches("ppnpack pack").count(), 2);
}

#[test]
fn a_folder_that_cannot_be_made_is_refused_before_anything_is_prepared() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "x").unwrap();
    // The catalogue would be refused, too, if it was looked at.
    let words = format!("pack --catalogue /nowhere --out {}", file.display());
    let output = ppnpack(&words);
    fails(&output, 1, &["file cannot be written"]);
}

#[test]
fn only_the_objects_that_are_named_are_prepared() {
    let named = packed("pack --items mug,bowl,mug --cell 1cm --yaws 4").summary;
    assert_eq!(named["settings"]["objects"], 2, "{named}");
    assert_eq!(named["packed"]["items"], 3);
    // By number, they are those of all.
    let numbered = packed("pack --items mug,0 --cell 1cm --yaws 4").summary;
    assert_eq!(numbered["settings"]["objects"], 96, "{numbered}");
}

#[test]
fn the_same_seed_packs_the_same() {
    let run = || {
        let mut summary = packed("pack --random 10 --seed 5").summary;
        for timed in ["decision_s", "stages_s", "took_s"] {
            summary.as_object_mut().unwrap().remove(timed);
        }
        summary
    };
    assert_eq!(run(), run());
}

#[test]
fn without_libtorch_the_network_gives_way_to_the_exhaustive_search_with_the_reason() {
    // Alone in a folder, the command finds no program with the network beside it.
    let folder = tempfile::tempdir().unwrap();
    let run = |proposals: &str| -> Value {
        let out = folder.path().join(proposals);
        let out = out.display();
        let words = format!("pack --random 6 --json --proposals {proposals} --out {out}");
        serde_json::from_str(&text(&alone(&folder, &words))).unwrap()
    };
    let (all, network) = (run("all"), run("network"));
    assert_eq!(all["packed"], network["packed"]);
    let degraded = network["degraded"].as_array().unwrap();
    assert_eq!(degraded.len(), 1, "{network}");
    let reason = degraded[0]["reason"].as_str().unwrap();
    has(reason, &["cargo build --bin ppnpack-torch"]);
}

#[test]
fn published_tries_end_a_packing_and_are_refused_by_the_stack() {
    let folder = tempfile::tempdir().unwrap();
    let method = folder.path().join("method.toml");
    let tries = "proposals = { from = \"tries\", yaws = 3, positions = 9 }";
    let text = format!("heuristic = \"random\"\norder = \"shuffled\"\n{tries}");
    std::fs::write(&method, text).unwrap();
    let method = method.display();
    let summary = packed(&format!("pack --conditions reference --method {method}")).summary;
    assert_eq!(summary["ending"]["kind"], "nothing-fits", "{summary}");
    assert_eq!(summary["steps_widened"], 0);
    let items = summary["ending"]["items"].as_array().unwrap();
    assert_eq!(items.len(), 5);
    for item in items {
        let reason = item["reason"].as_str().unwrap();
        assert!(reason.contains("placements that were tried"), "{reason}");
    }
    let tries = &summary["settings"]["method"]["proposals"];
    assert_eq!(*tries, json!({"from": "tries", "yaws": 3, "positions": 9}));
    refused(&format!("up --method {method}"), &["random tries"]);
}

#[test]
fn random_proposals_pack_on_fine_grids() {
    let summary = packed("pack --random 8 --proposals random:20 --cell 5mm --yaws 8").summary;
    assert!(summary["packed"]["items"].as_u64() >= Some(5), "{summary}");
    let proposals = &summary["settings"]["method"]["proposals"];
    assert_eq!(*proposals, json!({"from": "random", "percent": 20.0}));
}

#[test]
fn other_grids_containers_methods_and_cells_pack() {
    let folder = tempfile::tempdir().unwrap();
    let [file, physics] = ["method.json", "physics.toml"].map(|name| folder.path().join(name));
    let check = |options: &str, method: &str| {
        std::fs::write(&file, method).unwrap();
        let summary = packed(&format!("pack {options} --method {}", file.display())).summary;
        let count = summary["packed"]["items"].as_u64();
        assert!(count >= Some(1), "{options}: {summary}");
        summary["settings"].clone()
    };
    let fine = "--random 5 --container 40x25x16cm --cell 5mm --yaws 8 --buffer 2";
    check(fine, "{}");
    check("--items tennis_ball,0", "{}");
    let coarse = "--random 5 --cell 1cm --yaws 4";
    for method in [
        r#"{"heuristic": "dbl", "order": "bbox-volume", "stability": "published"}"#,
        r#"{"heuristic": "hm", "proposals": {"from": "random", "percent": 20.0}}"#,
        r#"{"heuristic": "mta", "weights": {"touching_area": 2.0}}"#,
        r#"{"heuristic": "random", "order": "shuffled", "stability": "none"}"#,
    ] {
        let used = check(coarse, method);
        let asked: Value = serde_json::from_str(method).unwrap();
        assert_eq!(used["method"]["heuristic"], asked["heuristic"]);
    }
    std::fs::write(&physics, "settle_time_s = 2.0\nrelease.height_m = 0.005").unwrap();
    let physics = format!("{coarse} --view middles --physics {}", physics.display());
    let method = r#"{"heuristic": "first-fit", "order": "arrival"}"#;
    let used = check(&physics, method);
    let cell = &used["simulated"]["cell"];
    assert_eq!(cell["settle_time_s"], 2.0, "{used}");
    assert_eq!(cell["release"]["height_m"], 0.005, "{used}");
}

#[test]
fn what_is_taken_of_a_container_is_packed_around_and_on() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("taken.toml");
    let pack = format!(
        "pack --random 12 --cell 1cm --yaws 4 --physics {}",
        file.display()
    );
    let half = "{ from_m = [0, 0, 0], to_m = [0.16, 0.32, 0.3] }";
    let low = "{ from_m = [0.16, 0, 0], to_m = [0.32, 0.32, 0.04] }";
    std::fs::write(&file, format!("taken = [{half}, {low}]")).unwrap();
    let lines = packed(&pack).placements();
    assert!(lines.len() > 3, "{lines:?}");
    for line in lines.iter().skip(1) {
        let [cell_x, resting_height_m] = [5, 7].map(|at| line[at].parse::<f64>().unwrap());
        assert!(cell_x >= 16.0 && resting_height_m >= 0.04, "{line:?}");
    }
    std::fs::write(
        &file,
        "taken = [{ from_m = [0, 0, 0], to_m = [0.1, 0, 0.1] }]",
    )
    .unwrap();
    fails(&ppnpack(&pack), 2, &["taken.to_m", "above from_m"]);
}

#[test]
fn a_container_that_another_packing_left_is_packed_on() {
    let before = packed("pack --random 8 --seed 3 --cell 1cm --yaws 4");
    let folder = before.folder.path();
    let physics = folder.join("physics.toml");
    std::fs::write(&physics, "preloaded = \"placements.csv\"\n").unwrap();
    let pack = format!(
        "pack --random 8 --seed 4 --cell 1cm --yaws 4 --physics {}",
        physics.display()
    );
    let after = packed(&pack);
    let lying = |packed: &Packed| packed.playback()["lying"].as_array().unwrap().len();
    assert_eq!(
        (lying(&before), lying(&after)),
        (0, before.placements().len() - 1)
    );
    // Most items lie on those of before, and what lay there stays within the walls.
    let alone = packed("pack --random 8 --seed 4 --cell 1cm --yaws 4").summary;
    assert_eq!(after.summary["items_placed"], alone["items_placed"]);
    let height_m = |summary: &Value| summary["height_m"].as_f64().unwrap();
    assert!(height_m(&after.summary) > height_m(&alone) + 0.02);
    for (table, reason) in [
        ("item,end_x_m\nmug,0.1\n", "line 2: a pose has all of"),
        ("item,end_x_m\nsofa,\n", "no object 'sofa'"),
        (
            "item,end_x_m,end_y_m,end_z_m,end_qw,end_qx,end_qy,end_qz\nmug,1,0,0,1,0,0,0\n",
            "mug does not lie in the container",
        ),
        (
            "item,end_x_m,end_y_m,end_z_m,end_qw,end_qx,end_qy,end_qz\nmug,0,0,0,1,1,0,0\n",
            "no unit quaternion",
        ),
    ] {
        std::fs::write(folder.join("placements.csv"), table).unwrap();
        fails(&ppnpack(&pack), 2, &["placements.csv", reason]);
    }
    let up = format!("up --pack --physics {}", physics.display());
    fails(&ppnpack(&up), 2, &["preloaded"]);
}

#[test]
fn options_win_over_the_file_of_the_method_and_what_is_wrong_in_it_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("method.toml");
    let pack = format!("pack --method {}", file.display());
    std::fs::write(&file, "buffer = 3\nseed = 4").unwrap();
    let summary = packed(&format!("{pack} --random 1 --cell 1cm --yaws 4 --buffer 2")).summary;
    let used = &summary["settings"]["method"];
    assert_eq!((&used["buffer"], &used["seed"]), (&2.into(), &4.into()));
    for (text, named) in [
        ("bufer = 3", "bufer"),
        ("buffer = 0", "the buffer"),
        ("weights = { distance = nan }", "distance"),
        (
            "proposals = { from = \"tries\", yaws = 0, positions = 9 }",
            "yaws that are tried",
        ),
        ("heuristic = \"best\"", "line 1, column 13: "),
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
        refused(&pack, &["--method", named]);
    }
}

#[test]
fn an_arm_packs_what_it_can_reach_and_tells_its_cycle_times() {
    let run = |arm: &str| packed(&format!("pack --random 16 --seed 3 {arm}"));
    let without = run("");
    let summary = &without.summary;
    assert!(summary.get("arm").is_none() && summary["settings"]["method"].get("arm").is_none());
    assert!(!without.placements()[0].contains(&"cycle_s".to_owned()));
    assert!(!without.page().contains("Cycle"));

    let with = run("--arm nachi-mz07l");
    let (summary, arm) = (&with.summary, &with.summary["arm"]);
    let set_aside = arm["set_aside"].as_array().unwrap();
    let count = summary["items_placed"].as_u64().unwrap();
    assert!(count >= 4, "{summary}");
    assert_eq!(summary["items_in_sequence"], 16 - set_aside.len());
    assert!(!set_aside.is_empty());
    for item in set_aside {
        let reason = item["reason"].as_str().unwrap();
        assert!(reason.contains("cannot be picked"), "{item}");
    }
    let refused = arm["refused"].as_object().unwrap();
    let refused: u64 = refused.values().map(|count| count.as_u64().unwrap()).sum();
    assert!(arm["checks"].as_u64().unwrap() >= count + refused);
    let mean_s = arm["cycle_s"]["mean"].as_f64().unwrap();
    assert!((1.0..5.0).contains(&mean_s), "{mean_s}");
    let placements = with.placements();
    assert_eq!(placements[0].last().unwrap(), "cycle_s");
    let times_s = placements[1..].iter().map(|line| line.last().unwrap());
    let sum_s: f64 = times_s.map(|time_s| time_s.parse::<f64>().unwrap()).sum();
    assert!((sum_s / count as f64 - mean_s).abs() < 1e-6);
    let page = with.page();
    let parts = ["Cycle (s)", "cycle per item", "Set aside", "NACHI"];
    has(&page, &parts);

    // A container that is too far away: nothing can be placed, and each item has the reason.
    let folder = tempfile::tempdir().unwrap();
    let cell = folder.path().join("far.toml");
    std::fs::write(&cell, "base = { position_m = [-1.5, 0.16, 0.1] }").unwrap();
    let summary = run(&format!("--arm {} --set-aside 0", cell.display())).summary;
    assert_eq!(summary["items_placed"], 0);
    let reason = summary["ending"]["items"][0]["reason"].as_str().unwrap();
    has(reason, &["not possible for the arm", "reach"]);
}

#[test]
fn the_arms_are_listed_and_others_refused_with_their_names() {
    let listed = text(&ppnpack("pack --arm list"));
    let names: Vec<&str> = listed.lines().collect();
    assert!(names.contains(&"nachi-mz07l"), "{names:?}");
    let help = text(&ppnpack("pack --help"));
    assert!(names.iter().all(|name| help.contains(name)), "{help}");
    for command in ["pack", "up"] {
        let parts = ["r2d2", names[0], names[1]];
        refused(&format!("{command} --arm r2d2"), &parts);
    }
    let folder = tempfile::tempdir().unwrap();
    let cell = folder.path().join("cell.toml");
    for (text, named) in [
        ("[cell]\nclearance_mm = 3", "clearance_mm"),
        (
            "pick = { position_m = [1.0, 2.0, 300.0] }",
            "pick.position_m[2]",
        ),
        ("arm = \"absent.toml\"", "absent.toml"),
    ] {
        std::fs::write(&cell, text).unwrap();
        refused(&format!("pack --arm {}", cell.display()), &[named]);
    }
}

#[test]
fn people_read_the_figures_and_where_the_report_is() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().display();
    let told = text(&ppnpack(&format!("pack --items mug,bowl --out {out}")));
    let report = format!("Report: {out}/report.html");
    let parts = ["--items", "2 of 2 items", "everything is packed", &report];
    has(&told, &parts);
}

#[test]
fn objects_larger_than_the_container_are_named_as_such() {
    let summary = packed("pack --container 3x3x3cm --items tennis_ball").summary;
    assert_eq!(summary["items_placed"], 0);
    let item = &summary["set_aside"][0];
    assert_eq!(item["item"], "tennis_ball");
    has(item["reason"].as_str().unwrap(), &["too large"]);
}

#[test]
fn what_fits_nowhere_is_set_aside_and_the_packing_goes_on() {
    let items = "pack --container 12x12x12cm --items crisps_tube,tuna_can --buffer 1";
    let ended = packed(&format!("{items} --set-aside 0"));
    let summary = &ended.summary;
    assert_eq!(summary["items_placed"], 0);
    assert_eq!(summary["set_aside"], json!([]));
    assert_eq!(summary["ending"]["kind"], "nothing-fits");
    let page = ended.page();
    assert!(!page.contains("Set aside for the next container"));
    assert!(page.contains("it ended as crisps_tube, the last that waited, had no place"));
    assert!(page.contains("nothing was placed."));

    let went_on = packed(&format!("{items} --set-aside 2"));
    let summary = &went_on.summary;
    assert_eq!(summary["items_placed"], 1);
    assert_eq!(summary["ending"]["kind"], "others-set-aside");
    assert_eq!(summary["settings"]["set_aside"], 2);
    let set_aside = summary["set_aside"].as_array().unwrap();
    assert_eq!(set_aside.len(), 1);
    assert_eq!(set_aside[0]["arrival"], 0);
    assert_eq!(set_aside[0]["item"], "crisps_tube");
    let reason = set_aside[0]["reason"].as_str().unwrap();
    assert!(reason.contains("too large"), "{reason}");
    let page = went_on.page();
    let parts = [
        "<h2>Set aside for the next container",
        "1 of at most 2 items",
        "1 of 2 items is packed and the container is",
        "every item stayed where it was placed.",
    ];
    has(&page, &parts);
}

#[test]
fn an_item_that_is_too_high_as_it_stands_is_packed_lying() {
    let tube = "pack --container 26x12x10cm --items crisps_tube --poses";
    let run = |poses: &str| packed(&format!("{tube} {poses}"));
    assert_eq!(run("1").summary["items_placed"], 0);
    let lying = run("2");
    let summary = &lying.summary;
    assert_eq!(summary["items_placed"], 1);
    assert_eq!(summary["items_in_other_pose"], 1);
    assert_eq!(summary["settings"]["poses"], 2);
    let placements = lying.placements();
    assert_eq!([&*placements[0][3], &*placements[1][3]], ["pose", "1"]);
    let page = lying.page();
    assert!(page.contains("in another pose than that in which it was offered: 1 of 1 items"));
}
