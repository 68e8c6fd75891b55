//! The clock of the machine is set forwards and backwards while a container is packed.
//!
//! Only the time of day steps: it is what an administrator or a time service sets. libfaketime does it for the
//! processes of the stack alone; without it the test says so and is skipped.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a panic in a test is a failing test"
)]

mod common;

use std::path::{Path, PathBuf};
use std::time::Instant;

use common::{OBJECTS, assert_consistent, assert_serves_again};
use ppnpack_stack_tests::{Options, Signal, Stack};

/// Where Debian and others keep the library.
const LIBRARIES: [&str; 3] = [
    "/usr/lib/x86_64-linux-gnu/faketime/libfaketimeMT.so.1",
    "/usr/lib/aarch64-linux-gnu/faketime/libfaketimeMT.so.1",
    "/usr/lib/faketime/libfaketimeMT.so.1",
];

/// The clock of the processes that have its environment.
struct Clock(PathBuf);

impl Clock {
    /// Steps it to this far from the true time, such as `+1h`.
    fn step(&self, to: &str) {
        // Whole or not at all: processes read it at any time.
        let next = self.0.with_extension("next");
        std::fs::write(&next, format!("{to}\n")).unwrap();
        std::fs::rename(next, &self.0).unwrap();
    }

    fn environment(&self, library: &Path) -> Vec<(String, String)> {
        let file = self.0.display().to_string();
        let variables = [
            ("LD_PRELOAD", library.display().to_string()),
            ("FAKETIME_TIMESTAMP_FILE", file),
            ("FAKETIME_NO_CACHE", "1".to_owned()),
            ("FAKETIME_DONT_FAKE_MONOTONIC", "1".to_owned()),
        ];
        let variables = variables.into_iter();
        variables
            .map(|(name, value)| (name.to_owned(), value))
            .collect()
    }
}

#[test]
fn clock_steps_change_nothing() {
    let library = LIBRARIES.iter().map(Path::new).find(|path| path.is_file());
    let Some(library) = library else {
        eprintln!("skipped: libfaketime is not there; get it with: apt-get install libfaketime");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let clock = Clock(folder.path().join("clock"));
    clock.step("+0");
    let mut stack = Stack::start(&Options {
        environment: clock.environment(library),
        ..Options::default()
    })
    .unwrap();
    let cell = stack.cell(0).unwrap();
    cell.begin("clocks", &OBJECTS, false).unwrap();
    for step in ["+1h", "-2h", "+400d", "-400d"] {
        let decision = cell.plan().unwrap().unwrap();
        clock.step(step);
        assert_serves_again(
            &cell,
            Instant::now(),
            &format!("the clock stepped by {step}"),
        );
        let outcome = cell.place(&decision).unwrap();
        cell.report(&decision, outcome).unwrap();
        let next = cell.step().unwrap().unwrap();
        assert_eq!(next.degraded, Vec::<String>::new(), "{step}");
        assert_consistent(&cell, step);
    }
    // What is on disk is from the future then.
    clock.step("-401d");
    for name in ["planner-1", "bridge-1"] {
        stack.signal(name, Signal::Kill).unwrap();
        stack.restart(name).unwrap();
        stack.wait_ready(name).unwrap();
    }
    assert!(cell.step().unwrap().is_some());
    assert_consistent(&cell, "after a restart in the past");
}
