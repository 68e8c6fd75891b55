//! A disk that is full, and one that cannot be written to, under the session store and the journal.
//!
//! That takes a small file system of its own, and files that nobody may write to, which only root
//! can make. Without root the tests say so and are skipped, and fail where `CI` is set.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use crate::cell::CellClient;
use crate::disk::Disk;
use crate::stack::Stack;
use crate::tests::common::{
    self, OBJECTS, assert_consistent, assert_serves_again, not_placed, refused,
};
use ppnpack_wire::keys::Service;
use ppnpack_wire::v1::{self, Status};

/// The files of planner and bridge.
const FILES: [&str; 3] = ["sessions.redb", "bridge.redb", "sessions.cells/cell-1.redb"];

/// A stack whose planner and bridge write to this folder.
fn start(folder: &Path) -> (Stack, CellClient) {
    let [sessions, journal, _] = FILES.map(|name| folder.join(name).display().to_string());
    let options = common::with(&[
        (Service::Planner, &format!("service.store={sessions}")),
        (Service::Bridge, &format!("service.journal={journal}")),
    ]);
    common::started(&options)
}

/// Lets nobody write to the files of a folder, or everybody again; false where that is not possible
/// here.
fn set_immutable(folder: &Path, is_immutable: bool) -> bool {
    let mut change = Command::new("chattr");
    change.arg(if is_immutable { "+i" } else { "-i" });
    change.args(FILES.map(|name| folder.join(name)));
    change.output().is_ok_and(|output| output.status.success())
}

/// Lets everybody write to the files of a folder when it goes, so that they can be removed.
struct Released<'a>(&'a Path);

impl Drop for Released<'_> {
    fn drop(&mut self) {
        set_immutable(self.0, false);
    }
}

/// Checks that nothing is acknowledged while the folder cannot be written to, and all goes on
/// afterwards.
fn survives(folder: &Path, fault: &str, break_it: impl FnOnce(), mend_it: impl FnOnce()) {
    let (_stack, cell) = start(folder);
    cell.begin("disk", &OBJECTS, false).unwrap();
    cell.step().unwrap().unwrap();
    let decision = cell.plan().unwrap().unwrap();
    let (session, state) = (cell.session().unwrap(), cell.state().unwrap());

    break_it();
    let place = v1::PlaceRequest::from(&decision);
    refused(&cell, place.clone(), Status::Unavailable);
    // Held it is all the same.
    refused(&cell, v1::HoldRequest::default(), Status::Unavailable);
    assert!(cell.state().unwrap().hold.is_some());
    let report = v1::ReportRequest {
        decision_id: decision.decision_id.clone(),
        outcome: Some(v1::Outcome {
            kind: v1::OutcomeKind::NotPlaced.into(),
            ..v1::Outcome::default()
        }),
        ..v1::ReportRequest::default()
    };
    refused(&cell, report, Status::Unavailable);
    assert_eq!(cell.session().unwrap(), session);
    assert_eq!(cell.state().unwrap().state_number, state.state_number);

    mend_it();
    assert_serves_again(&cell, Instant::now(), fault);
    refused(&cell, place.clone(), Status::Held);
    cell.resume().unwrap();
    refused(&cell, place, Status::Stale);
    cell.report(&decision, not_placed(&cell)).unwrap();
    assert!(cell.step().unwrap().is_some());
    assert_consistent(&cell, "afterwards");
}

#[test]
fn a_full_disk_keeps_nothing_from_being_true() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path().join("disk");
    let Some(disk) = Disk::mount(&at, 8).unwrap() else {
        return common::skip("mounting a file system needs root");
    };
    survives(
        &at,
        "a full disk",
        || disk.fill().unwrap(),
        || disk.free().unwrap(),
    );
}

#[test]
fn a_disk_that_cannot_be_written_to_keeps_nothing_from_being_true() {
    let folder = tempfile::tempdir().unwrap();
    let files = FILES.map(|name| folder.path().join(name));
    std::fs::create_dir(folder.path().join("sessions.cells")).unwrap();
    for file in &files {
        std::fs::write(file, "").unwrap();
    }
    let is_possible = set_immutable(folder.path(), true) && set_immutable(folder.path(), false);
    for file in &files {
        std::fs::remove_file(file).unwrap();
    }
    if !is_possible {
        return common::skip("making files immutable needs root, and a file system that can");
    }
    let _released = Released(folder.path());
    survives(
        folder.path(),
        "a disk that cannot be written to",
        || assert!(set_immutable(folder.path(), true)),
        || assert!(set_immutable(folder.path(), false)),
    );
}
