//! Leases over real sessions.

use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread::{self, JoinHandle};

use ppnpack_wire::keys::{Key, Start};
use zenoh::Wait;

use crate::embedded::{self, Hub};
use crate::process::Core;
use crate::shutdown::Shutdown;
use crate::supervision::Supervisor;

use super::*;

const PATIENCE: Duration = Duration::from_secs(60);

fn cell(name: &str) -> Option<Cell> {
    Some(Cell::new(name).unwrap())
}

fn name() -> Instance {
    Instance::new("bridge-1").unwrap()
}

/// A bridge that ends by itself; all have one name.
fn bridge(hub: &Hub, nonce: u64) -> Process {
    let supervisor = Supervisor::new(Shutdown::default());
    let mut core = Core::new(Service::Bridge, name(), String::new(), supervisor);
    core.nonce = nonce;
    let session = embedded::session(hub).unwrap();
    Process::new(session, ppnpack_wire::MAX_MESSAGE_BYTES, Arc::new(core)).unwrap()
}

/// The leases that a bridge takes, one cell after the other.
struct Taking {
    taken: Receiver<(Option<Cell>, Lease)>,
    thread: JoinHandle<Result<(), ServiceError>>,
}

impl Taking {
    fn start(process: &Process, cells: &[&str]) -> Self {
        let (taking, taken) = mpsc::channel();
        let cells: Vec<Option<Cell>> = cells.iter().map(|name| cell(name)).collect();
        let process = process.clone();
        let thread = thread::spawn(move || {
            take_each(&process, cells, |cell, lease| {
                let told = taking.send((cell.cloned(), lease));
                told.map_err(ServiceError::start)
            })
        });
        Self { taken, thread }
    }

    fn next(&self) -> (Option<Cell>, Lease) {
        self.taken.recv_timeout(PATIENCE).unwrap()
    }

    fn assert_nothing_for(&self, span: Duration) {
        let next = self.taken.recv_timeout(span).map(|(cell, _)| cell);
        assert_eq!(next, Err(RecvTimeoutError::Timeout));
    }
}

/// Waits until something is so; there is no event for it.
fn until(what: &str, is_so: impl Fn() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !is_so() {
        assert!(Instant::now() < deadline, "{what}: never");
        thread::sleep(Duration::from_millis(10));
    }
}

/// Waits until a process is told of another that serves: until then it would find the cell free.
fn until_told(process: &Process) {
    until("announced", || {
        let deadline = Instant::now() + LOOK_LIMIT;
        let found = alive::tokens(process.session(), Some(Service::Bridge), deadline);
        !found.unwrap().0.is_empty()
    });
}

fn until_it_waits(process: &Process) {
    let text = "another bridge, instance bridge-1, serves cell c1";
    until(text, || {
        let checks = process.health().report();
        checks.iter().any(|check| check.message.contains(text))
    });
    assert!(!process.health().is_ready());
}

#[test]
fn another_of_the_same_name_is_waited_for_while_free_cells_are_served() {
    let hub = embedded::hub().unwrap();
    let (first, second) = (bridge(&hub, 1), bridge(&hub, 2));
    let (of, lease) = Taking::start(&first, &["c1"]).next();
    assert_eq!((of, lease.is_after_another), (cell("c1"), false));

    until_told(&second);
    let taking = Taking::start(&second, &["c1", "c2"]);
    let (of, free) = taking.next();
    assert_eq!((of, free.is_after_another), (cell("c2"), false));
    until_it_waits(&second);
    taking.assert_nothing_for(PAUSE);
    drop(lease);
    let (of, followed) = taking.next();
    assert_eq!((of, followed.is_after_another), (cell("c1"), true));
    taking.thread.join().unwrap().unwrap();
    assert!(second.health().is_ready());

    // The first one is back, as after a cut, and knows nothing of what the second did.
    let latch = first.health().check("lease");
    let _back = Wanted::of(cell("c1")).take(&first, latch).unwrap();
    assert!(first.shutdown().wait_timeout(PATIENCE));
    let fault = first.supervisor().fault().unwrap();
    assert!(fault.contains("another bridge, instance bridge-1, serves cell c1"));
    assert_eq!(second.supervisor().fault(), None);
}

#[test]
fn of_two_that_start_together_exactly_one_stays() {
    let hub = embedded::hub().unwrap();
    let (first, later) = (bridge(&hub, 1), bridge(&hub, 2));
    // Both have found nobody, and neither watches yet when the other announces itself.
    let both = [&later, &first];
    let _tokens = both.map(|process| alive::announce(process, cell("c1").as_ref()).unwrap());
    let _watching = both.map(|process| watch(process, cell("c1"), 0).unwrap());
    assert!(later.shutdown().wait_timeout(PATIENCE));
    assert!(!first.shutdown().wait_timeout(ANSWER_LIMIT));
}

#[test]
fn a_predecessor_that_was_killed_is_waited_for_until_its_token_has_gone() {
    let hub = embedded::hub().unwrap();
    let start = Start { term: 0, nonce: 1 };
    let key = Key::Alive(cell("c1"), Service::Bridge, name(), start).to_string();
    let session = embedded::session(&hub).unwrap();
    let token = session.liveliness().declare_token(key).wait().unwrap();
    let waiting = bridge(&hub, 2);
    until_told(&waiting);
    let taking = Taking::start(&waiting, &["c1"]);
    taking.assert_nothing_for(ANSWER_LIMIT);
    drop(token);
    // It did not say that it works.
    assert!(!taking.next().1.is_after_another);
}

#[test]
fn who_waits_takes_nothing_over_while_the_router_is_away_and_comes_back() {
    let hub = embedded::hub().unwrap();
    let endpoint = hub.endpoint().to_owned();
    let (serving, waiting) = (bridge(&hub, 2), bridge(&hub, 1));
    let (_, _lease) = Taking::start(&serving, &["c1"]).next();
    until_told(&waiting);
    let taking = Taking::start(&waiting, &["c1"]);
    until_it_waits(&waiting);
    drop(hub);
    taking.assert_nothing_for(GONE_FOR + LOOK_LIMIT);
    let _hub = embedded::hub_at(&[endpoint]).unwrap();
    for process in [&serving, &waiting] {
        until("connected", || is_connected(process.session()));
    }
    taking.assert_nothing_for(GONE_FOR + LOOK_LIMIT);
    assert_eq!(serving.supervisor().fault(), None);
    waiting.shutdown().request();
    assert!(taking.thread.join().unwrap().is_err());
}

#[test]
fn two_starts_of_one_name_are_told_apart() {
    let supervisor = Supervisor::new(Shutdown::default());
    let started = || Core::new(Service::Bridge, name(), String::new(), supervisor.clone());
    assert_ne!(started().nonce, started().nonce);
}

#[test]
fn who_serves_all_cells_serves_each() {
    let (one, other) = (cell("c1"), cell("c2"));
    assert!(meet(one.as_ref(), one.as_ref()) && !meet(one.as_ref(), other.as_ref()));
    assert!(meet(None, one.as_ref()) && meet(one.as_ref(), None) && meet(None, None));
}
