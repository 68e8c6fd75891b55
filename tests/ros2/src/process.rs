//! Programs of ppnpack, ended with the test.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

/// The folder of the programs, where the environment's `PPNPACK_PROGRAMS` names no other one.
const PROGRAMS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../target/debug");

/// A running program.
pub struct Process {
    child: Child,
}

impl Drop for Process {
    fn drop(&mut self) {
        drop(self.child.kill());
        drop(self.child.wait());
    }
}

/// Starts a program.
///
/// # Panics
/// Where it cannot be started.
pub fn start(name: &str, arguments: &[&str]) -> Process {
    let (process, _) = spawn(name, arguments);
    process
}

/// Starts a stack of one simulated cell, `cell-1`, on a port of the system's choice, and waits
/// until it is ready; gives its endpoint.
///
/// # Panics
/// Where it does not start.
pub fn up(arguments: &[&str]) -> (Process, String) {
    let all = [
        "up",
        "--cell",
        "1cm",
        "--yaws",
        "4",
        "--listen",
        "tcp/127.0.0.1:0",
    ];
    let (process, output) = spawn("ppnpack", &[&all[..], arguments].concat());
    let mut endpoint = None;
    for line in output.lines() {
        let line = line.expect("what it prints is text");
        if let Some(at) = line.strip_prefix("Zenoh: ") {
            endpoint = Some(at.to_owned());
        }
        if line.starts_with("Ready") {
            return (process, endpoint.expect("it says where it is"));
        }
    }
    panic!("the stack did not start");
}

fn spawn(name: &str, arguments: &[&str]) -> (Process, BufReader<std::process::ChildStdout>) {
    let folder =
        std::env::var_os("PPNPACK_PROGRAMS").map_or_else(|| PathBuf::from(PROGRAMS), PathBuf::from);
    let program = folder.join(name);
    let mut child = Command::new(&program)
        .args(arguments)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap_or_else(|error| panic!("{}: {error}", program.display()));
    let output = child.stdout.take().expect("it is piped");
    (Process { child }, BufReader::new(output))
}
