//! The smallest carton of an order, by command.

use std::fs;
use std::process::Output;

use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::catalogue::{Catalogue, Settings};
use ppnpack_packing::kernel::grid::{ContainerSize, Resolution};
use ppnpack_perception::extrinsics::Extrinsics;
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::settings::CellSettings;
use serde_json::Value;
use tempfile::TempDir;

use crate::support::{errors, has, json, ppnpack, text};

const CARTONS: &str = "name;x;y;z;unit;max_kg\nL;30;25;15;cm;\nS;9;9;9;cm;\nM;20;15;12;cm;\n";

/// An order and cartons in files.
struct Asked {
    folder: TempDir,
    options: &'static str,
}

impl Asked {
    fn new(order: &str, cartons: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("order.csv"), order).unwrap();
        fs::write(folder.path().join("cartons.csv"), cartons).unwrap();
        Self {
            folder,
            options: "--cell 5mm --yaws 8 --sequences 2",
        }
    }

    fn run(&self, further: &str) -> Output {
        let folder = self.folder.path().display();
        ppnpack(&format!(
            "carton --order {folder}/order.csv --cartons {folder}/cartons.csv {} {further}",
            self.options
        ))
    }

    fn answer(&self, further: &str) -> Value {
        json(&self.run(&format!("--json {further}")))
    }
}

/// What was printed by a command that ended with this code.
fn printed(output: &Output, code: i32) -> Value {
    assert_eq!(output.status.code(), Some(code), "{}", errors(output));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn an_order_gets_the_smallest_carton_that_takes_it_and_smaller_ones_their_reason() {
    let asked = Asked::new("object,count\ncrisps_tube,1\ntuna_can,1\n", CARTONS);
    let out = asked.folder.path().join("out");
    let answer = asked.answer(&format!("--out {}", out.display()));
    assert_eq!(answer["carton"]["name"], "L", "{answer}");
    let refused = answer["refused"].as_array().unwrap();
    let names: Vec<&Value> = refused.iter().map(|carton| &carton["name"]).collect();
    assert_eq!(names, ["S", "M"]);
    for carton in refused {
        assert_eq!(carton["kind"], "size", "{answer}");
        has(
            carton["reason"].as_str().unwrap(),
            &["crisps_tube", "too large"],
        );
    }
    // The tube has more than the height of the carton as it stands.
    let placements = answer["carton"]["placements"].as_array().unwrap();
    let tube = placements
        .iter()
        .find(|placed| placed["item"] == "crisps_tube");
    assert_ne!(tube.unwrap()["pose"], 0, "{answer}");
    let told = text(&asked.run(""));
    has(&told, &["too large", "takes all 2 items", "crisps_tube"]);
    for file in ["plan.json", "packed.png", "report.html", "placements.csv"] {
        assert!(out.join(file).exists(), "{file}");
    }
    let mut plan: Value =
        serde_json::from_slice(&fs::read(out.join("plan.json")).unwrap()).unwrap();
    assert_eq!(plan["carton"], answer["carton"]);
    plan["took_s"] = answer["took_s"].clone();
    assert_eq!(plan, answer);
}

#[test]
fn an_item_gets_the_carton_that_just_fits_it() {
    let item = "item\ntuna_can\n";
    let listed = json(&ppnpack("catalogue list --json"));
    let mut objects = listed.as_array().unwrap().iter();
    let can = objects.find(|object| object["name"] == "tuna_can").unwrap();
    let side_cm = |axis: usize| 100.0 * can["extents_m"][axis].as_f64().unwrap();
    let cartons = |more_cm: f64| {
        let [x, y, z] = [0, 1, 2].map(|axis| side_cm(axis) + more_cm);
        format!("{more_cm},{x},{y},{z},cm\n")
    };
    let lines = [-0.3, 0.5, 1.5].map(cartons).concat();
    let answer = Asked::new(item, &format!("name,x,y,z,unit\n{lines}")).answer("");
    assert_eq!(answer["carton"]["name"], "0.5", "{answer}");
    assert_eq!(answer["refused"][0]["left_out"][0]["item"], "tuna_can");
}

#[test]
fn an_order_that_fits_nowhere_fails_and_says_what_comes_closest_and_leaves_out_what() {
    let order = "item,quantity\ntuna_can,1\ncrisps_tube,1\n";
    let asked = Asked::new(order, "name,x,y,z,unit\nS,5,5,3,cm\nM,20,15,12,cm\n");
    let out = asked.folder.path().join("out");
    let output = asked.run(&format!("--json --out {}", out.display()));
    let answer = printed(&output, 1);
    assert_eq!(answer["carton"], Value::Null);
    assert_eq!(answer["closest"], "M");
    let left = answer["refused"][1]["left_out"].as_array().unwrap();
    assert_eq!((left.len(), &left[0]["item"]), (1, &"crisps_tube".into()));
    has(&errors(&output), &["M comes closest", "crisps_tube"]);
    assert!(!out.exists());
}

#[test]
fn what_does_not_go_in_together_is_left_out_by_every_sequence() {
    // Each fits alone, and both have less volume than the carton.
    let asked = Asked::new(
        "item,quantity\ntuna_can,2\n",
        "name,x,y,z,unit\none,9.5,9.5,5,cm\n",
    );
    let answer = printed(&asked.run("--json"), 1);
    let refused = &answer["refused"][0];
    assert_eq!(
        (&refused["kind"], &refused["sequences"]),
        (&"tried".into(), &1.into()),
        "{answer}"
    );
    assert_eq!(refused["left_out"].as_array().unwrap().len(), 1);
}

#[test]
fn limits_of_weight_and_volume_count() {
    let order = "item,quantity,mass_kg\ntuna_can,2,0.8\n";
    let cartons = "name,x,y,z,unit,max_kg\nlight,20,15,12,cm,1.5\nstrong,21,15,12,cm,1.7\n";
    let answer = Asked::new(order, cartons).answer("");
    assert_eq!(answer["carton"]["name"], "strong");
    let light = &answer["refused"][0];
    assert_eq!(light["kind"], "weight", "{answer}");
    has(light["reason"].as_str().unwrap(), &["1.60 kg", "1.50 kg"]);
    let many = Asked::new(
        "item,quantity\ntuna_can,40\n",
        "name,x,y,z,unit\nS,12,10,8,cm\n",
    );
    let answer = printed(&many.run("--json"), 1);
    assert_eq!(answer["refused"][0]["kind"], "volume", "{answer}");
}

#[test]
fn a_plan_that_is_done_again_has_all_items_inside() {
    let order = "item,quantity\nmug,2\nbanana,2\ntuna_can,1\ndice,1\n";
    let answer = Asked::new(order, CARTONS).answer("");
    let carton = &answer["carton"];
    let [x_m, y_m, z_m] = [0, 1, 2].map(|axis| carton["size_m"][axis].as_f64().unwrap());
    let settings = Settings {
        cache: CacheDir::Nowhere,
        ..Settings::default()
    };
    let source = ppnpack_household::source("builtin");
    let resolution = Resolution::reference();
    let catalogue = Catalogue::load(&source, &settings, &resolution, &|_, _| {}).unwrap();
    let mut cell = SimulatedCell::new(CellSettings {
        container: ContainerSize::cuboid(x_m, y_m, z_m),
        ..CellSettings::robot()
    })
    .unwrap();
    let placements = carton["placements"].as_array().unwrap();
    assert_eq!(placements.len(), 6, "{answer}");
    for placed in placements {
        let (_, object) = catalogue.find(placed["item"].as_str().unwrap()).unwrap();
        let pose: Extrinsics = serde_json::from_value(placed["placed"].clone()).unwrap();
        let report = cell.place(&object.model, &pose.pose().unwrap()).unwrap();
        assert!(report.inside && !report.toppled, "{placed}");
    }
    let contents = cell.contents();
    assert_eq!(contents.len(), 6);
    for body in contents {
        assert!(body.inside);
        let vertices = body.model.mesh.vertices.iter();
        let heights = vertices.map(|vertex| (body.container_from_item * vertex).z);
        assert!(heights.fold(0.0, f64::max) < z_m + 0.002);
    }
}

#[test]
fn the_same_seed_finds_the_same() {
    let asked = Asked::new("item,quantity\nmug,1\ntuna_can,2\ndice,1\n", CARTONS);
    let run = || {
        let mut answer = asked.answer("--seed 3");
        answer.as_object_mut().unwrap().remove("took_s");
        answer
    };
    assert_eq!(run(), run());
}

#[test]
fn one_of_several_orders_is_named() {
    let orders = "order,item,order_items\na,tuna_can,\nb,banana,3\n";
    let asked = Asked::new(orders, CARTONS);
    let folder = asked.folder.path().display();
    let of = |name: &str| {
        let cartons = format!("--cartons {folder}/cartons.csv --cell 5mm --yaws 8 --json");
        ppnpack(&format!(
            "carton --order {folder}/order.csv{name} {cartons}"
        ))
    };
    assert_eq!(json(&of(":a"))["order"], "a");
    for (name, parts) in [
        ("", ["behind a colon", "a, b"]),
        (":c", ["behind a colon", "a, b"]),
        (":b", ["said to have 3 items", "has 1"]),
    ] {
        crate::printed::is_refused(&of(name), &parts);
    }
}

#[test]
fn wrong_files_are_refused_with_line_and_column() {
    let (order, cartons) = ("item,quantity\nmug,1\n", "name,x,y,z\nS,0.3,0.2,0.1\n");
    for (order, cartons, parts) in [
        (
            "item,quantity\nmug,1\nunobtainium,1\n",
            cartons,
            ["order.csv, line 3", "unobtainium"],
        ),
        (
            "item,quantity\nmug,two\n",
            cartons,
            ["order.csv, line 2", "'quantity' has 'two'"],
        ),
        (
            "things\nmug\n",
            cartons,
            ["order.csv, line 2", "'item' is needed"],
        ),
        (
            order,
            "name,x,y\nS,1,1\n",
            ["cartons.csv, line 2", "'z' are needed"],
        ),
        (
            order,
            "name,x,y,z\nS,1,wide,1\n",
            ["cartons.csv, line 2", "'y' has 'wide'"],
        ),
        (
            order,
            "name,x,y,z\nS,30,20,10\n",
            ["cartons.csv, line 2", "'unit'"],
        ),
        (
            order,
            "name,x,y,z,max_kg\nS,1,1,1,-2\n",
            ["cartons.csv, line 2", "'max_kg' has -2"],
        ),
        (order, "name,x,y,z\n", ["cartons.csv", "no line"]),
        (
            order,
            "name,x,y,z\nS,0.001,0.1,0.1\n",
            ["carton 'S'", "cells"],
        ),
    ] {
        crate::printed::is_refused(&Asked::new(order, cartons).run(""), &parts);
    }
    let nowhere = "carton --order /nowhere.csv --cartons /nowhere.csv";
    crate::support::refused(nowhere, &["/nowhere.csv"]);
    let help = text(&ppnpack("carton --help"));
    has(&help, &["Examples:", "[default: 4]", "max_kg"]);
}
