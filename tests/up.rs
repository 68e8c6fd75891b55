//! `ppnpack up`: the services in one process, over the real wire, against the same work without them.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use serde_json::Value;

fn ppnpack(arguments: &[&str]) -> Command {
    let cache: PathBuf = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cache");
    let mut command = Command::new(env!("CARGO_BIN_EXE_ppnpack"));
    command.args(arguments).env("XDG_CACHE_HOME", cache);
    command
}

fn json(output: &Output) -> Value {
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The placements of a report, without their times.
fn placements(folder: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(folder.join("placements.csv")).unwrap();
    let lines = text.lines().map(|line| {
        let fields = line.split(',').map(str::to_owned).enumerate();
        fields
            .filter(|(index, _)| !(9..=13).contains(index))
            .map(|(_, field)| field)
            .collect()
    });
    lines.collect()
}

/// How everything lay after each step, as a report plays it.
fn played(folder: &Path) -> Vec<[Value; 3]> {
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    let (_, data) = page.split_once("id=playback-data>").unwrap();
    let (data, _) = data.split_once("</script>").unwrap();
    let playback: Value = serde_json::from_str(data).unwrap();
    let steps = playback["steps"].as_array().unwrap().iter();
    let steps = steps.map(|step| ["planned", "shifts", "gone"].map(|of| step[of].clone()));
    steps.collect()
}

#[test]
fn packing_through_the_services_is_packing_without_them() {
    let folder = tempfile::tempdir().unwrap();
    let out = |name: &str| folder.path().join(name);
    let run = |how: &[&str], name: &str| {
        let sequence = ["--random", "25", "--seed", "5", "--json", "--out"];
        let mut command = ppnpack(how);
        json(&command.args(sequence).arg(out(name)).output().unwrap())
    };
    let alone = run(&["pack"], "alone");
    let services = run(&["up", "--pack"], "services");
    assert_eq!(services["floor_compactness"], alone["floor_compactness"]);
    assert_eq!(services["packed"], alone["packed"]);
    assert_eq!(services["degraded"], serde_json::json!([]));
    assert_eq!(placements(&out("services")), placements(&out("alone")));
    assert_eq!(played(&out("services")), played(&out("alone")));
}

#[test]
fn packing_with_an_arm_through_the_services_is_packing_without_them() {
    let folder = tempfile::tempdir().unwrap();
    let out = |name: &str| folder.path().join(name);
    let run = |how: &[&str], name: &str| {
        let sequence = ["--arm", "nachi-mz07l", "--random", "25", "--seed", "5"];
        let mut command = ppnpack(how);
        command.args(sequence).args(["--json", "--out"]);
        json(&command.arg(out(name)).output().unwrap())
    };
    let alone = run(&["pack"], "alone");
    let services = run(&["up", "--pack"], "services");
    assert_eq!(services["degraded"], serde_json::json!([]));
    assert_eq!(services["arm"]["cycle_s"], alone["arm"]["cycle_s"]);
    assert_eq!(services["arm"]["set_aside"], alone["arm"]["set_aside"]);
    assert!(alone["arm"]["checks"].as_u64() > alone["items_placed"].as_u64());
    assert_eq!(placements(&out("services")), placements(&out("alone")));
}

#[test]
fn poses_are_chosen_through_the_services_as_without_them() {
    let folder = tempfile::tempdir().unwrap();
    let out = |name: &str| folder.path().join(name);
    let run = |how: &[&str], name: &str| {
        let items = "crisps_tube,mug,tuna_can,crisps_tube,banana,bowl";
        let mut command = ppnpack(how);
        // The tubes are too high to stand.
        command.args(["--poses", "3", "--container", "30x30x12cm"]);
        command.args(["--items", items, "--json", "--out"]);
        json(&command.arg(out(name)).output().unwrap())
    };
    let alone = run(&["pack"], "alone");
    let services = run(&["up", "--pack"], "services");
    assert!(alone["items_in_other_pose"].as_u64() > Some(0));
    assert_eq!(
        services["items_in_other_pose"],
        alone["items_in_other_pose"]
    );
    assert_eq!(services["settings"]["poses"], 3);
    assert_eq!(services["degraded"], serde_json::json!([]));
    assert_eq!(placements(&out("services")), placements(&out("alone")));
}

#[test]
fn a_stack_that_allows_fewer_poses_says_so() {
    let up = up();
    let folder = tempfile::tempdir().unwrap();
    let mut command = ppnpack(&["up", "--pack", "--connect", up.endpoint.as_str()]);
    command.args(["--items", "mug", "--poses", "2", "--out"]);
    let output = command.arg(folder.path().join("out")).output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.contains("poses: 2 where 1 is possible"), "{error}");
}

#[test]
fn packing_through_a_stack_that_already_runs_is_the_same_packing() {
    let up = up();
    let folder = tempfile::tempdir().unwrap();
    let out = |name: &str| folder.path().join(name);
    let run = |how: &[&str], name: &str| {
        let sequence = ["--random", "8", "--json", "--out"];
        let mut command = ppnpack(how);
        json(&command.args(sequence).arg(out(name)).output().unwrap())
    };
    run(&["pack"], "alone");
    let connect = ["up", "--pack", "--connect", up.endpoint.as_str()];
    for name in ["once", "again"] {
        assert_eq!(run(&connect, name)["degraded"], serde_json::json!([]));
        assert_eq!(placements(&out(name)), placements(&out("alone")), "{name}");
    }
}

#[test]
fn what_two_cameras_see_together_is_packed_through_the_services() {
    let folder = tempfile::tempdir().unwrap();
    let view = ["--view", "camera", "--cameras", "2"];
    let grid = ["--cell", "1cm", "--yaws", "4", "--random", "4", "--json"];
    let mut command = ppnpack(&["up", "--pack"]);
    let out = folder.path().join("out");
    let packed = command.args(view).args(grid).arg("--out").arg(out).output();
    let report = json(&packed.unwrap());
    assert_eq!(report["items_placed"], 4, "{report}");
    assert_eq!(report["degraded"], serde_json::json!([]));
}

/// A running `ppnpack up`, ended with the test.
struct Up {
    child: Child,
    endpoint: String,
    /// What it printed until it was ready.
    lines: Vec<String>,
}

impl Up {
    /// What it printed behind a word.
    fn said(&self, word: &str) -> Option<&str> {
        let mut lines = self.lines.iter();
        lines.find_map(|line| line.strip_prefix(word))
    }
}

impl Drop for Up {
    fn drop(&mut self) {
        drop(self.child.kill());
        drop(self.child.wait());
    }
}

fn up() -> Up {
    up_with(&["--cells", "2"])
}

fn up_with(options: &[&str]) -> Up {
    let mut child = ppnpack(&["up", "--listen", "tcp/127.0.0.1:0"])
        .args(options)
        .stdout(Stdio::piped())
        .stderr(Stdio::inherit())
        .spawn()
        .unwrap();
    let printed = BufReader::new(child.stdout.take().unwrap()).lines();
    let printed = printed.map(|line| line.unwrap());
    let mut up = Up {
        child,
        endpoint: String::new(),
        lines: printed
            .take_while(|line| !line.starts_with("Ready"))
            .collect(),
    };
    up.endpoint = up.said("Zenoh: ").unwrap().to_owned();
    up
}

#[test]
fn the_operators_page_is_served_with_the_stack() {
    let coarse = ["--cell", "1cm", "--yaws", "4"];
    let up = up_with(&[&coarse[..], &["--console", "127.0.0.1:0"]].concat());
    let url = up.said("Console: ").unwrap();
    let address = url.strip_prefix("http://").unwrap();
    let mut stream = TcpStream::connect(address).unwrap();
    let request = format!("GET / HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    let mut page = String::new();
    stream.read_to_string(&mut page).unwrap();
    assert!(page.starts_with("HTTP/1.1 200 OK"), "{page}");

    let mut command = ppnpack(&[
        "up",
        "--console",
        "127.0.0.1:0",
        "--listen",
        "tcp/127.0.0.1:0",
    ]);
    let refused = command
        .args(coarse)
        .env("PPNPACK_CONSOLE_TOKEN", "too-short")
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{error}");
    assert!(error.contains("token: 16 to 256"), "{error}");
}

#[test]
fn a_running_stack_is_seen_and_asked_by_hand() {
    let up = up();
    let connect = ["--connect", &up.endpoint];
    let status = json(
        &ppnpack(&["status", "--json"])
            .args(connect)
            .output()
            .unwrap(),
    );
    let services: Vec<&str> = status
        .as_array()
        .unwrap()
        .iter()
        .map(|line| line["service"].as_str().unwrap())
        .collect();
    for service in ["bridge", "heuristic", "perception", "planner"] {
        assert!(services.contains(&service), "{services:?}");
    }
    let call = |arguments: &[&str]| ppnpack(arguments).args(connect).output().unwrap();
    json(&call(&[
        "call",
        "planner",
        "begin",
        r#"{"session_id": "by-hand"}"#,
        "--cell",
        "cell-2",
    ]));
    let items =
        r#"{"items": [{"item_id": "a", "object": "mug"}, {"item_id": "b", "object": "bowl"}]}"#;
    json(&call(&[
        "call", "planner", "announce", items, "--cell", "cell-2",
    ]));
    let plan = json(&call(&["call", "planner", "plan", "--cell", "cell-2"]));
    assert_eq!(plan["result"], "PLAN_RESULT_DECIDED", "{plan}");
    // Cells know nothing of each other.
    let other = call(&["call", "planner", "plan", "--cell", "cell-1"]);
    assert_eq!(other.status.code(), Some(1));
    let said: Value = serde_json::from_slice(&other.stdout).unwrap();
    assert_eq!(said["header"]["status"], "STATUS_CONFLICT", "{said}");
    let watched = call(&["watch", "--once", "--wait", "3"]);
    let text = String::from_utf8_lossy(&watched.stdout);
    assert!(text.contains("cell-1") && text.contains("robot"), "{text}");
}

#[test]
fn nobody_there_is_said_with_a_remedy() {
    let output = ppnpack(&["call", "planner", "plan", "--connect", "tcp/127.0.0.1:9"])
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.contains("ppnpack up"), "{error}");
}
