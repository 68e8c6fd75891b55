//! `ppnpack up`: the services in one process, over the real wire, against the same work without them.

use std::io::{Read, Write};
use std::net::TcpStream;

use serde_json::{Value, json};

use crate::support::{Packed, Running, command, fails, has, packed, ppnpack, text};

/// The placements of a report, without their times.
fn placements(packed: &Packed) -> Vec<Vec<String>> {
    let mut lines = packed.placements();
    for line in &mut lines {
        line.drain(9..=13);
    }
    lines
}

/// The poses of all items after each step, as a report plays them.
fn played(packed: &Packed) -> Vec<[Value; 3]> {
    let playback = packed.playback();
    let steps = playback["steps"].as_array().unwrap().iter();
    let steps = steps.map(|step| ["planned", "shifts", "gone"].map(|of| step[of].clone()));
    steps.collect()
}

/// Packs with these options alone and through the services, which has to go the same way.
fn both(options: &str) -> [Packed; 2] {
    let alone = packed(&format!("pack {options}"));
    let services = packed(&format!("up --pack {options}"));
    assert_eq!(services.summary["degraded"], json!([]));
    for part in ["floor_compactness", "packed", "items_in_other_pose"] {
        assert_eq!(services.summary[part], alone.summary[part], "{part}");
    }
    assert_eq!(placements(&services), placements(&alone));
    assert_eq!(played(&services), played(&alone));
    [alone, services]
}

#[test]
fn packing_through_the_services_is_packing_without_them() {
    both("--random 25 --seed 5");
}

#[test]
fn packing_with_an_arm_through_the_services_is_packing_without_them() {
    let [alone, services] = both("--arm nachi-mz07l --random 25 --seed 5");
    let [alone, services] = [&alone.summary, &services.summary];
    for part in ["cycle_s", "set_aside"] {
        assert_eq!(services["arm"][part], alone["arm"][part], "{part}");
    }
    assert!(alone["arm"]["checks"].as_u64() > alone["items_placed"].as_u64());
}

#[test]
fn poses_are_chosen_through_the_services_as_without_them() {
    // The tubes are too high to stand.
    let items = "crisps_tube,mug,tuna_can,crisps_tube,banana,bowl";
    let [alone, services] = both(&format!("--poses 3 --container 30x30x12cm --items {items}"));
    assert!(alone.summary["items_in_other_pose"].as_u64() > Some(0));
    assert_eq!(services.summary["settings"]["poses"], 3);
}

#[test]
fn a_stack_that_allows_fewer_poses_says_so() {
    let up = Running::up("--cells 2");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let pack = format!(
        "up --pack --connect {} --items mug --poses 2 --out {}",
        up.endpoint(),
        out.display()
    );
    let output = ppnpack(&pack);
    fails(&output, 1, &["poses: 2 where 1 is possible"]);
}

#[test]
fn packing_through_a_stack_that_already_runs_is_the_same_packing() {
    let up = Running::up("--cells 2");
    let alone = packed("pack --random 8");
    for time in ["once", "again"] {
        let through = packed(&format!("up --pack --connect {} --random 8", up.endpoint()));
        assert_eq!(through.summary["degraded"], json!([]));
        assert_eq!(placements(&through), placements(&alone), "{time}");
    }
}

#[test]
fn each_packing_with_a_store_is_into_an_empty_container() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("store");
    let pack = format!(
        "up --pack --store {} --cell 1cm --yaws 4 --random 6",
        store.display()
    );
    let first = packed(&pack);
    // What that packed is in the store.
    let again = packed(&pack);
    assert_eq!(again.summary["packed"], first.summary["packed"]);
    assert_eq!(again.summary["items_placed"], first.summary["items_placed"]);
    assert_eq!(placements(&again), placements(&first));
}

#[test]
fn what_two_cameras_see_together_is_packed_through_the_services() {
    let folder = tempfile::tempdir().unwrap();
    let view = folder.path().join("view.toml");
    std::fs::write(&view, "cameras = 2").unwrap();
    let grid = "--cell 1cm --yaws 4 --random 4";
    let summary = packed(&format!("up --pack --view {} {grid}", view.display())).summary;
    assert_eq!(summary["settings"]["simulated"]["camera"]["cameras"], 2);
    assert_eq!(summary["items_placed"], 4, "{summary}");
    assert_eq!(summary["degraded"], json!([]));
}

#[test]
fn the_operators_page_is_served_with_the_stack() {
    let options = "--cell 1cm --yaws 4 --console 127.0.0.1:0";
    let up = Running::up(options);
    let address = up.said("Console: ").strip_prefix("http://").unwrap();
    let mut stream = TcpStream::connect(address).unwrap();
    let request = format!("GET / HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    let mut page = String::new();
    stream.read_to_string(&mut page).unwrap();
    assert!(page.starts_with("HTTP/1.1 200 OK"), "{page}");

    let mut command = command(&format!("up {options} --listen tcp/127.0.0.1:0"));
    let refused = command.env("PPNPACK_CONSOLE_TOKEN", "too-short").output();
    let refused = refused.unwrap();
    fails(&refused, 2, &["token: 16 to 256"]);
}

#[test]
fn a_running_stack_is_seen_and_asked_by_hand() {
    let up = Running::up("--cells 2");
    let asked = |words: &str| ppnpack(&format!("{words} --connect {}", up.endpoint()));
    let status: Value = serde_json::from_str(&text(&asked("status --json"))).unwrap();
    let services = status.as_array().unwrap().iter();
    let services: Vec<&str> = services
        .map(|line| line["service"].as_str().unwrap())
        .collect();
    for service in ["bridge", "heuristic", "perception", "planner"] {
        assert!(services.contains(&service), "{services:?}");
    }
    let told = text(&asked("status"));
    let parts = ["what is wrong", "heuristic-1", "cell-1, cell-2", "any"];
    has(&told, &parts);
    text(&asked(
        r#"call planner begin {"session_id":"by-hand"} --cell cell-2"#,
    ));
    let items = r#"{"items":[{"item_id":"a","object":"mug"},{"item_id":"b","object":"bowl"}]}"#;
    text(&asked(&format!(
        "call planner announce {items} --cell cell-2"
    )));
    let plan: Value =
        serde_json::from_str(&text(&asked("call planner plan --cell cell-2"))).unwrap();
    assert_eq!(plan["result"], "PLAN_RESULT_DECIDED", "{plan}");
    // Cells know nothing of each other.
    let other = asked("call planner plan --cell cell-1");
    assert_eq!(other.status.code(), Some(1));
    let said: Value = serde_json::from_slice(&other.stdout).unwrap();
    assert_eq!(said["header"]["status"], "STATUS_CONFLICT", "{said}");
    let watched = text(&asked("watch --once --wait 3"));
    has(&watched, &["cell-1", "robot"]);
}

#[test]
fn nobody_there_is_said_with_a_remedy() {
    let output = ppnpack("call planner plan --connect tcp/127.0.0.1:9");
    fails(&output, 1, &["ppnpack up"]);
}
