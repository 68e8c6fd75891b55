//! The clock of the machine is set forwards and backwards while a container is packed.
//!
//! Only the time of day steps: it is what an administrator or a time service sets. libfaketime does it for the
//! processes of the stack alone; without it the test says so and is skipped.

use std::time::Instant;

use crate::clock::Clock;
use crate::process::Signal;
use crate::stack::{Options, Stack};
use crate::tests::common::{OBJECTS, assert_consistent, assert_serves_again, skip};

#[test]
fn clock_steps_change_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let Some(clock) = Clock::new(folder.path()).unwrap() else {
        return skip("libfaketime is not there; get it with: apt-get install libfaketime");
    };
    let mut stack = Stack::start(&Options {
        environment: clock.environment(),
        ..Options::default()
    })
    .unwrap();
    let cell = stack.cell(0).unwrap();
    cell.begin("clocks", &OBJECTS, false).unwrap();
    for step in ["+1h", "-2h", "+400d", "-400d"] {
        let decision = cell.plan().unwrap().unwrap();
        clock.step(step).unwrap();
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
    clock.step("-401d").unwrap();
    for name in ["planner-1", "bridge-1"] {
        stack.signal(name, Signal::Kill).unwrap();
        stack.restart(name).unwrap();
        stack.wait_ready(name).unwrap();
    }
    assert!(cell.step().unwrap().is_some());
    assert_consistent(&cell, "after a restart in the past");
}
