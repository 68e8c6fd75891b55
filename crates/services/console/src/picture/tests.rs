use ppnpack_packing::kernel::grid::{Grid, Units};
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::scene::Scene;
use ppnpack_wire::convert;
use ppnpack_wire::keys::{Instance, Service};
use serde_json::{Value, json};

use super::*;
use crate::board::Board;

pub(super) fn cell(name: &str) -> Cell {
    Cell::new(name).unwrap()
}

fn pose(x_m: f64) -> Option<v1::Pose> {
    let pose = Isometry3::translation(x_m, 0.0, 0.0);
    Some(convert::pose::write(&pose))
}

pub(super) fn item(item_id: &str, object: &str, state: ItemState) -> v1::SessionItem {
    v1::SessionItem {
        item_id: item_id.to_owned(),
        object: object.to_owned(),
        state: state.into(),
        container_from_item: pose(0.1),
        ..v1::SessionItem::default()
    }
}

pub(super) fn session(items: Vec<v1::SessionItem>) -> v1::Session {
    v1::Session {
        session_id: "s".to_owned(),
        is_automatic: true,
        items,
        containers: vec![v1::SessionContainer {
            is_open: true,
            ..v1::SessionContainer::default()
        }],
        ..v1::Session::default()
    }
}

fn decision(decision_id: &str, item_id: &str) -> v1::Decision {
    v1::Decision {
        decision_id: decision_id.to_owned(),
        session_id: "s".to_owned(),
        item_id: item_id.to_owned(),
        object: "mug".to_owned(),
        container_from_item: pose(0.1),
        ..v1::Decision::default()
    }
}

/// The record of a session's step: the ids of its items, their objects, and what their shapes' ids
/// consist of.
pub(super) fn record(session_id: &str, items: &[(&str, &str, u8)]) -> v1::PlanningRecord {
    let indexed = || items.iter().zip(0_u64..);
    let items_told = indexed().map(|((item_id, object, _), arrival)| v1::RecordedItem {
        item_id: (*item_id).to_owned(),
        object: (*object).to_owned(),
        arrival,
    });
    let candidates = indexed().map(|((_, _, shape), arrival)| v1::RecordedCandidate {
        arrival,
        solid: vec![*shape; 32],
        ..v1::RecordedCandidate::default()
    });
    v1::PlanningRecord {
        session_id: session_id.to_owned(),
        items: items_told.collect(),
        candidates: candidates.collect(),
        ..v1::PlanningRecord::default()
    }
}

pub(super) fn found(service: Service, cells: &[&str]) -> Found {
    Found {
        service,
        instance: Instance::new("p1").unwrap(),
        cells: cells.iter().map(|name| cell(name)).collect(),
    }
}

pub(super) fn state(bodies: &[&str], hold: Option<&str>) -> v1::CellState {
    let body = |item_id: &&str| v1::Body {
        item_id: (*item_id).to_owned(),
        object: "mug".to_owned(),
        container_from_item: pose(0.2),
        is_inside: true,
        is_found: true,
    };
    v1::CellState {
        state_number: 1,
        is_simulated: true,
        bodies: bodies.iter().map(body).collect(),
        hold: hold.map(|reason| v1::Hold {
            reason: reason.to_owned(),
            ..v1::Hold::default()
        }),
        ..v1::CellState::default()
    }
}

/// What is seen of a container in a state, with one cell raised.
pub(super) fn seen(state_number: u64, height: Units) -> SeenContainer {
    let grid = Grid::reference();
    let mut heightmap = Heightmap::empty(&grid);
    heightmap.raise(1, 2, height);
    let scene = Scene::from_heightmap(heightmap);
    let message = v1::Heightmap {
        state_number,
        scene: Some(convert::scene::write(&grid, &scene)),
        ..v1::Heightmap::default()
    };
    SeenContainer::read(&message).unwrap()
}

/// A picture and what pages see of it.
#[derive(Default)]
struct Seen {
    picture: Picture,
    board: Board,
    at_ms: u64,
}

impl Seen {
    fn hear(&mut self, of: &str, news: News) -> Option<Wanted> {
        self.at_ms += 1_000;
        self.picture.apply(self.at_ms, &cell(of), news)
    }

    /// A part of the cell `c1`, or of its container of the same name.
    fn part(&self, container: Option<&str>, part: &'static str) -> Value {
        self.picture.show(&self.board, self.at_ms);
        let parts = self.board.since(0).parts;
        let mut parts = parts.iter().map(|text| serde_json::from_str(text).unwrap());
        let wanted = [json!("c1"), json!(container), json!(part)];
        let is_wanted =
            |it: &Value| ["cell", "container", "part"].map(|key| it[key].clone()) == wanted;
        let found = parts.find(is_wanted);
        found.map_or(Value::Null, |it| it["value"].clone())
    }

    fn state(&mut self, of: &str, bodies: &[&str], hold: Option<&str>) {
        self.hear(of, News::State(Box::new(state(bodies, hold))));
    }

    fn record(&mut self, item_id: &str) -> Option<Wanted> {
        let record = record("s", &[(item_id, "mug", 7)]);
        self.hear("c1", News::Record(Box::new(record)))
    }

    fn decision(&mut self, decision: v1::Decision) {
        self.hear("c1", News::Decision(Box::new(decision)));
    }

    fn session(&mut self, of: &str, session: v1::Session) {
        self.hear(of, News::Session(Box::new(session)));
    }

    fn kinds(&self, of: &str) -> Vec<&str> {
        self.picture.cells[&cell(of)].log.kinds()
    }
}

#[test]
fn a_step_is_seen_from_its_decision_to_the_item_in_the_container() {
    let mut page = Seen::default();
    let waiting = vec![item("i-1", "mug", ItemState::Waiting)];
    page.session("c1", session(waiting));
    page.state("c1", &[], None);
    page.hear("c1", News::Seen(Box::new(seen(1, 0))));
    let wanted = page.record("i-1").unwrap();
    let shape = ShapeId::from([7; 32]);
    assert_eq!(wanted.shapes, HashSet::from([shape]));
    assert!(page.picture.missing().is_empty(), "nothing lies there");
    page.picture
        .learn_volumes(4_500, vec![(shape, 0.32 * 0.32 * 0.3 / 8.0)]);
    let buffer = page.part(None, "buffer");
    assert_eq!(buffer["items"][0]["shape"], json!(shape.to_string()));
    page.decision(decision("d", "i-1"));
    let decided = page.part(None, "decisions");
    let position_m = |of: &Value| of["container_from_shape"]["position_m"].clone();
    assert_eq!(position_m(&decided[0]), json!([0.1, 0.0, 0.0]));
    assert_eq!(decided[0]["outcome"], Value::Null);
    let outcome = v1::Outcome {
        placement_id: "d".to_owned(),
        kind: v1::OutcomeKind::Placed.into(),
        ..v1::Outcome::default()
    };
    page.hear("c1", News::Outcome(Box::new(outcome)));
    page.state("c1", &["i-1"], None);
    let packed = vec![item("i-1", "mug", ItemState::Packed)];
    page.session("c1", session(packed));
    let decided = page.part(None, "decisions");
    assert_eq!(decided[0]["outcome"]["kind"], json!("placed"));
    assert_eq!(page.part(None, "cycles")["mean_took_s"], json!(1.0));
    let items = page.part(Some("c1"), "items");
    // The bridge says where it is now.
    assert_eq!(position_m(&items[0]), json!([0.2, 0.0, 0.0]));
    assert_eq!(items[0]["shape"], json!(shape.to_string()));
    let figures = page.part(Some("c1"), "figures");
    assert!((figures["utilisation"].as_f64().unwrap() - 0.125).abs() < 1e-12);
    let history = figures["history"].as_array().unwrap();
    assert_eq!(history.len(), 2, "{history:?}");
    assert_eq!(page.kinds("c1"), ["session", "decided", "placed"]);
}

#[test]
fn what_lies_in_a_real_cell_is_what_the_session_has_packed_into_the_container_that_stands_there() {
    let mut page = Seen::default();
    let mut packed = item("i-1", "mug", ItemState::Packed);
    packed.container_sequence = 1;
    let before = item("i-0", "mug", ItemState::Packed);
    let mut session = session(vec![before, packed]);
    session.containers[0].sequence = 1;
    page.session("c1", session);
    let real = v1::CellState {
        is_simulated: false,
        ..state(&[], None)
    };
    page.hear("c1", News::State(Box::new(real)));
    let items = page.part(Some("c1"), "items");
    assert_eq!(items.as_array().unwrap().len(), 1);
    assert_eq!(items[0]["item_id"], json!("i-1"));
    assert_eq!(items[0]["shape"], Value::Null, "no record told of it");
    page.record("i-1");
    let missing = page.picture.missing();
    let shape = ShapeId::from([7; 32]);
    assert_eq!(missing[0].shapes, HashSet::from([shape]));
    page.picture.learn_volumes(9_000, vec![(shape, 0.001)]);
    assert!(page.picture.missing().is_empty());
}

#[test]
fn containers_of_a_cell_are_shown_under_it_and_held_once() {
    let mut page = Seen::default();
    page.state("c1-a", &[], None);
    let alone = page.picture.directory();
    assert_eq!(alone[&cell("c1-a")].containers, [cell("c1-a")]);
    let mut session = session(Vec::new());
    session.containers = ["c1-a", "c1-b"]
        .map(|name| v1::SessionContainer {
            container: name.to_owned(),
            ..v1::SessionContainer::default()
        })
        .into();
    page.session("c1", session);
    let directory = page.picture.directory();
    assert_eq!(directory.len(), 1);
    assert_eq!(
        directory[&cell("c1")].containers,
        [cell("c1-a"), cell("c1-b")]
    );
    for (container, id) in [("c1-a", "h2"), ("c1-b", "h1")] {
        let mut held = state(&[], Some("a door is open"));
        held.holds = ["h0", id]
            .map(|id| v1::Hold {
                id: id.to_owned(),
                ..v1::Hold::default()
            })
            .into();
        page.hear(container, News::State(Box::new(held)));
    }
    let status = page.part(None, "status");
    assert_eq!(status["held"], json!("a door is open"));
    assert_eq!(status["holds"], json!(["h0", "h1", "h2"]));
    for container in ["c1-a", "c1-b"] {
        page.state(container, &[], None);
    }
    assert_eq!(page.part(None, "status")["held"], Value::Null);
    assert_eq!(page.kinds("c1"), ["session", "held", "resumed"]);
}

#[test]
fn a_container_of_which_something_happened_before_its_cell_was_heard_of_is_no_cell() {
    let mut page = Seen::default();
    // Its name comes before that of its cell.
    page.state("a", &[], Some("a door is open"));
    assert_eq!(page.kinds("a"), ["held"]);
    let mut session = session(Vec::new());
    session.containers[0].container = "a".to_owned();
    page.session("z", session);
    let directory = page.picture.directory();
    let cells: Vec<&Cell> = directory.keys().collect();
    assert_eq!(cells, [&cell("z")]);
    page.state("a", &[], None);
    assert_eq!(page.kinds("z"), ["session", "resumed"]);
}

#[test]
fn a_session_that_ends_and_what_is_taken_out_are_events() {
    let mut page = Seen::default();
    page.session("c1", session(Vec::new()));
    page.state("c1", &["i-1", "i-2"], None);
    page.state("c1", &["i-2"], None);
    let mut ended = session(Vec::new());
    ended.set_end(v1::SessionEnd::Failed);
    ended.failure = "it was lost".to_owned();
    ended.failure_id = "s-1".to_owned();
    ended.set_aside.push(v1::ItemReason {
        item_id: "i-3".to_owned(),
        ..v1::ItemReason::default()
    });
    page.session("c1", ended.clone());
    page.session("c1", ended);
    let kinds = ["session", "changed", "set_aside", "failed"];
    assert_eq!(page.kinds("c1"), kinds);
    assert_eq!(page.part(None, "status")["failure_id"], json!("s-1"));
}

#[test]
fn the_decision_that_awaits_its_outcome_is_known_from_the_session() {
    let mut page = Seen::default();
    let mut session = session(vec![item("i-1", "mug", ItemState::Decided)]);
    session.pending = Some(decision("d", "i-1"));
    page.session("c1", session);
    page.decision(decision("d", "i-1"));
    let decisions = page.part(None, "decisions");
    assert_eq!(decisions.as_array().unwrap().len(), 1);
    assert_eq!(page.part(None, "session")["pending"], json!("d"));
}

#[test]
fn a_decision_that_is_given_up_is_shown_so_and_one_that_came_to_something_is_not() {
    for (has_outcome, kinds) in [
        (false, &["session", "decided", "given_up"]),
        (true, &["session", "decided", "not_placed"]),
    ] {
        let mut page = Seen::default();
        let mut decided = session(vec![item("i-1", "mug", ItemState::Decided)]);
        decided.pending = Some(decision("d", "i-1"));
        page.session("c1", decided);
        if has_outcome {
            let outcome = v1::Outcome {
                placement_id: "d".to_owned(),
                kind: v1::OutcomeKind::NotPlaced.into(),
                ..v1::Outcome::default()
            };
            page.hear("c1", News::Outcome(Box::new(outcome)));
        }
        page.session("c1", session(vec![item("i-1", "mug", ItemState::Waiting)]));
        assert_eq!(page.kinds("c1"), kinds);
        let shown = page.part(None, "decisions");
        assert_eq!(shown[0]["is_given_up"], json!(!has_outcome));
    }
}

#[test]
fn the_times_of_steps_are_those_of_the_session() {
    let mut page = Seen::default();
    let before = v1::Decision {
        session_id: "before".to_owned(),
        ..decision("d-0", "i-0")
    };
    page.decision(before);
    // It may be heard of sooner than its session.
    page.decision(decision("d-1", "i-1"));
    page.session("c1", session(Vec::new()));
    let cycles = page.part(None, "cycles");
    assert_eq!(cycles["steps"].as_array().unwrap().len(), 1);
    let decisions = page.part(None, "decisions");
    assert_eq!(decisions.as_array().unwrap().len(), 2);
}

#[test]
fn what_is_heard_of_too_many_cells_is_left_out() {
    let mut picture = Picture::default();
    for number in 0..2 * MOST_CELLS {
        let name = cell(&format!("c{number}"));
        picture.apply(0, &name, News::Session(Box::default()));
        picture.apply(0, &name, News::State(Box::default()));
        picture.apply(0, &name, News::Decision(Box::default()));
    }
    let counts = [picture.cells.len(), picture.places.len()];
    assert_eq!(counts, [MOST_CELLS; 2]);
}

#[test]
fn a_cell_whose_planner_is_there_is_shown_before_it_says_anything() {
    let mut page = Seen::default();
    let planner = found(Service::Planner, &["c1"]);
    let health = v1::HealthReply::default();
    page.picture.look(0, vec![(planner, health)]);
    assert_eq!(page.part(None, "status")["doing"], json!("unknown"));
    page.picture.look(1, vec![]);
    assert_eq!(page.kinds("c1"), ["away"]);
}
