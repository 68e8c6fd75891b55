use std::fs;

use nalgebra::Vector3;
use ppnpack_packing::kernel::item::{Item, ViewSurfaces};
use ppnpack_protocol::session::open_container;
use ppnpack_wire::convert;
use redb::{TableDefinition, WriteTransaction};
use tempfile::TempDir;

use super::*;

#[path = "../../../../service/tests/support/damage.rs"]
mod damage;

use damage::with_each_damage;

/// Room for all shapes here.
const ENOUGH: u64 = 1 << 20;

fn cell(name: &str) -> Cell {
    Cell::new(name).unwrap()
}

/// A block of so many cells a side.
fn shape(side: usize) -> v1::Item {
    let cells = side * side;
    let view = ViewSurfaces {
        origin_from_corner_m: Vector3::new(0.1, 0.1, 0.0),
        ..ViewSurfaces::of_cells(side, side, vec![20; cells], vec![0; cells])
    };
    convert::item::write(&Item::new("block", vec![view; 2], 0.001).unwrap())
}

fn item(item_id: &str, shape: &v1::Item) -> v1::SessionItem {
    v1::SessionItem {
        item_id: item_id.to_owned(),
        object: "block".to_owned(),
        shape: ItemId::of(shape).to_bytes(),
        ..v1::SessionItem::default()
    }
}

fn session(id: &str) -> Session {
    let container = open_container(String::new(), Vec::new(), 7);
    Session::begin(id.to_owned(), vec![container], false, 0)
}

/// A session with an item of each of these shapes.
fn holding(id: &str, shapes: &[v1::Item]) -> Session {
    let mut session = session(id);
    let items = shapes.iter().enumerate();
    let items = items.map(|(number, shape)| item(&format!("item-{number}"), shape));
    session.announce(items.collect()).unwrap();
    session
}

/// A session of a cell that was saved once for each of its items, with their heightmaps.
fn fill(store: &Store, cell: &Cell, items: usize) -> Session {
    let mut session = session(&format!("session-of-{cell}"));
    store.begin(cell, &session).unwrap();
    for number in 0..items {
        add(store, cell, &mut session, number);
    }
    session
}

fn add(store: &Store, cell: &Cell, session: &mut Session, number: usize) {
    let shape = shape(3 + number);
    let item = item(&format!("item-{number}"), &shape);
    session.announce(vec![item]).unwrap();
    store.save(cell, session, &[shape]).unwrap();
}

/// The file of a store, on a disk that is quick where there is one.
struct StoreFile {
    folder: TempDir,
    path: PathBuf,
}

impl StoreFile {
    fn new() -> Self {
        let quick = Path::new("/dev/shm");
        let folder = match quick.is_dir() {
            true => tempfile::tempdir_in(quick).unwrap(),
            false => tempfile::tempdir().unwrap(),
        };
        let path = folder.path().join("sessions.redb");
        Self { folder, path }
    }

    fn open(&self) -> Store {
        Store::open(Some(&self.path), ENOUGH).unwrap()
    }

    /// The session of a cell, of the store opened anew.
    fn session(&self, cell: &Cell) -> Session {
        self.open().session(cell).unwrap()
    }

    fn of_cell(&self, cell: &Cell) -> PathBuf {
        file::of_cell(&self.path, cell)
    }

    /// The mark of a cell's file.
    fn mark_of(&self, cell: &Cell) -> PathBuf {
        self.of_cell(cell).with_extension("redb.revision")
    }

    /// How many files of cells were put aside.
    fn put_aside(&self) -> usize {
        let files = fs::read_dir(self.path.with_extension("cells")).unwrap();
        let names = files.map(|entry| entry.unwrap().file_name());
        let aside = names.filter(|name| name.to_string_lossy().contains(".damaged-"));
        aside.count()
    }
}

/// Changes a database past the store.
fn write(database: &Database, change: impl FnOnce(&WriteTransaction)) {
    let transaction = database.begin_write().unwrap();
    change(&transaction);
    transaction.commit().unwrap();
}

#[test]
fn sessions_and_heightmaps_are_there_again() {
    let [a, b] = ["a", "b"].map(cell);
    let mut file = StoreFile::new();
    file.path = file.folder.path().join("new/sessions.redb");
    let store = file.open();
    assert_eq!(store.session(&a).unwrap(), Session::default());
    let (of_a, of_b) = (fill(&store, &a, 2), fill(&store, &b, 3));
    drop(store);
    let store = file.open();
    assert_eq!(store.session(&a).unwrap(), of_a);
    assert_eq!(store.session(&b).unwrap(), of_b);
    let third = shape(5);
    let id = ItemId::of(&third);
    assert_eq!(store.shape(&a, id).unwrap(), None);
    assert_eq!(store.shape(&b, id).unwrap(), Some(third));
    store.begin(&b, &session("next")).unwrap();
    assert_eq!(store.shape(&b, id).unwrap(), None);
    assert_eq!(store.session(&b).unwrap(), session("next"));
}

#[test]
fn heightmaps_that_no_item_refers_to_any_more_make_room_for_others() {
    let a = cell("a");
    let store = Store::open(None, ENOUGH).unwrap();
    let [first, second, third] = [3, 4, 5].map(shape);
    let shapes = [first.clone(), second.clone()];
    store.save(&a, &holding("s", &shapes), &shapes).unwrap();
    let next = holding("s", &[second.clone(), third.clone()]);
    // Where none comes, none is forgotten.
    store.save(&a, &next, &[]).unwrap();
    assert!(store.shape(&a, ItemId::of(&first)).unwrap().is_some());
    let added = std::slice::from_ref(&third);
    store.save(&a, &next, added).unwrap();
    assert_eq!(store.shape(&a, ItemId::of(&first)).unwrap(), None);
    for kept in [second, third] {
        let id = ItemId::of(&kept);
        assert_eq!(store.shape(&a, id).unwrap(), Some(kept));
    }
}

#[test]
fn a_session_has_no_more_heightmaps_than_it_may() {
    let shapes: Vec<v1::Item> = (3..20).map(shape).collect();
    let most: usize = shapes.iter().take(4).map(Message::encoded_len).sum();
    let store = Store::open(None, most as u64).unwrap();
    let [a, b] = ["a", "b"].map(cell);
    let (one, two) = (holding("one", &shapes[..4]), holding("two", &shapes[..4]));
    store.save(&a, &one, &shapes[..4]).unwrap();
    // Those that are there already take nothing.
    store.save(&a, &two, &shapes[..4]).unwrap();
    let refused = store
        .save(&a, &holding("three", &shapes[..5]), &shapes[4..5])
        .unwrap_err();
    assert!(matches!(refused, StoreError::TooManyShapes { .. }));
    assert!(refused.to_string().contains("shapes_mib"), "{refused}");
    assert_eq!(store.session(&a).unwrap(), two, "nothing was saved");
    assert_eq!(store.shape(&a, ItemId::of(&shapes[4])).unwrap(), None);
    // Another cell's session and the next one have room of their own.
    let next = holding("next", &shapes[4..5]);
    store.save(&b, &next, &shapes[4..5]).unwrap();
    store.begin(&a, &session("next")).unwrap();
    store.save(&a, &next, &shapes[4..5]).unwrap();
}

#[test]
fn heightmaps_that_are_not_those_that_were_written_are_not_given() {
    let store = Store::open(None, ENOUGH).unwrap();
    let a = cell("a");
    fill(&store, &a, 1);
    let change = |database: &Database| {
        write(database, |transaction| {
            let shapes: TableDefinition<'_, (&str, &[u8]), &[u8]> = TableDefinition::new("shapes");
            let mut table = transaction.open_table(shapes).unwrap();
            let id = ItemId::of(&shape(3)).to_bytes();
            let other = shape(4).encode_to_vec();
            table
                .insert(("a", id.as_slice()), other.as_slice())
                .unwrap();
        });
        Ok(())
    };
    store.with(&a, change).unwrap();
    assert_eq!(store.shape(&a, ItemId::of(&shape(3))).unwrap(), None);
}

#[test]
fn every_page_of_a_cells_file_may_be_damaged() {
    let file = StoreFile::new();
    let [a, b] = ["a", "b"].map(cell);
    let store = file.open();
    let (of_a, of_b) = (fill(&store, &a, 4), fill(&store, &b, 2));
    drop(store);
    with_each_damage(&file.of_cell(&a), |damage| {
        let store = file.open();
        let before = file.put_aside();
        // As it was, or lost: never as it was some time before.
        let found = store.session(&a).unwrap();
        if found != of_a {
            assert_eq!(found, Session::default(), "{damage}");
            assert!(file.put_aside() > before, "{damage}");
        }
        for side in 3..7 {
            let known = store.shape(&a, ItemId::of(&shape(side))).unwrap();
            assert!(known.is_none_or(|known| known == shape(side)), "{damage}");
        }
        store.begin(&a, &session("after")).unwrap();
        assert_eq!(store.session(&a).unwrap(), session("after"), "{damage}");
        assert_eq!(store.session(&b).unwrap(), of_b, "{damage}");
    });
}

#[test]
fn a_store_of_another_version_is_refused_and_left_as_it_is() {
    let file = StoreFile::new();
    let a = cell("a");
    let store = file.open();
    let of_a = fill(&store, &a, 1);
    drop(store);
    let format: TableDefinition<'_, &str, u64> = TableDefinition::new("format");
    let set = |path: &Path, version: Option<u64>| {
        write(&Database::create(path).unwrap(), |transaction| {
            let mut table = transaction.open_table(format).unwrap();
            match version {
                Some(version) => drop(table.insert("version", version).unwrap()),
                None => drop(table.remove("version").unwrap()),
            }
        });
    };
    let of_cell = file.of_cell(&a);
    for (version, found) in [(Some(3), "format 3"), (None, "format 1")] {
        let assert_other = |refused: StoreError| {
            let text = refused.to_string();
            assert!(
                text.contains("another version") && text.contains(found),
                "{text}"
            );
        };
        set(&file.path, version);
        assert_other(Store::open(Some(&file.path), 0).err().unwrap());
        set(&file.path, Some(2));
        set(&of_cell, version);
        assert_other(file.open().session(&a).unwrap_err());
        set(&of_cell, Some(2));
        assert_eq!(file.session(&a), of_a);
    }
}

#[test]
fn every_page_of_the_file_that_says_the_version_may_be_damaged() {
    let file = StoreFile::new();
    let [a, b] = ["a", "b"].map(cell);
    let store = file.open();
    let (of_a, of_b) = (fill(&store, &a, 2), fill(&store, &b, 2));
    drop(store);
    with_each_damage(&file.path, |damage| {
        let store = file.open();
        assert_eq!(store.session(&a).unwrap(), of_a, "{damage}");
        assert_eq!(store.session(&b).unwrap(), of_b, "{damage}");
    });
}

#[test]
fn a_file_that_is_damaged_while_it_is_open_is_put_aside() {
    let file = StoreFile::new();
    let a = cell("a");
    let store = file.open();
    let mut session = fill(&store, &a, 4);
    fs::write(file.of_cell(&a), b"something else altogether").unwrap();
    for number in 4..8 {
        add(&store, &a, &mut session, number);
    }
    drop(store);
    assert_eq!(file.session(&a), session);
}

#[test]
fn nothing_is_saved_while_the_file_of_a_cell_is_not_where_it_was() {
    let file = StoreFile::new();
    let a = cell("a");
    let store = file.open();
    let mut session = fill(&store, &a, 2);
    let (own, elsewhere) = (file.of_cell(&a), file.folder.path().join("elsewhere"));
    fs::rename(&own, &elsewhere).unwrap();
    let refused = store.save(&a, &session, &[]).unwrap_err().to_string();
    assert!(refused.contains("put that file back"), "{refused}");
    fs::rename(&elsewhere, &own).unwrap();
    add(&store, &a, &mut session, 2);
    drop(store);
    assert_eq!(file.session(&a), session);
}

#[test]
fn an_older_copy_of_a_file_is_put_aside_until_it_is_said_to_be_a_backup() {
    let file = StoreFile::new();
    let a = cell("a");
    fill(&file.open(), &a, 2);
    let copy = fs::read(file.of_cell(&a)).unwrap();
    for is_backup in [false, true] {
        fill(&file.open(), &a, 3);
        fs::write(file.of_cell(&a), &copy).unwrap();
        let before = file.put_aside();
        if is_backup {
            assert_eq!(Store::after_restore(&file.path).unwrap(), ["a"]);
        }
        let found = file.session(&a);
        assert_eq!(found != Session::default(), is_backup);
        assert_eq!(file.put_aside() > before, !is_backup);
    }
}

#[test]
fn a_mark_that_is_gone_behind_or_damaged_loses_nothing() {
    let file = StoreFile::new();
    let a = cell("a");
    let mut session = fill(&file.open(), &a, 2);
    let behind = fs::read(file.mark_of(&a)).unwrap();
    for number in 2..6 {
        let item = item(&format!("item-{number}"), &shape(3));
        session.announce(vec![item]).unwrap();
        file.open().save(&a, &session, &[]).unwrap();
        match number {
            2 => fs::remove_file(file.mark_of(&a)).unwrap(),
            3 => fs::write(file.mark_of(&a), &behind).unwrap(),
            4 => fs::write(file.mark_of(&a), [0x5a; 16]).unwrap(),
            _ => fs::write(file.mark_of(&a), [0xff; 7]).unwrap(),
        }
        assert_eq!(file.session(&a), session);
    }
}

/// Spoils the file of a cell that has a session. Asserts that the session is lost and the file put
/// aside, that another cell has its own, and that another session can begin.
fn assert_lost_alone(spoil: impl FnOnce(&StoreFile, Store, [&Cell; 2])) {
    let file = StoreFile::new();
    let [a, b] = ["a", "b"].map(cell);
    let store = file.open();
    fill(&store, &a, 2);
    let of_b = fill(&store, &b, 3);
    spoil(&file, store, [&a, &b]);
    let store = file.open();
    assert_eq!(store.session(&a).unwrap(), Session::default());
    assert_eq!(file.put_aside(), 1);
    assert_eq!(store.session(&b).unwrap(), of_b);
    store.begin(&a, &session("next")).unwrap();
    assert_eq!(store.session(&a).unwrap(), session("next"));
}

#[test]
fn the_files_of_another_cell_are_put_aside() {
    assert_lost_alone(|file, store, [a, b]| {
        drop(store);
        fs::copy(file.of_cell(b), file.of_cell(a)).unwrap();
        fs::copy(file.mark_of(b), file.mark_of(a)).unwrap();
    });
}

#[test]
fn what_is_no_session_is_put_aside_and_other_cells_have_theirs() {
    assert_lost_alone(|_, store, [a, _]| {
        let spoil = |database: &Database| {
            write(database, |transaction| {
                let sessions: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("sessions");
                let mut table = transaction.open_table(sessions).unwrap();
                table.insert("a", [0xff; 9].as_slice()).unwrap();
            });
            Ok(())
        };
        store.with(a, spoil).unwrap();
        // While it is open.
        assert_eq!(store.session(a).unwrap(), Session::default());
    });
}
