//! Journals of every version, kept in `formats/`, are read and gone on with.
//!
//! `PPNPACK_RECORD=1` writes those that are missing. One that is there stays as it is: the program of its version wrote it.

use std::collections::BTreeMap;
use std::fs;

use nalgebra::Isometry3;
use ppnpack_packing::motion::{Cycle, JointPoint, Leg, LegKind};
use ppnpack_protocol::ledger::{Head, Outcome, PlacementVerdict, Record};
use ppnpack_protocol::placing::{Body, Ending, Finding, Placement};
use ppnpack_service::Health;
use redb::TableDefinition;
use serde::Serialize;
use tempfile::TempDir;

use super::*;

/// The cell in each of them.
const CELL: &str = "cell-1";

/// The state that the cell is in.
const STATE: u64 = 77;

fn placement(id: &str, state_number: u64) -> Placement {
    Placement {
        placement_id: id.to_owned(),
        item_id: format!("item-{id}"),
        object: "box".to_owned(),
        container_from_item: Isometry3::translation(0.1, 0.2, 0.25),
        state_number,
        cycle: None,
    }
}

fn placed() -> Finding {
    Finding {
        ending: Ending::Placed,
        failure: String::new(),
        container_from_item: Some(Isometry3::translation(0.1, 0.2, 0.25)),
        is_inside: true,
        slide_m: 0.01,
        tilt_rad: 0.02,
    }
}

fn body(item_id: &str) -> Body {
    Body {
        item_id: item_id.to_owned(),
        object: "box".to_owned(),
        container_from_item: Isometry3::translation(0.1, 0.2, 0.25),
        is_inside: true,
    }
}

fn cycle() -> Cycle {
    let point = |time_s: f64| JointPoint {
        time_s,
        position_rad: [0.5, -0.25, time_s, 3.0, -6.0, 12.5],
    };
    Cycle {
        arm: "an arm".to_owned(),
        cycle_s: 4.5,
        container_from_item_at_pick: Isometry3::translation(0.1, -0.35, 0.02),
        grasp_yaw_rad: 0.75,
        grip_s: 0.2,
        release_s: 0.15,
        legs: vec![Leg {
            kind: LegKind::Descend,
            points: vec![point(0.0), point(0.5)],
        }],
    }
}

/// What was done before the placement that is under way.
fn records() -> BTreeMap<u64, Record> {
    let renewal = Record::Renewal {
        request_id: "r".to_owned(),
        state_number: Some(STATE - 1),
    };
    let outcome = Outcome {
        finding: placed(),
        state_number: STATE,
    };
    let placement = Record::Placement {
        placement: Box::new(placement("p1", STATE - 1)),
        outcome: Some(outcome),
    };
    BTreeMap::from([(0, renewal), (1, placement)])
}

/// What is in the journal of the first version: neither holds nor motions.
fn first() -> Ledger {
    let mut records = records();
    let under_way = Record::Placement {
        placement: Box::new(placement("p2", STATE)),
        outcome: None,
    };
    records.insert(2, under_way);
    let head = Head {
        state_number: STATE,
        first_state_number: STATE,
        hold: None,
        next: 3,
        bodies: vec![body("a")],
    };
    Ledger::of(head, records)
}

fn write_first(database: &Database) {
    /// The head of a cell as it was then.
    #[derive(Serialize)]
    struct FirstHead {
        state_number: u64,
        next: u64,
        bodies: Vec<Body>,
    }
    let heads: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("heads-1");
    let table: TableDefinition<'_, (&str, u64), &[u8]> = TableDefinition::new("records-1");
    let ledger = first();
    let head = FirstHead {
        state_number: STATE,
        next: ledger.head().next,
        bodies: ledger.head().bodies.clone(),
    };
    let transaction = database.begin_write().unwrap();
    {
        let mut heads = transaction.open_table(heads).unwrap();
        let head = postcard::to_stdvec(&head).unwrap();
        heads.insert(CELL, head.as_slice()).unwrap();
        let mut table = transaction.open_table(table).unwrap();
        for (number, record) in ledger.records() {
            let record = postcard::to_stdvec(record).unwrap();
            table.insert((CELL, number), record.as_slice()).unwrap();
        }
    }
    transaction.commit().unwrap();
}

/// What is in the journal of the second version, and the last change of it.
fn second() -> (Ledger, Change) {
    let head = Head {
        state_number: STATE,
        first_state_number: STATE - 10,
        hold: Some("a door is open".to_owned()),
        next: 2,
        bodies: vec![body("a")],
    };
    let ledger = Ledger::of(head, records());
    let change = ledger.accept(Placement {
        cycle: Some(Arc::new(cycle())),
        ..placement("p2", STATE)
    });
    (ledger, change)
}

fn write_second(database: &Database) {
    let (ledger, change) = second();
    database::write(database, CELL, Some(&ledger), &change).unwrap();
}

/// A copy of the journal of a version, which is recorded where it is missing.
fn copy(version: u64, write: fn(&Database)) -> (TempDir, PathBuf) {
    let formats = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/journal/formats");
    let kept = formats.join(format!("{version}.redb.zst"));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("journal.redb");
    if !kept.exists() {
        let is_recording = std::env::var("PPNPACK_RECORD").is_ok_and(|value| value == "1");
        assert!(is_recording, "{} is missing", kept.display());
        write(&Database::create(&path).unwrap());
        let packed = zstd::encode_all(fs::read(&path).unwrap().as_slice(), 19).unwrap();
        fs::create_dir_all(formats).unwrap();
        fs::write(&kept, packed).unwrap();
    }
    let packed = fs::read(kept).unwrap();
    fs::write(&path, zstd::decode_all(packed.as_slice()).unwrap()).unwrap();
    (folder, path)
}

fn load(path: &Path) -> (CellJournal, Ledger) {
    let journal = Journal::new(path, Health::default().check("journal"));
    let mut journal = CellJournal::new(Some(Arc::new(journal)), Cell::new(CELL).unwrap());
    let ledger = journal.load().unwrap();
    (journal, ledger)
}

/// Goes on with a journal that says this.
fn assert_goes_on(path: &Path, expected: &Ledger) {
    let (mut journal, mut ledger) = load(path);
    assert_eq!(&ledger, expected);
    assert_eq!(
        ledger.judge(&placement("p1", STATE - 1)),
        PlacementVerdict::Known(expected.placement("p1").unwrap().1)
    );
    let change = ledger.end_placement(placed(), vec![body("a"), body("b")]);
    journal.write(&ledger, &change).unwrap();
    ledger.apply(change);
    drop(journal);
    assert_eq!(load(path).1, ledger);
}

#[test]
fn a_journal_of_the_first_version_is_read_and_gone_on_with() {
    let (_folder, path) = copy(1, write_first);
    assert_goes_on(&path, &first());
}

#[test]
fn a_journal_of_the_second_version_is_read_and_gone_on_with() {
    let (_folder, path) = copy(2, write_second);
    let (mut ledger, change) = second();
    ledger.apply(change);
    assert_goes_on(&path, &ledger);
}
