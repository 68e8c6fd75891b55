//! A journal of this version, kept in `formats/`, is read and gone on with.
//!
//! `PPNPACK_RECORD=1` writes it where it is missing. One that is there stays as it is.

use std::collections::BTreeMap;
use std::fs;

use nalgebra::Isometry3;
use ppnpack_packing::motion::{Cycle, JointPoint, Leg, LegKind};
use ppnpack_protocol::ledger::{Head, Outcome, PlacementVerdict, Record};
use ppnpack_protocol::placing::{Body, Ending, Finding, KnownPose, Placement};
use ppnpack_service::Health;
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
        container_from_item: pose(),
        state_number,
        cycle: None,
    }
}

fn pose() -> Isometry3<f64> {
    Isometry3::translation(0.1, 0.2, 0.25)
}

fn placed(container_from_item: KnownPose) -> Finding {
    Finding {
        ending: Ending::Placed,
        failure: String::new(),
        container_from_item: Some(container_from_item),
        is_inside: true,
        slide_m: 0.01,
        tilt_rad: 0.02,
    }
}

fn body(item_id: &str, container_from_item: KnownPose) -> Body {
    Body {
        item_id: item_id.to_owned(),
        object: "box".to_owned(),
        container_from_item,
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

/// What was done before the placement that is under way, after which the item was there.
fn records() -> BTreeMap<u64, Record> {
    let renewal = Record::Renewal {
        request_id: "r".to_owned(),
        state_number: Some(STATE - 1),
    };
    let outcome = Outcome {
        finding: placed(KnownPose::Found(pose())),
        state_number: STATE,
    };
    let placement = Record::Placement {
        placement: Box::new(placement("p1", STATE - 1)),
        outcome: Some(outcome),
    };
    BTreeMap::from([(0, renewal), (1, placement)])
}

/// What is in the journal, and its last change.
fn kept() -> (Ledger, Change) {
    let head = Head {
        state_number: STATE,
        first_state_number: STATE - 10,
        hold: Some("a door is open".to_owned()),
        next: 2,
        bodies: vec![body("a", KnownPose::Found(pose()))],
    };
    let ledger = Ledger::of(head, records());
    let change = ledger.accept(Placement {
        cycle: Some(Arc::new(cycle())),
        ..placement("p2", STATE)
    });
    (ledger, change)
}

/// A copy of the journal, which is recorded where it is missing.
fn copy() -> (TempDir, PathBuf) {
    let formats = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/journal/formats");
    let recorded = formats.join("3.redb.zst");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("journal.redb");
    if !recorded.exists() {
        let is_recording = std::env::var("PPNPACK_RECORD").is_ok_and(|value| value == "1");
        assert!(is_recording, "{} is missing", recorded.display());
        let (ledger, change) = kept();
        let database = Database::create(&path).unwrap();
        database::write(&database, CELL, Some(&ledger), &change).unwrap();
        drop(database);
        let packed = zstd::encode_all(fs::read(&path).unwrap().as_slice(), 19).unwrap();
        fs::create_dir_all(formats).unwrap();
        fs::write(&recorded, packed).unwrap();
    }
    let packed = fs::read(recorded).unwrap();
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
    let found = KnownPose::Found(pose());
    let bodies = vec![body("a", found), body("b", KnownPose::Assumed(pose()))];
    let change = ledger.end_placement(placed(found), bodies);
    journal.write(&ledger, &change).unwrap();
    ledger.apply(change);
    drop(journal);
    assert_eq!(load(path).1, ledger);
}

#[test]
fn a_journal_is_read_as_it_was_recorded_and_gone_on_with() {
    let (_folder, path) = copy();
    let (mut ledger, change) = kept();
    ledger.apply(change);
    assert_goes_on(&path, &ledger);
}
