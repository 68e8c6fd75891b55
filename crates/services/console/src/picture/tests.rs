use serde_json::{Value, json};

use super::*;
use crate::board::{Board, PartKey};

fn cell(name: &str) -> Cell {
    Cell::new(name).unwrap()
}

fn pose(x_m: f64) -> Option<v1::Pose> {
    Some(v1::Pose {
        position: Some(v1::Vector3 {
            x_m,
            ..v1::Vector3::default()
        }),
        orientation: Some(v1::Quaternion {
            w: 1.0,
            ..v1::Quaternion::default()
        }),
    })
}

fn item(item_id: &str, object: &str, state: ItemState) -> v1::SessionItem {
    v1::SessionItem {
        item_id: item_id.to_owned(),
        object: object.to_owned(),
        state: state.into(),
        container_from_item: pose(0.1),
        ..v1::SessionItem::default()
    }
}

fn session(items: Vec<v1::SessionItem>) -> v1::Session {
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

fn record(item_id: &str, object: &str, solid: u8) -> v1::PlanningRecord {
    v1::PlanningRecord {
        session_id: "s".to_owned(),
        items: vec![v1::RecordedItem {
            item_id: item_id.to_owned(),
            object: object.to_owned(),
            arrival: 0,
        }],
        candidates: vec![v1::RecordedCandidate {
            solid: vec![solid; 32],
            ..v1::RecordedCandidate::default()
        }],
        ..v1::PlanningRecord::default()
    }
}

fn state(bodies: &[&str], hold: Option<&str>) -> v1::CellState {
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
        }),
        ..v1::CellState::default()
    }
}

fn seen() -> SeenContainer {
    let grid = ppnpack_packing::grid::Grid::reference();
    let heightmap = ppnpack_packing::heightmap::Heightmap::empty(&grid);
    let scene = ppnpack_packing::heightmap::Scene::from_heightmap(heightmap);
    let message = v1::Heightmap {
        state_number: 1,
        scene: Some(ppnpack_wire::convert::scene::write(&grid, &scene)),
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

    fn part(&self, of: &str, container: Option<&str>, part: &'static str) -> Value {
        self.picture.show(&self.board, self.at_ms);
        let key = match container {
            Some(name) => PartKey::of_container(&cell(of), &cell(name), part),
            None => PartKey::of_cell(&cell(of), part),
        };
        let wanted = [key.cell, key.container].map(|name| json!(name.map(|name| name.to_string())));
        let parts = self.board.since(0).parts;
        let parts = parts
            .iter()
            .map(|text| serde_json::from_str::<Value>(text).unwrap());
        let mut parts =
            parts.filter(|it| [&it["cell"], &it["container"]] == [&wanted[0], &wanted[1]]);
        let found = parts.find(|it| it["part"] == json!(part));
        found.map_or(Value::Null, |it| it["value"].clone())
    }

    fn kinds(&self, of: &str) -> Vec<&str> {
        self.picture.cells[&cell(of)].log.kinds()
    }
}

#[test]
fn a_step_is_seen_from_its_decision_to_the_item_in_the_container() {
    let mut seen_here = Seen::default();
    let waiting = vec![item("i-1", "mug", ItemState::Waiting)];
    seen_here.hear("c1", News::Session(Box::new(session(waiting))));
    seen_here.hear("c1", News::State(Box::new(state(&[], None))));
    seen_here.hear("c1", News::Seen(Box::new(seen())));
    let wanted = seen_here
        .hear("c1", News::Record(Box::new(record("i-1", "mug", 7))))
        .unwrap();
    let shape = ShapeId::of_bytes(&[7; 32]).unwrap();
    assert_eq!(wanted.shapes, BTreeSet::from([shape]));
    assert!(seen_here.picture.missing().is_empty(), "nothing lies there");
    seen_here
        .picture
        .learn_volumes(4_500, vec![(shape, 0.32 * 0.32 * 0.3 / 8.0)]);
    assert_eq!(
        seen_here.part("c1", None, "buffer")["items"][0]["shape"],
        json!(shape.to_string())
    );
    seen_here.hear("c1", News::Decision(Box::new(decision("d", "i-1"))));
    let decided = seen_here.part("c1", None, "decisions");
    assert_eq!(
        decided[0]["container_from_shape"]["position_m"],
        json!([0.1, 0.0, 0.0])
    );
    assert_eq!(decided[0]["outcome"], Value::Null);
    let outcome = v1::Outcome {
        placement_id: "d".to_owned(),
        kind: v1::OutcomeKind::Placed.into(),
        ..v1::Outcome::default()
    };
    seen_here.hear("c1", News::Outcome(Box::new(outcome)));
    seen_here.hear("c1", News::State(Box::new(state(&["i-1"], None))));
    let packed = vec![item("i-1", "mug", ItemState::Packed)];
    seen_here.hear("c1", News::Session(Box::new(session(packed))));
    assert_eq!(
        seen_here.part("c1", None, "decisions")[0]["outcome"]["kind"],
        json!("placed")
    );
    assert_eq!(
        seen_here.part("c1", None, "cycles")["mean_took_s"],
        json!(1.0)
    );
    let items = seen_here.part("c1", Some("c1"), "items");
    // The bridge says where it is now.
    assert_eq!(
        items[0]["container_from_shape"]["position_m"],
        json!([0.2, 0.0, 0.0])
    );
    assert_eq!(items[0]["shape"], json!(shape.to_string()));
    let figures = seen_here.part("c1", Some("c1"), "figures");
    assert!((figures["utilisation"].as_f64().unwrap() - 0.125).abs() < 1e-12);
    let history = figures["history"].as_array().unwrap();
    assert_eq!(history.len(), 2, "{history:?}");
    assert_eq!(seen_here.kinds("c1"), ["session", "decided", "placed"]);
}

#[test]
fn what_lies_in_a_real_cell_is_what_the_session_has_packed_into_the_container_that_stands_there() {
    let mut seen_here = Seen::default();
    let mut packed = item("i-1", "mug", ItemState::Packed);
    packed.container_sequence = 1;
    let before = item("i-0", "mug", ItemState::Packed);
    let mut session = session(vec![before, packed]);
    session.containers[0].sequence = 1;
    seen_here.hear("c1", News::Session(Box::new(session)));
    let real = v1::CellState {
        is_simulated: false,
        ..state(&[], None)
    };
    seen_here.hear("c1", News::State(Box::new(real)));
    let items = seen_here.part("c1", Some("c1"), "items");
    let ids: Vec<&str> = items
        .as_array()
        .unwrap()
        .iter()
        .map(|it| it["item_id"].as_str().unwrap())
        .collect();
    assert_eq!(ids, ["i-1"]);
    assert_eq!(items[0]["shape"], Value::Null, "no record told of it");
    seen_here.hear("c1", News::Record(Box::new(record("i-1", "mug", 7))));
    let missing = seen_here.picture.missing();
    let shape = ShapeId::of_bytes(&[7; 32]).unwrap();
    assert_eq!(missing[0].shapes, BTreeSet::from([shape]));
    seen_here.picture.learn_volumes(9_000, vec![(shape, 0.001)]);
    assert!(seen_here.picture.missing().is_empty());
}

#[test]
fn containers_of_a_cell_are_shown_under_it_and_held_once() {
    let mut seen_here = Seen::default();
    seen_here.hear("c1-a", News::State(Box::new(state(&[], None))));
    let alone = seen_here.picture.directory();
    assert_eq!(alone[&cell("c1-a")].containers, [cell("c1-a")]);
    let mut session = session(Vec::new());
    session.containers = ["c1-a", "c1-b"]
        .map(|name| v1::SessionContainer {
            container: name.to_owned(),
            ..v1::SessionContainer::default()
        })
        .into();
    seen_here.hear("c1", News::Session(Box::new(session)));
    let directory = seen_here.picture.directory();
    assert_eq!(directory.len(), 1);
    assert_eq!(
        directory[&cell("c1")].containers,
        [cell("c1-a"), cell("c1-b")]
    );
    for container in ["c1-a", "c1-b"] {
        let held = state(&[], Some("a door is open"));
        seen_here.hear(container, News::State(Box::new(held)));
    }
    assert_eq!(
        seen_here.part("c1", None, "status")["held"],
        json!("a door is open")
    );
    for container in ["c1-a", "c1-b"] {
        seen_here.hear(container, News::State(Box::new(state(&[], None))));
    }
    assert_eq!(seen_here.part("c1", None, "status")["held"], Value::Null);
    assert_eq!(seen_here.kinds("c1"), ["session", "held", "resumed"]);
}

#[test]
fn a_container_of_which_something_happened_before_its_cell_was_heard_of_is_no_cell() {
    let mut seen_here = Seen::default();
    // Its name comes before that of its cell.
    seen_here.hear(
        "a",
        News::State(Box::new(state(&[], Some("a door is open")))),
    );
    assert_eq!(seen_here.kinds("a"), ["held"]);
    let mut session = session(Vec::new());
    session.containers[0].container = "a".to_owned();
    seen_here.hear("z", News::Session(Box::new(session)));
    let directory = seen_here.picture.directory();
    let cells: Vec<&Cell> = directory.keys().collect();
    assert_eq!(cells, [&cell("z")]);
    seen_here.hear("a", News::State(Box::new(state(&[], None))));
    assert_eq!(seen_here.kinds("z"), ["session", "resumed"]);
}

#[test]
fn a_session_that_ends_and_what_is_taken_out_are_events() {
    let mut seen_here = Seen::default();
    seen_here.hear("c1", News::Session(Box::new(session(Vec::new()))));
    seen_here.hear("c1", News::State(Box::new(state(&["i-1", "i-2"], None))));
    seen_here.hear("c1", News::State(Box::new(state(&["i-2"], None))));
    let mut ended = session(Vec::new());
    ended.set_end(v1::SessionEnd::Failed);
    ended.failure = "it was lost".to_owned();
    ended.set_aside.push(v1::ItemReason {
        item_id: "i-3".to_owned(),
        ..v1::ItemReason::default()
    });
    seen_here.hear("c1", News::Session(Box::new(ended.clone())));
    seen_here.hear("c1", News::Session(Box::new(ended)));
    assert_eq!(
        seen_here.kinds("c1"),
        ["session", "changed", "set_aside", "failed"]
    );
}

#[test]
fn the_decision_that_awaits_its_outcome_is_known_from_the_session() {
    let mut seen_here = Seen::default();
    let mut session = session(vec![item("i-1", "mug", ItemState::Decided)]);
    session.pending = Some(decision("d", "i-1"));
    seen_here.hear("c1", News::Session(Box::new(session)));
    seen_here.hear("c1", News::Decision(Box::new(decision("d", "i-1"))));
    let decisions = seen_here.part("c1", None, "decisions");
    assert_eq!(decisions.as_array().unwrap().len(), 1);
    assert_eq!(seen_here.part("c1", None, "session")["pending"], json!("d"));
}

#[test]
fn the_times_of_steps_are_those_of_the_session() {
    let mut seen_here = Seen::default();
    let before = v1::Decision {
        session_id: "before".to_owned(),
        ..decision("d-0", "i-0")
    };
    seen_here.hear("c1", News::Decision(Box::new(before)));
    // It may be heard of sooner than its session.
    seen_here.hear("c1", News::Decision(Box::new(decision("d-1", "i-1"))));
    seen_here.hear("c1", News::Session(Box::new(session(Vec::new()))));
    let cycles = seen_here.part("c1", None, "cycles");
    assert_eq!(cycles["steps"].as_array().unwrap().len(), 1);
    let decisions = seen_here.part("c1", None, "decisions");
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
    assert_eq!(
        (picture.cells.len(), picture.places.len()),
        (MOST_CELLS, MOST_CELLS)
    );
}

#[test]
fn a_cell_whose_planner_is_there_is_shown_before_it_says_anything() {
    let mut seen_here = Seen::default();
    seen_here.picture.look(
        0,
        vec![FoundService {
            service: ppnpack_wire::keys::Service::Planner,
            instance: ppnpack_wire::keys::Instance::new("p1").unwrap(),
            cells: vec![cell("c1")],
            health: Ok(Health::default()),
        }],
    );
    assert_eq!(
        seen_here.part("c1", None, "status")["doing"],
        json!("unknown")
    );
    seen_here.picture.look(1, vec![]);
    assert_eq!(seen_here.kinds("c1"), ["away"]);
}
