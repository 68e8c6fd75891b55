//! Settings, waits and assertions that the tests of the stack share.

use std::time::{Duration, Instant};

use crate::cell::CellClient;
use crate::stack::{Options, Stack};
use ppnpack_service::rpc::CallError;
use ppnpack_wire::keys::Service;
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::{self, ItemState, SessionEnd, Status};

/// The maximum time from the end of a fault until a fresh request succeeds.
pub(crate) const RECOVERY: Duration = Duration::from_secs(5);

/// The maximum time of any wait.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);

/// The instances of a stack without a network, clients first.
pub(crate) const INSTANCES: [&str; 5] = [
    "planner-1",
    "heuristic-1",
    "perception-1",
    "bridge-1",
    "router",
];

/// Objects of the built-in catalogue, small ones among them, so that many fit.
#[rustfmt::skip]
pub(crate) const OBJECTS: [&str; 40] = [
    "dice", "fork", "spoon", "table_knife", "large_marker", "scissors", "strawberry",
    "toy_brick", "espresso_cup", "plum", "phillips_screwdriver", "flat_screwdriver", "pliers",
    "wrench", "padlock", "tumbler", "lemon", "phone", "banana", "clamp", "tennis_ball", "mug",
    "toothpaste_tube", "soap_bar", "light_bulb", "sardine_tin", "gelatin_box", "puzzle_cube",
    "tuna_can", "tape_measure", "spice_jar", "tape_roll", "remote_control", "avocado", "pear",
    "apple", "flashlight", "orange", "glue_bottle", "potato",
];

pub(crate) fn with(settings: &[(Service, &str)]) -> Options {
    let settings = settings
        .iter()
        .map(|(of, setting)| (*of, (*setting).to_owned()));
    Options {
        settings: settings.collect(),
        ..Options::default()
    }
}

/// Starts a stack; gives a client for its first cell too.
pub(crate) fn started(options: &Options) -> (Stack, CellClient) {
    let stack = Stack::start(options).unwrap();
    let cell = stack.cell(0).unwrap();
    (stack, cell)
}

/// A robot that takes a moment for each placement, so that processes can be killed meanwhile.
pub(crate) fn slow_robot(mut options: Options) -> Options {
    for cell in &options.cells {
        let slow = format!("service.cells.{cell}.place_duration_s=0.15");
        options.settings.push((Service::Bridge, slow));
    }
    options
}

/// Names the test that is skipped, and why; fails where `CI` is set.
pub(crate) fn skip(why: &str) {
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    assert!(std::env::var_os("CI").is_none(), "{test}: {why}");
    eprintln!("skipped: {test}: {why}");
}

/// The outcome of a decision that was not carried out, in the state that the cell has now.
pub(crate) fn not_placed(cell: &CellClient) -> v1::Outcome {
    v1::Outcome {
        kind: v1::OutcomeKind::NotPlaced.into(),
        state_number: cell.state().unwrap().state_number,
        ..v1::Outcome::default()
    }
}

pub(crate) fn count(session: &v1::Session, state: ItemState) -> usize {
    let items = session.items.iter();
    items.filter(|item| item.state() == state).count()
}

pub(crate) fn count_packed(cell: &CellClient) -> usize {
    count(&cell.session().unwrap(), ItemState::Packed)
}

/// Looks until something is found; fails with what was seen last.
pub(crate) fn until<T>(look: impl FnMut() -> Result<T, String>) -> T {
    within(PATIENCE, look)
}

/// Looks within a time, as [`until`] does.
pub(crate) fn within<T>(limit: Duration, mut look: impl FnMut() -> Result<T, String>) -> T {
    let end = Instant::now() + limit;
    loop {
        match look() {
            Ok(found) => return found,
            Err(seen) => assert!(Instant::now() < end, "after {limit:?} still {seen}"),
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Asserts that a request is refused with a status; gives the refusal.
pub(crate) fn refused<R: Request>(cell: &CellClient, request: R, status: Status) -> CallError {
    match cell.ask(request) {
        Ok(_) => panic!("not refused with {status:?}"),
        Err(error) => {
            assert_eq!(error.status(), Some(status), "{error}");
            error
        }
    }
}

/// Asserts that a step was planned without a service, and says so.
pub(crate) fn assert_degraded(decision: &v1::Decision, without: &str) {
    let degraded = &decision.degraded;
    assert!(degraded[0].contains(without), "{degraded:?}");
}

/// Prints the time from the end of a fault until something worked again, and checks it;
/// `docs/reliability.md` has the longest times.
pub(crate) fn assert_recovered(ended: Instant, when: &str) {
    let took = ended.elapsed();
    println!("recovered | {when} | {} ms", took.as_millis());
    assert!(took <= RECOVERY, "{when}: {took:?}");
}

/// Asserts that fresh requests to planner, bridge and perception succeed soon after a fault.
pub(crate) fn assert_serves_again(cell: &CellClient, ended: Instant, when: &str) {
    assert_serves(cell, ended + RECOVERY, when);
    assert_recovered(ended, when);
}

/// Asserts that fresh requests to planner, bridge and perception succeed until then.
pub(crate) fn assert_serves(cell: &CellClient, until: Instant, when: &str) {
    ask_until(cell, &v1::SessionRequest::default(), until)
        .unwrap_or_else(|error| panic!("{when}: planner: {error}"));
    assert_serves_container(cell, until, when);
}

/// Asserts that fresh requests to bridge and perception succeed until then.
pub(crate) fn assert_serves_container(cell: &CellClient, until: Instant, when: &str) {
    ask_until(cell, &v1::CellStateRequest::default(), until)
        .unwrap_or_else(|error| panic!("{when}: bridge: {error}"));
    ask_until(cell, &v1::HeightmapRequest::default(), until)
        .unwrap_or_else(|error| panic!("{when}: perception: {error}"));
}

/// Asks until then, again while the service is busy.
fn ask_until<R: Request + Clone>(
    cell: &CellClient,
    request: &R,
    until: Instant,
) -> Result<R::Reply, CallError> {
    loop {
        let left = until.saturating_duration_since(Instant::now());
        match cell.ask_within(request.clone(), left) {
            Err(error) if error.status() == Some(Status::Busy) && Instant::now() < until => {
                std::thread::sleep(Duration::from_millis(5));
            }
            result => return result,
        }
    }
}

/// Asserts that planner and bridge agree; see [`CellClient::check_consistent`].
pub(crate) fn assert_consistent(cell: &CellClient, when: &str) {
    cell.check_consistent()
        .unwrap_or_else(|error| panic!("{when}: {error}"));
}

pub(crate) fn finish(cell: &CellClient) {
    while cell.step().unwrap().is_some() {}
    assert_consistent(cell, "at the end");
}

pub(crate) fn wait_for(cell: &CellClient, is_wanted: impl Fn(&v1::Session) -> bool) -> v1::Session {
    until(|| {
        let session = cell.session().unwrap();
        match is_wanted(&session) {
            true => Ok(session),
            false => Err(format!("{session:?}")),
        }
    })
}

pub(crate) fn wait_for_end(cell: &CellClient) -> v1::Session {
    wait_for(cell, |session| session.end != 0)
}

pub(crate) fn wait_until_packed(cell: &CellClient) -> v1::Session {
    let session = wait_for_end(cell);
    assert_eq!(session.end(), SessionEnd::AllPacked, "{}", session.failure);
    session
}
