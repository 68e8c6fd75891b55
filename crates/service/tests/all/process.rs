//! The example `tiny` as a process: from its command line to its end.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, ChildStderr, Command, Output, Stdio};
use std::time::{Duration, Instant};

use ppnpack_service::alive::Alive;
use ppnpack_service::embedded::{self, hub, hub_at};
use ppnpack_service::rpc::Client;
use ppnpack_wire::keys::{Cell, Service};
use ppnpack_wire::v1::{HeightmapRequest, Status};

/// Runs the example, which cargo builds beside the tests.
fn tiny() -> Command {
    let test = std::env::current_exe().unwrap();
    let profile = test.parent().unwrap().parent().unwrap();
    let path = profile.join("examples/tiny");
    let remedy = "build it first: cargo build -p ppnpack-service --example tiny";
    assert!(path.exists(), "{remedy}");
    Command::new(path)
}

/// The program that asks in containers.
fn ask_health(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_ppnpack-healthcheck"))
        .args(arguments)
        .env_remove("PPNPACK__ADMIN__LISTEN")
        .output()
        .unwrap()
}

#[test]
fn a_health_check_of_no_address_is_refused() {
    assert_eq!(ask_health(&[]).status.code(), Some(64));
    assert_eq!(ask_health(&["nowhere"]).status.code(), Some(64));
}

fn run(arguments: &[&str]) -> Output {
    tiny().args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// A running `tiny`; killed if the test fails.
struct Tiny {
    child: Child,
    log: BufReader<ChildStderr>,
}

impl Drop for Tiny {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }
}

impl Tiny {
    fn start(endpoint: &str, more: &[&str]) -> Self {
        let connect = format!("zenoh.connect={endpoint}");
        let mut child = tiny()
            .args(["--set", &connect, "--set", "log.format=json"])
            .args(more.iter().flat_map(|assignment| ["--set", assignment]))
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let log = BufReader::new(child.stderr.take().unwrap());
        Self { child, log }
    }

    /// Reads the log up to a line with this message.
    fn await_line(&mut self, message: &str) -> serde_json::Value {
        loop {
            let mut line = String::new();
            let bytes = self.log.read_line(&mut line).unwrap();
            assert!(bytes > 0, "no line '{message}'");
            let line: serde_json::Value = serde_json::from_str(&line).unwrap();
            let own = line["message"].as_str();
            if own.is_some_and(|own| own.contains(message)) {
                return line;
            }
        }
    }

    /// The address of the admin port, once it is open.
    fn admin(&mut self) -> String {
        let opened = self.await_line("admin port open");
        opened["address"].as_str().unwrap().to_owned()
    }

    fn signal(&self, name: &str) {
        let id = self.child.id().to_string();
        let status = Command::new("kill").args([name, &id]).status();
        assert!(status.unwrap().success());
    }

    fn exit_code(&mut self) -> Option<i32> {
        self.child.wait().unwrap().code()
    }
}

fn get(address: &str, path: &str) -> (u16, String) {
    let mut stream = TcpStream::connect(address).unwrap();
    let request = format!("GET {path} HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    let status = head.split(' ').nth(1).unwrap();
    (status.parse().unwrap(), body.to_owned())
}

/// Asks until the status is as wanted. The port has no events.
fn await_status(address: &str, path: &str, wanted: u16) -> String {
    let deadline = Instant::now() + Duration::from_secs(20);
    loop {
        let (status, body) = get(address, path);
        if status == wanted {
            return body;
        }
        assert!(Instant::now() < deadline, "{path}: {status} {body}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_wrong_configuration_ends_with_64_before_a_port_is_opened() {
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let listen = format!("admin.listen={}", taken.local_addr().unwrap());
    for (arguments, code, parts) in [
        (
            &["--set", &listen, "--set", "zenoh.moed=client"][..],
            64,
            &["zenoh.moed", "--set zenoh.moed"][..],
        ),
        (&["--set", &listen], 1, &["admin port"]),
        (&["--no-such-option"], 64, &[]),
        (&["--set", "service.excuse=", "--validate-config"], 64, &[]),
        (&["--validate-config"], 0, &[]),
        (&["--help"], 0, &[]),
    ] {
        let output = run(arguments);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
        for part in parts {
            assert!(error.contains(part), "{part} is not in {error}");
        }
    }
}

#[test]
fn a_process_serves_and_ends_with_0() {
    let hub = hub().unwrap();
    let mut tiny = Tiny::start(hub.endpoint(), &["instance=t1"]);
    let address = tiny.admin();
    tiny.await_line("started");
    assert_eq!(get(&address, "/livez").0, 200);
    assert_eq!(get(&address, "/startupz").0, 200);
    let body = await_status(&address, "/readyz", 200);
    assert!(body.contains(r#"{"name":"zenoh","passes":true}"#), "{body}");
    let (_, info) = get(&address, "/info");
    let info: serde_json::Value = serde_json::from_str(&info).unwrap();
    assert_eq!(
        (&info["service"], &info["instance"]),
        (&"perception".into(), &"t1".into())
    );
    assert_eq!(info["configuration"].as_str().unwrap().len(), 16);

    let session = embedded::session(&hub).unwrap();
    let alive = Alive::watch(&session, Service::Perception).unwrap();
    let soon = Instant::now() + Duration::from_secs(20);
    assert!(alive.wait(soon, |now| now.len() == 1));
    let client = Client::new(&session);
    let cell = Cell::new("c1").unwrap();
    let error = client.call(&cell, HeightmapRequest::default(), soon);
    assert_eq!(error.unwrap_err().status(), Some(Status::Unavailable));
    let health = client.health(Service::Perception, &alive.instances()[0], soon);
    let health = health.unwrap();
    assert!(health.is_ready);
    let versions = health.header.unwrap().versions.unwrap();
    assert_eq!(info["configuration"], versions.configuration);
    let metrics = get(&address, "/metrics").1;
    let line = r#"ppnpack_requests_total{service="perception",method="heightmap",status="STATUS_UNAVAILABLE"} 1"#;
    assert!(metrics.contains(line), "{metrics}");

    tiny.signal("-TERM");
    tiny.await_line("shutting down");
    tiny.await_line("finished everything");
    assert_eq!(tiny.exit_code(), Some(0));
    assert!(alive.wait(soon, |now| now.is_empty()));
}

#[test]
fn a_process_tells_when_its_certificates_end() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("certificate.pem");
    std::fs::write(&path, include_str!("certificate.pem")).unwrap();
    let given = ["certificate", "root_ca"].map(|of| format!("zenoh.tls.{of}={}", path.display()));
    let mut tiny = Tiny::start("tls/127.0.0.1:1", &[&given[0], &given[1]]);
    let metrics = get(&tiny.admin(), "/metrics").1;
    for of in ["certificate", "root_ca"] {
        // As `openssl x509 -enddate` says: 16 July 2051, 14:53:59.
        let line = format!("ppnpack_certificate_ends{{of=\"{of}\"}} 2573132039");
        assert!(metrics.contains(&line), "{metrics}");
    }
    std::fs::write(&path, "no certificate").unwrap();
    let output = run(&["--validate-config", "--set", &given[0]]);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(64));
    let names_it = error.contains("zenoh.tls.certificate") && error.contains("is no certificate");
    assert!(names_it, "{error}");
}

#[test]
fn a_process_is_ready_again_when_the_router_is_back() {
    let first = hub().unwrap();
    let endpoint = first.endpoint().to_owned();
    let mut tiny = Tiny::start(&endpoint, &[]);
    let address = &tiny.admin();
    await_status(address, "/readyz", 200);
    assert_eq!(ask_health(&[address]).status.code(), Some(0));
    drop(first);
    let body = await_status(address, "/readyz", 503);
    assert!(body.contains("no connection to any of tcp/"), "{body}");
    let began = Instant::now();
    let second = hub_at(std::slice::from_ref(&endpoint)).unwrap();
    await_status(address, "/readyz", 200);
    let took = began.elapsed();
    assert!(took < Duration::from_secs(5), "{took:?}");
    // Its declarations are there again.
    let session = embedded::session(&second).unwrap();
    let alive = Alive::watch(&session, Service::Perception).unwrap();
    let soon = Instant::now() + Duration::from_secs(5);
    assert!(alive.wait(soon, |now| now.len() == 1));
    tiny.signal("-TERM");
    assert_eq!(tiny.exit_code(), Some(0));
}

#[test]
fn a_process_whose_router_is_away_for_long_ends_with_an_error() {
    let hub = hub().unwrap();
    let mut tiny = Tiny::start(hub.endpoint(), &[]);
    tiny.await_line("started");
    drop(hub);
    let began = Instant::now();
    let line = tiny.await_line("the process ends, to begin anew");
    // A cut of five seconds, and a second to connect again, end nobody.
    assert!(began.elapsed() > Duration::from_secs(6));
    let fault = line["fault"].as_str().unwrap();
    assert!(fault.contains("no connection to any of tcp/"), "{fault}");
    assert_eq!(tiny.exit_code(), Some(1));
}

#[test]
fn a_process_waits_for_a_router_and_is_not_ready() {
    let first = hub().unwrap();
    let endpoint = first.endpoint().to_owned();
    drop(first);
    let mut tiny = Tiny::start(&endpoint, &[]);
    let address = tiny.admin();
    assert_eq!(get(&address, "/livez").0, 200);
    let body = await_status(&address, "/readyz", 503);
    assert!(body.contains("zenoh"), "{body}");
    assert_eq!(get(&address, "/startupz").0, 503);
    let asked = ask_health(&[&address]);
    assert_eq!(asked.status.code(), Some(1));
    let reason = String::from_utf8_lossy(&asked.stderr);
    assert!(reason.contains("zenoh"), "{reason}");
    // It can be ended even now.
    tiny.signal("-INT");
    assert_eq!(tiny.exit_code(), Some(0));
}
