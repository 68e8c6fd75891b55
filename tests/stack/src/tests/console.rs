//! The operator's page over real processes: its parts, its refusals, the time to hold a cell.

use std::io::Write;
use std::net::TcpStream;
use std::time::{Duration, Instant};

use crate::http::Watch;
use crate::process::Signal;
use crate::stack::{Options, Stack};
use crate::tests::common::{self, OBJECTS, count, slow_robot, started};
use ppnpack_wire::keys::Service;
use ppnpack_wire::v1::ItemState;
use serde_json::{Value, json};

const TOKEN: &str = "a-token-for-tests-0123456789";

/// The maximum time from a hold at the page until it says that the cell is held.
const HELD_WITHIN: Duration = Duration::from_millis(200);

/// The maximum time for a connection to ask for something.
const HALF_A_REQUEST: Duration = Duration::from_secs(5);

fn with_token(stack: &Stack, mut options: Options) -> Options {
    let path = stack.folder.path().join("token");
    std::fs::write(&path, TOKEN).unwrap();
    let setting = format!("service.token_file={}", path.display());
    options.settings.push((Service::Console, setting));
    options
}

fn stale(watch: &Watch) -> Vec<&str> {
    let stale = watch.part("cell-1", "status")["stale"].as_array();
    let stale = stale.into_iter().flatten();
    stale.filter_map(Value::as_str).collect()
}

fn is_held(watch: &Watch) -> bool {
    watch.part("cell-1", "status")["doing"] == json!("held")
}

fn kinds(watch: &Watch) -> Vec<&str> {
    let events = watch.part("cell-1", "events").as_array();
    let events = events.into_iter().flatten();
    events.filter_map(|event| event["kind"].as_str()).collect()
}

#[test]
fn a_packing_is_shown_and_a_planner_that_is_killed_is_missed_until_it_is_back() {
    let alternatives = "service.cells.cell-1.alternatives=2";
    let options = common::with(&[(Service::Planner, alternatives)]);
    let mut stack = Stack::start(&options).unwrap();
    let page = stack.add_console(1, &options).unwrap();
    let mut watch = page.watch().unwrap();
    watch.until("the cell", |it| !it.part("cell-1", "status").is_null());
    let cell = stack.cell(0).unwrap();
    cell.begin("shown", &OBJECTS[..6], true).unwrap();
    watch.until("the end of the packing", |it| {
        let session = it.part("cell-1", "session");
        session["end"] == json!("all_packed")
            && it.part("cell-1", "items").as_array().map(Vec::len) == Some(6)
    });
    watch.until("what was packed, with volumes and a picture of it", |it| {
        let figures = it.part("cell-1", "figures");
        figures["items_without_volume"] == json!(0) && figures["filled"].as_f64() > Some(0.0)
    });
    let decisions = watch.part("cell-1", "decisions").as_array().unwrap();
    assert_eq!(decisions.len(), 6);
    let mut outcomes = decisions
        .iter()
        .map(|decision| &decision["outcome"]["kind"]);
    assert!(outcomes.all(|kind| *kind == json!("placed")));
    let first = &decisions[5]["alternatives"];
    assert_eq!(first.as_array().unwrap().len(), 2, "{first}");
    let is_whole = first[0]["corner_m"].is_array() && first[0]["shape"].is_string();
    assert!(is_whole, "{first}");
    let utilisation = &watch.part("cell-1", "figures")["utilisation"];
    assert!(utilisation.as_f64() > Some(0.0));
    let steps = watch.part("cell-1", "cycles")["steps"].as_array();
    assert_eq!(steps.unwrap().len(), 6);
    assert_eq!(watch.part("cell-1", "status")["doing"], json!("ended"));

    let item = &watch.part("cell-1", "items")[0];
    assert!(item["container_from_shape"].is_object(), "{item}");
    let shape = item["shape"].as_str().unwrap();
    let triangles = page.get(&format!("/api/cells/cell-1/shapes/{shape}"));
    assert_eq!(triangles.status, 200);
    assert!(triangles.headers["cache-control"].contains("immutable"));
    let body = &triangles.body;
    let counts = [0, 4].map(|at| u32::from_le_bytes(body[at..at + 4].try_into().unwrap()));
    assert_eq!(body.len(), 8 + 12 * (counts[0] + counts[1]) as usize);
    let unknown = page.get(&format!("/api/cells/cell-1/shapes/{}", "0".repeat(64)));
    assert_eq!(unknown.error(), (404, "unknown_shape".to_owned()));

    assert_eq!(stale(&watch), Vec::<&str>::new());
    stack.signal("planner-1", Signal::SIGKILL).unwrap();
    watch.until("that the planner is away", |it| {
        let mut stale = stale(it).into_iter();
        stale.any(|sentence| sentence.contains("The planner has been away"))
    });
    assert_eq!(watch.part("cell-1", "status")["doing"], json!("unknown"));
    let heard_last = watch.part("cell-1", "items").as_array();
    assert_eq!(heard_last.unwrap().len(), 6);
    stack.restart("planner-1").unwrap();
    watch.until("that it is back", |it| {
        let kinds = kinds(it);
        stale(it).is_empty() && kinds.contains(&"away") && kinds.contains(&"back")
    });
    assert_eq!(watch.part("cell-1", "status")["doing"], json!("ended"));
    assert!(watch.beats > 0);
}

/// An order to go on, once the page shows that the cell is held for this reason.
fn seen(watch: &mut Watch, reason: &str) -> Value {
    let is_shown = |it: &Watch| {
        let held = it.part("cell-1", "status")["held"].as_str();
        held.is_some_and(|held| held.contains(reason))
    };
    watch.until("the hold", is_shown);
    let holds = &watch.part("cell-1", "status")["holds"];
    json!({"cell": "cell-1", "confirmed": true, "hold_ids": holds})
}

#[test]
fn controls_need_the_token_and_stop_a_cell_at_once() {
    let options = slow_robot(Options::default());
    let (mut stack, cell) = started(&options);
    let order = json!({"cell": "cell-1"});
    let confirmed = json!({"cell": "cell-1", "confirmed": true});

    let without = stack.add_console(1, &options).unwrap();
    let refused = without.with_token(TOKEN).control("hold", &order);
    assert_eq!(refused.error(), (403, "controls_off".to_owned()));

    let options = with_token(&stack, options);
    let page = stack.add_console(2, &options).unwrap();
    for (who, status) in [
        (page.clone(), 401),
        (page.with_token("another-token-0123456"), 401),
        (page.with_token(TOKEN), 200),
    ] {
        assert_eq!(who.control("check", &json!({})).status, status);
    }
    assert_eq!(page.control("hold", &order).status, 401);
    let held = || cell.state().unwrap().hold.is_some();
    assert!(!held(), "nothing was done without the token");
    let page = page.with_token(TOKEN);
    let mut watch = page.watch().unwrap();
    watch.until("the state", |it| it.part("cell-1", "state").is_object());

    let by_page = "held at the operator's page";
    let mut resumed = Value::Null;
    // Held and resumed several times, from the request to the page's own word that the cell is
    // held.
    let mut waits = Vec::new();
    for _ in 0..10 {
        let began = Instant::now();
        assert_eq!(page.control("hold", &order).status, 200);
        watch.until("the hold", is_held);
        waits.push(began.elapsed());
        assert!(held());
        let unconfirmed = page.control("resume", &order);
        assert_eq!(unconfirmed.status, 409);
        assert!(unconfirmed.json()["question"].is_string());
        assert!(held(), "nothing is done before it is confirmed");
        // On a page that is old another hold is shown.
        if !resumed.is_null() {
            let stale = page.control("resume", &resumed);
            assert_eq!(stale.error(), (409, "refused".to_owned()));
        }
        resumed = seen(&mut watch, by_page);
        assert_eq!(page.control("resume", &resumed).status, 200);
        watch.until("the resumption", |it| {
            let parts = ["state", "status"].map(|part| it.part("cell-1", part));
            parts.iter().all(|part| part["held"].is_null())
        });
    }
    waits.sort_unstable();
    let (median, worst) = (waits[waits.len() / 2], waits[waits.len() - 1]);
    let [median_ms, worst_ms] = [median, worst].map(|wait| wait.as_millis());
    println!("held | median {median_ms} ms | worst {worst_ms} ms");
    assert!(median <= HELD_WITHIN, "{waits:?}");

    // A step makes one placement, and the cell is held after it.
    assert_eq!(page.control("resume", &confirmed).status, 400);
    assert_eq!(page.control("hold", &order).status, 200);
    cell.begin("steps", &OBJECTS[..6], true).unwrap();
    let step = seen(&mut watch, by_page);
    let stepped = page.control("step", &step);
    assert_eq!(stepped.status, 200, "{:?}", stepped.json());
    common::wait_for(&cell, |session| count(session, ItemState::Packed) == 1);
    assert!(cell.state().unwrap().hold.is_some());

    // What is taken out by hand is gone from the container that the page shows.
    let removed = json!({"cell": "cell-1", "item_ids": ["item-0", "item-1", "item-2", "item-3", "item-4", "item-5"]});
    let answer = page.control("removed", &removed);
    assert_eq!(answer.status, 200, "{:?}", answer.json());
    watch.until("the empty container", |it| {
        it.part("cell-1", "items") == &json!([])
    });
    assert_eq!(page.control("touched", &order).status, 200);
    let items = cell.session().unwrap().items;
    let mut last_first = items.iter().rev();
    let waiting = last_first.find(|item| item.state() == ItemState::Waiting);
    let withdrawn = json!({"cell": "cell-1", "item_ids": [waiting.unwrap().item_id]});
    assert_eq!(page.control("withdraw", &withdrawn).status, 200);
    assert_eq!(count(&cell.session().unwrap(), ItemState::Withdrawn), 1);

    // Another container is brought once the cell goes on, and packed.
    common::wait_for(&cell, |session| session.pending.is_none());
    assert_eq!(page.control("new_container", &order).status, 409);
    let renewed = page.control("new_container", &confirmed);
    assert_eq!(renewed.status, 200, "{:?}", renewed.json());
    let stepped = seen(&mut watch, "as were asked for");
    assert_eq!(page.control("resume", &stepped).status, 200);
    common::wait_for(&cell, |session| {
        session.containers[0].sequence == 1 && session.containers[0].is_open
    });
    let off = json!({"cell": "cell-1", "is_on": false});
    assert_eq!(page.control("automatic", &off).status, 200);
    assert!(!cell.session().unwrap().is_automatic);
    let on = json!({"cell": "cell-1", "is_on": true});
    assert_eq!(page.control("automatic", &on).status, 409);

    let long = json!({"cell": "cell-1", "reason": "x".repeat(20_000)});
    for (action, body, status) in [
        ("dance", json!({"cell": "cell-1"}), 404),
        ("hold", json!({"cell": "elsewhere"}), 404),
        ("hold", json!({"cell": "cell-1", "colour": "red"}), 400),
        ("removed", json!({"cell": "cell-1"}), 400),
        ("hold", long, 413),
    ] {
        let answer = page.control(action, &body);
        assert_eq!(answer.status, status, "{action} {body}");
    }
}

#[test]
fn connections_on_which_nobody_asks_hold_up_no_hold() {
    let mut stack = Stack::start(&Options::default()).unwrap();
    let options = with_token(&stack, Options::default());
    let page = stack.add_console(1, &options).unwrap();
    let mut watch = page.watch().unwrap();
    watch.until("the state", |it| it.part("cell-1", "state").is_object());
    let half = |_| {
        let mut stream = TcpStream::connect(page.address).unwrap();
        stream.write_all(b"POST /api/control/ho").unwrap();
        stream
    };
    let halves: Vec<TcpStream> = (0..300).map(half).collect();
    let began = Instant::now();
    let held = page.with_token(TOKEN);
    let held = held.control("hold", &json!({"cell": "cell-1"}));
    assert_eq!(held.status, 200, "{:?}", held.json());
    // It did not wait for them to be over.
    assert!(began.elapsed() < HALF_A_REQUEST, "{:?}", began.elapsed());
    watch.until("the hold", is_held);
    drop(halves);
}

#[test]
fn the_page_is_its_own_and_bounded() {
    let options = Options::default();
    let mut stack = Stack::start(&options).unwrap();
    let page = stack.add_console(1, &options).unwrap();
    let index = page.get("/");
    assert_eq!(index.status, 200);
    assert!(index.headers["content-type"].starts_with("text/html"));
    let policy = &index.headers["content-security-policy"];
    for part in ["default-src 'none'", "connect-src 'self'"] {
        assert!(policy.contains(part), "{policy}");
    }
    let script = page.get("/main.js");
    let content = &script.headers["content-type"];
    assert_eq!(content, "text/javascript; charset=utf-8");
    let shape = "/api/cells/cell-1/shapes/x";
    for path in ["/nothing.js", "/api", "/%2e%2e/secret", shape] {
        let missing = page.get(path);
        assert_eq!(missing.status, 404, "{path}");
        assert!(missing.json()["error"].is_string());
    }
    assert_eq!(page.get("/api/control/hold").status, 405);
    let foreign = page.get_of_host("/api/state", "evil.example");
    assert_eq!(foreign.error(), (403, "other_host".to_owned()));
    let state = page.get("/api/state");
    assert_eq!(state.headers["cache-control"], "no-store");
    assert!(!state.json()["parts"].as_array().unwrap().is_empty());

    // More pages than may be are sent away, and let in again when one has gone.
    let mut pages: Vec<Watch> = (0..32).map(|_| page.watch().unwrap()).collect();
    let more = page.get("/api/events");
    assert_eq!(more.error(), (503, "too_many".to_owned()));
    pages.pop();
    common::until(|| page.watch().map_err(|error| error.to_string()));
}
