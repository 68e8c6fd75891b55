//! The clock of the machine is set forwards and backwards while a container is packed.
//!
//! libfaketime does it for the processes of the stack alone; without it the test says so and is
//! skipped.

use std::time::Instant;

use crate::clock::{Clock, STEPS};
use crate::stack::Options;
use crate::tests::common::{OBJECTS, assert_consistent, assert_serves_again, skip, started};

#[test]
fn clock_steps_change_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let Some(clock) = Clock::new(folder.path()).unwrap() else {
        return skip("libfaketime is not there; get it with: apt-get install libfaketime");
    };
    let (mut stack, cell) = started(&Options {
        environment: clock.environment(),
        ..Options::default()
    });
    cell.begin("clocks", &OBJECTS, false).unwrap();
    for step in STEPS {
        let decision = cell.plan().unwrap().unwrap();
        clock.step(step).unwrap();
        let when = format!("the clock stepped by {step}");
        assert_serves_again(&cell, Instant::now(), &when);
        cell.carry_out(&decision).unwrap();
        let next = cell.step().unwrap().unwrap();
        assert_eq!(next.degraded, Vec::<String>::new(), "{step}");
        assert_consistent(&cell, step);
    }
    // The files on disk are from the future then.
    clock.step("-401d").unwrap();
    for name in ["planner-1", "bridge-1"] {
        stack.kill(name).unwrap();
        stack.wait_ready(name).unwrap();
    }
    assert!(cell.step().unwrap().is_some());
    assert_consistent(&cell, "after a restart in the past");
}
