//! The example controllers against a stack of real processes, with the planner killed on the way.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::process::beside;
use crate::stack::{Options, Stack};
use crate::tests::common::{OBJECTS, assert_consistent, slow_robot};

/// Runs a controller that packs 20 objects, and kills the planner when it has placed some.
fn packs_over_a_restart(mut controller: Command) {
    let mut stack = Stack::start(&slow_robot(Options::default())).unwrap();
    controller.args(["--connect", &stack.endpoint, "--session", "example"]);
    controller.args(&OBJECTS[..20]);
    let mut child = controller
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let mut said = Vec::new();
    for line in lines.by_ref().map(Result::unwrap) {
        let is_fifth = line.starts_with("step 4:");
        said.push(line);
        if is_fifth {
            stack.kill("planner-1").unwrap();
        }
    }
    let ended = child.wait_with_output().unwrap();
    let errors = String::from_utf8_lossy(&ended.stderr);
    let status = ended.status;
    assert!(status.success(), "{status}: {errors}\n{said:#?}");
    let last = said.last().unwrap();
    let packed: usize = last.split_whitespace().nth(1).unwrap().parse().unwrap();
    assert!(packed >= 15, "{last}");
    assert_consistent(&stack.cell(0).unwrap(), "at the end");
}

#[test]
fn the_controller_in_rust_packs_over_a_restart_of_the_planner() {
    let program = beside("ppnpack-example-controller").unwrap();
    packs_over_a_restart(Command::new(program));
}

#[test]
fn the_controller_in_python_packs_over_a_restart_of_the_planner() {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/python");
    let target = std::env::current_exe().unwrap();
    let environment = target.ancestors().nth(3).unwrap().join("tmp/python");
    let made = Command::new(example.join("setup"))
        .arg(&environment)
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&made.stderr);
    assert!(made.status.success(), "there is no environment: {errors}");
    let mut controller = Command::new(environment.join("bin/python"));
    controller.arg(example.join("cell_controller.py"));
    packs_over_a_restart(controller);
}
