use std::io::{Error, ErrorKind};
use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::Isometry3;
use ppnpack_protocol::ledger::{Hold, Outcome, PlacementVerdict};
use ppnpack_protocol::placing::{Body, Ending, Finding, KnownPose, Placement};
use ppnpack_service::Health;
use redb::backends::InMemoryBackend;
use redb::{Builder, StorageBackend};

use super::*;

#[path = "../../../../service/tests/support/damage.rs"]
mod damage;

use damage::with_each_damage;

fn placement(id: &str, state_number: u64) -> Placement {
    Placement {
        placement_id: id.to_owned(),
        item_id: format!("item-{id}"),
        object: "box".to_owned(),
        container_from_item: Isometry3::translation(0.1, 0.2, 0.3),
        state_number,
        cycle: None,
    }
}

fn placed() -> Finding {
    Finding {
        container_from_item: Some(KnownPose::Found(Isometry3::translation(0.1, 0.2, 0.25))),
        is_inside: true,
        ..Finding::failed(Ending::Placed, "")
    }
}

fn body(item_id: &str) -> Body {
    Body {
        item_id: item_id.to_owned(),
        object: "box".to_owned(),
        container_from_item: KnownPose::Found(Isometry3::translation(0.1, 0.2, 0.25)),
        is_inside: true,
    }
}

/// A disk in memory that can be full.
#[derive(Debug, Clone, Default)]
struct Disk {
    memory: Arc<InMemoryBackend>,
    is_full: Arc<AtomicBool>,
}

impl Disk {
    fn check(&self) -> Result<(), Error> {
        match self.is_full.load(Ordering::Relaxed) {
            true => Err(Error::new(
                ErrorKind::StorageFull,
                "no space left on device",
            )),
            false => Ok(()),
        }
    }
}

impl StorageBackend for Disk {
    fn len(&self) -> Result<u64, Error> {
        self.memory.len()
    }

    fn read(&self, offset: u64, out: &mut [u8]) -> Result<(), Error> {
        self.memory.read(offset, out)
    }

    fn set_len(&self, len: u64) -> Result<(), Error> {
        self.check()?;
        self.memory.set_len(len)
    }

    fn sync_data(&self) -> Result<(), Error> {
        self.check()
    }

    fn write(&self, offset: u64, data: &[u8]) -> Result<(), Error> {
        self.check()?;
        self.memory.write(offset, data)
    }
}

fn cell(name: &str) -> Cell {
    Cell::new(name).unwrap()
}

/// A journal on a disk, for one start of a bridge.
fn journal(disk: &Disk) -> (Arc<Journal>, Health) {
    let health = Health::default();
    let disk = disk.clone();
    let open = move || {
        let mut builder = Builder::new();
        builder.set_check_integrity_on_open(true);
        Ok(builder.create_with_backend(disk.clone())?.into())
    };
    let path = Path::new("/nowhere/journal");
    let journal = Journal::with_open(path, health.check("journal"), Box::new(open));
    (Arc::new(journal), health)
}

/// A journal in a file, for one start of a bridge.
fn journal_in(path: &Path) -> (Arc<Journal>, Health) {
    let health = Health::default();
    let journal = Journal::new(path, health.check("journal"));
    (Arc::new(journal), health)
}

/// A cell's ledger, and the journal that it is written to.
struct Own {
    journal: CellJournal,
    ledger: Ledger,
}

impl Own {
    fn load(journal: &Arc<Journal>, name: &str) -> Self {
        let mut journal = CellJournal::new(Some(Arc::clone(journal)), cell(name));
        let ledger = journal.load().unwrap();
        Self { journal, ledger }
    }

    fn write(&mut self, change: &Change) -> Result<(), JournalError> {
        self.journal.write(&self.ledger, change)
    }

    fn step(&mut self, change: Change) {
        self.write(&change).unwrap();
        self.ledger.apply(change);
    }

    fn accepting(&self, id: &str) -> Change {
        let asked = placement(id, self.ledger.head().state_number);
        self.ledger.accept(asked)
    }

    /// Makes a placement from beginning to end.
    fn place(&mut self, id: &str) {
        self.step(self.accepting(id));
        self.step(self.ledger.end_placement(placed(), vec![body(id)]));
    }

    fn begin_renewal(&mut self) {
        self.step(self.ledger.begin_renewal("r1".to_owned()));
    }
}

#[test]
fn a_ledger_is_read_as_it_was_written() {
    let disk = Disk::default();
    let (first, health) = journal(&disk);
    let [mut a, mut b] = ["a", "b"].map(|name| Own::load(&first, name));
    a.place("a1");
    b.place("b1");
    a.begin_renewal();
    a.step(a.ledger.end_renewal(Vec::new()));
    b.step(b.accepting("b2"));
    // What is forgotten is gone from the disk.
    let mut c = Own::load(&first, "c");
    c.begin_renewal();
    c.step(c.ledger.abandon_renewal(Vec::new()));
    assert!(health.is_ready());
    let ledgers = [a, b, c].map(|own| own.ledger);
    drop(first);

    let (second, _) = journal(&disk);
    let again = ["a", "b", "c"].map(|name| Own::load(&second, name).ledger);
    assert_eq!(again, ledgers);
    assert!(again[2].records().next().is_none());
    let unknown = Own::load(&second, "d").ledger;
    assert!(unknown.records().next().is_none());
}

#[test]
fn a_full_disk_is_told_and_used_again_when_it_has_space() {
    let disk = Disk::default();
    let (first, health) = journal(&disk);
    let mut own = Own::load(&first, "a");
    own.place("p1");
    disk.is_full.store(true, Ordering::Relaxed);
    let change = own.accepting("p2");
    for _ in 0..3 {
        let error = own.write(&change).unwrap_err().to_string();
        assert!(
            error.contains("no space left") && error.contains("/nowhere/journal"),
            "{error}"
        );
    }
    let report = health.report();
    assert!(!report[0].is_passing && report[0].message.contains("no space left"));

    disk.is_full.store(false, Ordering::Relaxed);
    // Something else is asked for now than what could not be written.
    own.place("p3");
    assert!(health.is_ready());
    let ledger = own.ledger;
    drop((own.journal, first));
    let (second, _) = journal(&disk);
    assert_eq!(Own::load(&second, "a").ledger, ledger);
}

/// Makes a placement of cell a in a journal in a file.
fn in_file(path: &Path) -> Ledger {
    let (journal, _) = journal_in(path);
    let mut own = Own::load(&journal, "a");
    own.place("p1");
    own.ledger
}

/// Counts the files of a folder that were put aside.
fn count_put_aside(folder: &Path) -> usize {
    let entries = std::fs::read_dir(folder).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.filter(|name| name.contains(".damaged-")).count()
}

#[test]
fn every_page_of_the_journal_may_be_damaged() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("journal.redb");
    let before = in_file(&path);
    let mark = folder.path().join("journal.redb.revision");
    let marked = std::fs::read(&mark).unwrap();
    with_each_damage(&path, |damage| {
        std::fs::write(&mark, &marked).unwrap();
        let aside = count_put_aside(folder.path());
        let (journal, health) = journal_in(&path);
        let mut own = Own::load(&journal, "a");
        // As it was, or lost, and then nothing is executed again: never as it was some time before.
        if own.ledger != before {
            let stale = placement("p1", before.head().state_number);
            let verdict = own.ledger.judge(&stale);
            assert_eq!(verdict, PlacementVerdict::Forgotten, "{damage}");
            let is_put_aside = count_put_aside(folder.path()) > aside;
            assert!(is_put_aside, "{damage}");
        }
        own.place("p2");
        assert!(health.is_ready(), "{damage}");
    });
}

#[test]
fn a_file_that_is_damaged_while_it_is_open_costs_nothing_that_is_known() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("journal.redb");
    let (journal, _) = journal_in(&path);
    let mut own = Own::load(&journal, "a");
    own.place("p1");
    // As if the disk had given up and come back with something else.
    journal.database.lock().unwrap().close();
    std::fs::write(&path, b"something else altogether").unwrap();
    own.place("p2");
    let ledger = own.ledger;
    drop((own.journal, journal));
    let again = Own::load(&journal_in(&path).0, "a").ledger;
    assert_eq!(again, ledger);
    let outcome = again.placement("p1").unwrap().1;
    assert!(matches!(outcome, Some(Outcome { .. })));
}

#[test]
fn a_journal_that_was_moved_or_replaced_is_not_written_to_until_it_is_put_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("journal.redb");
    let (journal, health) = journal_in(&path);
    let mut own = Own::load(&journal, "a");
    own.place("p1");
    let copy = std::fs::read(&path).unwrap();
    let elsewhere = folder.path().join("elsewhere.redb");
    std::fs::rename(&path, &elsewhere).unwrap();
    let change = own.accepting("p2");
    for replacement in [None, Some(copy)] {
        if let Some(bytes) = replacement {
            std::fs::write(&path, bytes).unwrap();
        }
        let error = own.write(&change).unwrap_err();
        let reason = error.moved().unwrap();
        assert!(
            reason.contains("journal.redb") && reason.contains("put that file back"),
            "{reason}"
        );
        assert!(!health.is_ready());
    }
    std::fs::rename(&elsewhere, &path).unwrap();
    own.place("p3");
    assert!(health.is_ready());
    let ledger = own.ledger;
    drop((own.journal, journal));
    assert_eq!(Own::load(&journal_in(&path).0, "a").ledger, ledger);
}

#[test]
fn an_older_copy_of_the_journal_is_put_aside_until_it_is_said_to_be_a_backup() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("journal.redb");
    let before = in_file(&path);
    let copy = std::fs::read(&path).unwrap();
    for is_backup in [false, true] {
        // Far enough that the copy is older.
        in_file(&path);
        in_file(&path);
        std::fs::write(&path, &copy).unwrap();
        let aside = count_put_aside(folder.path());
        if is_backup {
            assert_eq!(after_restore(&path).unwrap(), ["a"]);
        }
        let again = Own::load(&journal_in(&path).0, "a").ledger;
        assert_eq!(again.placement("p1").is_some(), is_backup);
        assert_eq!(count_put_aside(folder.path()) > aside, !is_backup);
        let stale = placement("p9", before.head().state_number);
        assert_eq!(again.judge(&stale), PlacementVerdict::Forgotten);
    }
}

#[test]
fn the_journal_of_another_version_is_refused_and_left_as_it_is() {
    let disk = Disk::default();
    let (kept, _) = journal(&disk);
    let mut own = Own::load(&kept, "c1");
    own.step(own.ledger.no_change());
    let ledger = own.ledger;
    drop((own.journal, kept));
    let format: redb::TableDefinition<'_, &str, u64> = redb::TableDefinition::new("format");
    let set = |version: u64| {
        let database = Builder::new().create_with_backend(disk.clone()).unwrap();
        let transaction = database.begin_write().unwrap();
        let mut table = transaction.open_table(format).unwrap();
        table.insert("version", version).unwrap();
        drop(table);
        transaction.commit().unwrap();
    };
    for version in [4, 6] {
        set(version);
        let (other, health) = journal(&disk);
        let refused = CellJournal::new(Some(other), cell("c1")).load();
        let text = refused.unwrap_err().to_string();
        let format = format!("format {version}");
        for part in ["another version", &format, "run that version"] {
            assert!(text.contains(part), "{text}");
        }
        assert!(!health.is_ready());
    }
    set(5);
    let (again, _) = journal(&disk);
    assert_eq!(Own::load(&again, "c1").ledger, ledger);
}

/// A file stays readable as long as its version is the same.
#[test]
fn what_is_written_is_encoded_as_this_version_does() {
    let mut ledger = Ledger::beginning_at(77);
    ledger.apply(ledger.accept(placement("p1", 77)));
    let end = ledger.end_placement(placed(), vec![body("a")]);
    ledger.apply(end);
    ledger.apply(ledger.begin_renewal("r1".to_owned()));
    ledger.apply(ledger.hold(Hold::new("h1", "door", "a door is open")));
    let mut written = database::encode(ledger.head()).unwrap();
    for (_, record) in ledger.records() {
        written.extend(database::encode(record).unwrap());
    }
    let hex: String = written.iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(hex, ENCODED);
}

/// A head, a placement that was carried out, and a renewal under way.
const ENCODED: &str = "\
    4e4d0102683104646f6f720e6120646f6f72206973206f70656e000301016103626f78010000000000000000\
    00000000000000000000000000000000000000000000f03f9a9999999999b93f9a9999999999c93f00000000\
    0000d03f0100027031076974656d2d703103626f780000000000000000000000000000000000000000000000\
    00000000000000f03f9a9999999999b93f9a9999999999c93f333333333333d33f4d01000001010000000000\
    00000000000000000000000000000000000000000000000000f03f9a9999999999b93f9a9999999999c93f00\
    0000000000d03f01000000000000000000000000000000004e0102723100";
