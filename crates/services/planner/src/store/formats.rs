//! Stores of every version, kept in `formats/`, are read and gone on with.
//!
//! `PPNPACK_RECORD=1` writes those that are missing. One that is there stays as it is: the program of its version wrote it.

use std::fs;

use ppnpack_protocol::session::ItemState;
use redb::{ReadableDatabase, TableDefinition};
use tempfile::TempDir;

use super::tests::{cell, folder, item, open, shape};
use super::*;

/// A session of the first version: of one item that was packed, one that is decided on and two that wait.
fn first() -> v1::Session {
    let state = |item_id: &str, state: v1::ItemState, shape: &v1::Item| v1::SessionItem {
        item_id: item_id.to_owned(),
        object: "block".to_owned(),
        state: state.into(),
        shape: ItemId::of(shape).to_bytes(),
        ..v1::SessionItem::default()
    };
    let identity = v1::Pose {
        position: Some(v1::Vector3::default()),
        orientation: Some(v1::Quaternion {
            w: 1.0,
            ..v1::Quaternion::default()
        }),
    };
    let placement = v1::RestingPlacement {
        yaw: 1,
        x: 2,
        y: 3,
        resting_height: 4,
    };
    let packed = v1::SessionItem {
        placement: Some(placement),
        planned: Some(identity),
        container_from_item: Some(identity),
        ..state("packed", v1::ItemState::Packed, &shape(3))
    };
    v1::Session {
        session_id: "old".to_owned(),
        items: vec![
            packed,
            state("decided", v1::ItemState::Decided, &shape(3)),
            state("first", v1::ItemState::Waiting, &shape(4)),
            state("second", v1::ItemState::Waiting, &shape(3)),
        ],
        pending: Some(v1::Decision {
            decision_id: "d2".to_owned(),
            request_id: "r2".to_owned(),
            session_id: "old".to_owned(),
            step: 1,
            item_id: "decided".to_owned(),
            placement: Some(placement),
            container_from_item: Some(identity),
            state_number: 71,
            ..v1::Decision::default()
        }),
        step: 2,
        keep_out: vec![v1::Region {
            x_max_m: 0.1,
            y_max_m: 0.2,
            ..v1::Region::default()
        }],
        least_state_number: 71,
        settled: vec![v1::SettledDecision {
            decision_id: "d1".to_owned(),
            request_id: "r1".to_owned(),
            kind: v1::OutcomeKind::Placed.into(),
        }],
        ..v1::Session::default()
    }
}

/// A session that has everything that one of the second version can have beyond.
fn second() -> v1::Session {
    let mut session = first();
    session.set_aside_limit = 3;
    session.past_session_ids = vec!["older".to_owned()];
    session.is_automatic = true;
    session.end = v1::SessionEnd::Failed.into();
    session.failure = "a reason".to_owned();
    for item in &mut session.items {
        item.poses = 3;
        item.allowed_poses = vec![0, 2];
    }
    let aside = v1::SessionItem {
        item_id: "aside".to_owned(),
        state: v1::ItemState::SetAside.into(),
        set_aside: Some(v1::ItemReason {
            item_id: "aside".to_owned(),
            reason: v1::Reason::NoFit.into(),
            text: "too large".to_owned(),
        }),
        set_aside_step: 1,
        ..session.items[2].clone()
    };
    session.items.push(aside);
    session
}

/// A store with the session of cell a, and one of cell b without anything.
fn write_first(path: &Path) {
    let sessions: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("sessions");
    let shapes: TableDefinition<'_, (&str, &[u8]), &[u8]> = TableDefinition::new("shapes");
    let database = Database::create(path).unwrap();
    let transaction = database.begin_write().unwrap();
    {
        let mut sessions = transaction.open_table(sessions).unwrap();
        let of_b = v1::Session {
            session_id: "of b".to_owned(),
            ..v1::Session::default()
        };
        for (cell, session) in [("a", first()), ("b", of_b)] {
            let session = session.encode_to_vec();
            sessions.insert(cell, session.as_slice()).unwrap();
        }
        let mut shapes = transaction.open_table(shapes).unwrap();
        for shape in [shape(3), shape(4)] {
            let id = ItemId::of(&shape).to_bytes();
            let shape = shape.encode_to_vec();
            shapes
                .insert(("a", id.as_slice()), shape.as_slice())
                .unwrap();
        }
    }
    transaction.commit().unwrap();
}

fn write_second(path: &Path) {
    let store = open(path);
    let session = Session::from_message(second()).unwrap();
    let shapes = [shape(3), shape(4)];
    store.save(&cell("a"), &session, &shapes).unwrap();
}

/// The files of a store.
const FILES: [&str; 2] = ["sessions.redb", "sessions.cells/a.redb"];

/// A copy of the store of a version, which is recorded where it is missing.
fn copy(version: u64, write: fn(&Path)) -> (TempDir, PathBuf) {
    let formats = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/store/formats");
    let kept = formats.join(version.to_string());
    let kept_as = |name: &str| kept.join(format!("{}.zst", name.replace('/', "-")));
    let folder = folder();
    let path = folder.path().join("sessions.redb");
    if !kept.exists() {
        let is_recording = std::env::var("PPNPACK_RECORD").is_ok_and(|value| value == "1");
        assert!(is_recording, "{} is missing", kept.display());
        write(&path);
        fs::create_dir_all(&kept).unwrap();
        for name in FILES {
            if let Ok(bytes) = fs::read(folder.path().join(name)) {
                let packed = zstd::encode_all(bytes.as_slice(), 19).unwrap();
                fs::write(kept_as(name), packed).unwrap();
            }
        }
    }
    for name in FILES {
        let to = folder.path().join(name);
        if let Ok(packed) = fs::read(kept_as(name)) {
            fs::create_dir_all(to.parent().unwrap()).unwrap();
            fs::write(to, zstd::decode_all(packed.as_slice()).unwrap()).unwrap();
        }
    }
    (folder, path)
}

/// Goes on with a store that says this of cell a.
fn assert_goes_on(path: &Path, expected: v1::Session) {
    let mut expected = Session::from_message(expected).unwrap();
    let a = cell("a");
    // Once as it is found, once as it was left.
    for round in 0..2 {
        let store = open(path);
        let mut session = store.session(&a).unwrap();
        assert_eq!(session, expected);
        for side in [3, 4] {
            let known = store.shape(&a, ItemId::of(&shape(side))).unwrap();
            assert_eq!(known, Some(shape(side)));
        }
        let waiting =
            |item: &&ppnpack_protocol::session::SessionItem| item.state == ItemState::Waiting;
        assert_eq!(session.items().iter().filter(waiting).count(), 2 + round);
        let new = item(&format!("new-{round}"), &shape(5 + round));
        session.announce(vec![new]).unwrap();
        store.save(&a, &session, &[shape(5 + round)]).unwrap();
        expected = session;
    }
}

#[test]
fn a_store_of_the_first_version_is_read_and_gone_on_with() {
    let (_folder, path) = copy(1, write_first);
    assert_goes_on(&path, first());
    let of_b = open(&path).session(&cell("b")).unwrap();
    assert_eq!(of_b.id(), "of b");
}

#[test]
fn a_store_of_the_second_version_is_read_and_gone_on_with() {
    let (_folder, path) = copy(2, write_second);
    assert_goes_on(&path, second());
}

#[test]
fn a_program_of_the_first_version_refuses_what_this_one_leaves() {
    let (_folder, path) = copy(1, write_first);
    drop(open(&path));
    // It reads this before anything else.
    let format: TableDefinition<'_, &str, u64> = TableDefinition::new("format");
    let root = Database::open(&path).unwrap();
    let transaction = root.begin_read().unwrap();
    let table = transaction.open_table(format).unwrap();
    assert_eq!(table.get("version").unwrap().unwrap().value(), 2);
    let sessions: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("sessions");
    assert!(transaction.open_table(sessions).is_err());
}

#[test]
fn a_migration_that_was_cut_off_is_made_again() {
    let (_folder, path) = copy(1, write_first);
    let whole = fs::read(&path).unwrap();
    drop(open(&path));
    // The files of the cells are there; the store's own says the first version still.
    fs::write(&path, whole).unwrap();
    assert_goes_on(&path, first());
}

#[test]
fn a_store_of_a_newer_version_is_refused_and_left_as_it_is() {
    let (_folder, path) = copy(2, write_second);
    let of_a = path.with_extension("cells").join("a.redb");
    let format: TableDefinition<'_, &str, u64> = TableDefinition::new("format");
    let set = |path: &Path, version: u64| {
        let database = Database::create(path).unwrap();
        let transaction = database.begin_write().unwrap();
        let mut table = transaction.open_table(format).unwrap();
        table.insert("version", version).unwrap();
        drop(table);
        transaction.commit().unwrap();
    };
    let assert_newer = |refused: StoreError| {
        let text = refused.to_string();
        assert!(
            text.contains("newer version") && text.contains("format 3"),
            "{text}"
        );
    };
    set(&path, 3);
    assert_newer(Store::open(Some(&path), 0).err().unwrap());
    set(&path, 2);
    set(&of_a, 3);
    let store = open(&path);
    assert_newer(store.session(&cell("a")).unwrap_err());
    drop(store);
    set(&of_a, 2);
    assert_goes_on(&path, second());
}
