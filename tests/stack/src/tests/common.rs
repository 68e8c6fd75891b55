//! What the tests of the stack share.

use std::time::{Duration, Instant};

use crate::cell::CellClient;
use crate::stack::Options;
use ppnpack_service::rpc::CallError;
use ppnpack_wire::keys::Service;
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::{self, ItemState, Status};

/// After a fault has ended, a fresh request succeeds within this time.
pub(crate) const RECOVERY: Duration = Duration::from_secs(5);

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

/// A stack with these settings.
pub(crate) fn with(settings: &[(Service, &str)]) -> Options {
    let settings = settings
        .iter()
        .map(|(of, setting)| (*of, (*setting).to_owned()));
    Options {
        settings: settings.collect(),
        ..Options::default()
    }
}

/// A robot that takes a moment for each placement, so that processes can be killed meanwhile.
pub(crate) fn slow_robot(mut options: Options) -> Options {
    for cell in options.cells.clone() {
        options.settings.push((
            Service::Bridge,
            format!("service.cells.{cell}.place_duration_s=0.15"),
        ));
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

/// That a decision was not carried out, for the state that the cell has now.
pub(crate) fn not_placed(cell: &CellClient) -> v1::Outcome {
    v1::Outcome {
        kind: v1::OutcomeKind::NotPlaced.into(),
        state_number: cell.state().unwrap().state_number,
        ..v1::Outcome::default()
    }
}

/// How many items of a session are in a state.
pub(crate) fn count(session: &v1::Session, state: ItemState) -> usize {
    session
        .items
        .iter()
        .filter(|item| item.state() == state)
        .count()
}

/// Prints how long after a fault something worked again; `docs/reliability.md` has the longest times.
pub(crate) fn assert_recovered(ended: Instant, when: &str) {
    let took = ended.elapsed();
    println!("recovered | {when} | {} ms", took.as_millis());
    assert!(took <= RECOVERY, "{when}: {took:?}");
}

/// A fresh request to planner, bridge and perception succeeds soon enough after a fault has ended.
pub(crate) fn assert_serves_again(cell: &CellClient, ended: Instant, when: &str) {
    assert_serves(cell, ended + RECOVERY, when);
    assert_recovered(ended, when);
}

/// A fresh request to planner, bridge and perception succeeds until then.
pub(crate) fn assert_serves(cell: &CellClient, until: Instant, when: &str) {
    ask_until(cell, &v1::SessionRequest::default(), until)
        .unwrap_or_else(|error| panic!("{when}: planner: {error}"));
    ask_until(cell, &v1::CellStateRequest::default(), until)
        .unwrap_or_else(|error| panic!("{when}: bridge: {error}"));
    ask_until(cell, &v1::HeightmapRequest::default(), until)
        .unwrap_or_else(|error| panic!("{when}: perception: {error}"));
}

/// Asks, and again where the service is busy, until then.
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

/// What planner and bridge know fits together; see [`CellClient::check_consistent`].
pub(crate) fn assert_consistent(cell: &CellClient, when: &str) {
    cell.check_consistent()
        .unwrap_or_else(|error| panic!("{when}: {error}"));
}

/// Packs what is left of a session.
pub(crate) fn finish(cell: &CellClient) {
    while cell.step().unwrap().is_some() {}
    assert_consistent(cell, "at the end");
}

/// Waits until a session is as wanted.
pub(crate) fn wait_for(cell: &CellClient, is_wanted: impl Fn(&v1::Session) -> bool) -> v1::Session {
    let until = Instant::now() + Duration::from_secs(60);
    loop {
        let session = cell.session().unwrap();
        if is_wanted(&session) {
            return session;
        }
        assert!(
            Instant::now() < until,
            "the session does not get there: {session:?}"
        );
        std::thread::sleep(Duration::from_millis(20));
    }
}
