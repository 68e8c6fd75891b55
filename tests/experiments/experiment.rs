//! The experiments end to end.

use std::path::Path;

use serde_json::Value;

use super::ranges::is_the_same_as_ranges;
use super::sequences::sequences;
use super::{is_refused, json, page, ppnpack, text};

#[test]
fn the_experiments_and_the_commands_of_ppnpack_are_listed() {
    let help = text(&ppnpack("experiment --help"));
    for name in ["table1", "pareto", "physical"] {
        assert!(help.contains(name), "{help}");
    }
    assert!(help.contains("Usage: ppnpack experiment"), "{help}");
    assert!(text(&ppnpack("--help")).contains("  pack "));
}

#[test]
fn files_that_are_not_there_are_named() {
    for (command, file) in [
        ("experiment table1 --sequences", "/nowhere.npy"),
        ("train --dataset", "/nowhere"),
    ] {
        is_refused(&ppnpack(&format!("{command} {file}")), &[file]);
    }
}

#[test]
fn an_interrupted_experiment_goes_on_where_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let sequences = sequences(folder.path(), [2, 6], 90);
    let out = folder.path().join("out");
    let table = |chosen: &str| {
        let (sequences, out) = (sequences.display(), out.display());
        let asked = format!("table1 --sequences {sequences} --cases 2 --out {out} --json");
        ppnpack(&format!("experiment {asked} {chosen}"))
    };
    let made = |chosen: &str| {
        let printed = json(&table(chosen));
        assert_eq!(printed["origin"]["version"], env!("CARGO_PKG_VERSION"));
        page("tables", &out.join("table1.json"), &[]).1
    };
    let run = || made("--grids coarse");
    // Beside a build with libtorch there is a row for the network too.
    let line = |results: &Value, method: &str| {
        let lines = results["lines"].as_array().unwrap();
        let line = lines.iter().find(|line| line["method"] == method);
        line.unwrap().clone()
    };
    let first = run();
    assert!(first["lines"].as_array().unwrap().len() >= 6);
    // The bounded search packs what the search of all placements packs.
    let bounded = &first["bounded"].as_array().unwrap()[..];
    assert_eq!(bounded.len(), 1);
    for packed in ["items", "meshes_cm3", "floor_compactness_percent"] {
        assert_eq!(bounded[0][packed], line(&first, "SDFM")[packed], "{packed}");
    }
    for compared in [&line(&first, "SDFM"), &bounded[0]] {
        assert_eq!(compared["difference"]["items"]["mean"], 0.0);
    }
    // A run that was cut short is done again; the others are taken from the disk, decision times
    // included.
    let of_sdfm = |settings: &Path| {
        let text = std::fs::read_to_string(settings.join("settings.json")).unwrap();
        text.contains("\"name\":\"SDFM\"")
    };
    let ways = out.join("runs").read_dir().unwrap();
    let mut ways = ways.map(|way| way.unwrap().path());
    let cut = ways.find(|way| of_sdfm(way)).unwrap().join("00001.json");
    assert!(cut.exists());
    std::fs::write(&cut, b"{").unwrap();
    let second = run();
    assert_eq!(line(&first, "Random"), line(&second, "Random"));
    let items = |results: &Value| line(results, "SDFM")["items"].clone();
    assert_eq!(items(&first), items(&second));
    assert!(std::fs::metadata(&cut).unwrap().len() > 10);
    // One method beside the search that all are compared with.
    let one = made("--methods hm-bbox");
    assert_eq!(one["lines"].as_array().unwrap().len(), 2);
    for method in ["HM (BBox)", "SDFM"] {
        assert_eq!(line(&one, method), line(&second, method));
    }
    is_refused(&table("--methods hm"), &["hm-bbox"]);
}

#[test]
fn a_network_of_a_class_that_is_not_there_is_named_before_anything_is_packed() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().display();
    let asked = format!("table2 --irregular-model /nowhere.safetensors --out {out}");
    is_refused(&ppnpack(&format!("experiment {asked}")), &["/nowhere"]);
    assert_eq!(folder.path().read_dir().unwrap().count(), 0);
}

#[test]
fn regular_and_irregular_objects_are_packed_apart() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().display();
    let asked = format!("experiment table2 --cases 2 --length 5 --out {out}");
    let printed = text(&ppnpack(&asked));
    let path = folder.path().join("table2.json");
    let command = format!("python experiments/tables.py {}", path.display());
    assert!(printed.contains(&command), "{printed}");
    let (_, results) = page("tables", &path, &[]);
    let classes = results["classes"].as_array().unwrap();
    assert_eq!(classes.len(), 2);
    let names = |class: &Value| -> Vec<String> {
        serde_json::from_value(class["objects"].clone()).unwrap()
    };
    let (regular, irregular) = (names(&classes[0]), names(&classes[1]));
    assert!(regular.len() > 3 && irregular.len() > 3);
    assert!(regular.iter().all(|name| !irregular.contains(name)));
    let lines = results["lines"].as_array().unwrap();
    for class in ["regular", "irregular"] {
        let mut of_class = lines.iter().filter(|line| line["class"] == class);
        let search = of_class.next_back().unwrap();
        assert_eq!(search["cases"], 2);
        let ratio = search["floor_compactness_ratio_percent"]["mean"].as_f64();
        assert_eq!(ratio, Some(100.0));
        assert!(search["items"]["mean"].as_f64().unwrap() > 0.0);
    }
}

/// On a coarse grid, placements pass a geometric test and are not tried.
const UNTRIED: &str = r#"[{"name": "untried", "grid": {"cell_m": 0.01, "yaws": 4},
    "method": {"proposals": {"from": "bounded"}, "stability": "physical", "trial": {"tries_per_item": 0}}}]"#;

#[test]
fn comparisons_are_the_same_as_ranges() {
    let folder = tempfile::tempdir().unwrap();
    let sequences = sequences(folder.path(), [3, 5], 90);
    let sequences = sequences.display();
    for experiment in [
        "table1 --methods dbl-bbox --grids coarse",
        "pareto --grids coarse --shares 5",
    ] {
        let packed = format!("{experiment} --sequences {sequences}");
        is_the_same_as_ranges(&packed, "--cases", [0, 3]);
    }
    is_the_same_as_ranges("table4 --length 6", "--cases", [0, 4]);
}

#[test]
fn a_value_is_the_same_as_learned_by_ranges() {
    let folder = tempfile::tempdir().unwrap();
    // The first hundred sequences are the tests', of which nothing may be learned.
    let sequences = sequences(folder.path(), [110, 3], 90);
    let sequences = sequences.display();
    let value = format!("value --cell 1cm --yaws 4 --sequences {sequences}");
    is_the_same_as_ranges(&value, "--cases", [100, 10]);
}

#[test]
fn fillings_loads_streams_and_boxes_are_the_same_as_ranges() {
    let folder = tempfile::tempdir().unwrap();
    let sequences = sequences(folder.path(), [3, 5], 90);
    // Results are named by the file.
    let method = folder.path().join("filling.json");
    std::fs::write(&method, UNTRIED).unwrap();
    let orders = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/orders.csv");
    let (packed, orders) = (sequences.display(), orders.display());
    let method = method.display();
    let filling = format!("filling --physics own,apart --methods {method} --sequences {packed}");
    is_the_same_as_ranges(&filling, "--cases", [0, 3]);
    let loads = format!("loads --margins 1.5 --method {method} --sequences {packed}");
    is_the_same_as_ranges(&loads, "--cases", [0, 3]);
    let streams = format!("stream --open 1 --method {method} --orders {orders}");
    is_the_same_as_ranges(&streams, "--streams", [0, 2]);
    // Twenty instances are a run.
    is_the_same_as_ranges("boxes --methods dbl,snug", "--instances", [0, 40]);
}

#[test]
fn orders_are_packed_one_at_a_time_and_together() {
    let folder = tempfile::tempdir().unwrap();
    let orders = folder.path().join("orders.csv");
    // Boxes, which lie flat side by side: all fit into one container, in whatever order they come.
    let boxes = "order,item,quantity,order_items\na,pudding_box,2,\nb,sardine_tin,2,\nc,soap_bar,1,3\nd,toy_brick,2,\n";
    std::fs::write(&orders, boxes).unwrap();
    let method = folder.path().join("method.json");
    std::fs::write(&method, UNTRIED).unwrap();
    let out = folder.path().join("out");
    let (orders, method) = (orders.display(), method.display());
    text(&ppnpack(&format!(
        "experiment stream --orders {orders} --streams 1 --open 1 --method {method} --out {}",
        out.display()
    )));
    let (table, results) = page("stream", &out.join("stream.json"), &[]);
    let [apart, together] = [0, 1].map(|line| &results["lines"][line]);
    assert_eq!(apart["closed_by"]["order complete"], 3);
    // One of them has more items than come.
    assert_eq!(apart["complete_percent"], 75.0);
    assert_eq!(together["complete_percent"], 75.0);
    assert_eq!(apart["used"]["mean"], 4.0);
    assert_eq!(together["used"]["mean"], 1.0);
    assert_eq!(together["in_one_container_percent"], 100.0);
    assert!(table.contains("| 1, one order at a time | 4.0"), "{table}");
}

#[test]
fn a_line_of_orders_that_is_wrong_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let orders = folder.path().join("orders.csv");
    std::fs::write(&orders, "order,item\na,mug\na,samovar\n").unwrap();
    let output = ppnpack(&format!("experiment stream --orders {}", orders.display()));
    is_refused(&output, &["line 3", "samovar"]);
}

#[test]
fn boxes_are_packed_by_every_method_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let asked = format!(
        "experiment boxes --instances 3 --rollouts 6 --out {}",
        out.display()
    );
    let run = || {
        text(&ppnpack(&asked));
        let (table, mut results) = page("boxes", &out.join("boxes.json"), &[]);
        assert!(table.contains("## Setting 2") && table.contains("| DBL | "));
        // That says when.
        let origin = results.as_object_mut().unwrap().remove("origin");
        let origin = origin.unwrap();
        assert!(origin["command"].as_str().unwrap().contains("boxes"));
        results
    };
    let results = run();
    let lines = results["lines"].as_array().unwrap();
    let methods = ["dbl", "hm", "sdfm", "mta", "snug", "look-ahead"];
    for (index, line) in lines.iter().enumerate() {
        assert_eq!(line["setting"], ["1", "2"][index / methods.len()]);
        assert_eq!(line["method"], methods[index % methods.len()]);
        let percent = line["utilisation_percent"]["mean"].as_f64().unwrap();
        assert!((20.0..=100.0).contains(&percent), "{line}");
    }
    assert_eq!(lines.len(), 2 * methods.len());
    // Times and all: the runs are taken from the disk.
    assert_eq!(run(), results);
}
