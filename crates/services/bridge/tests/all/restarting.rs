//! The real process, killed and started again.

use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::common::{Controller, cell, deadline, objects, place};
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::process::Process;
use ppnpack_service::stream::Latest;
use ppnpack_wire::MAX_CLOUD_BYTES;
use ppnpack_wire::keys::{Service, Stream};
use ppnpack_wire::v1::{self, ExecutionPhase, OutcomeKind, Status};

/// A bridge as a process, killed when dropped.
struct BridgeProcess(Child);

impl BridgeProcess {
    fn start(hub: &Hub, folder: &Path, place_duration_s: f64) -> Self {
        let set = |key: &str, value: &str| format!("--set={key}={value}");
        let quoted = |path: &Path| format!("\"{}\"", path.display());
        let child = Command::new(env!("CARGO_BIN_EXE_ppnpack-bridge"))
            .arg(set("zenoh.connect", &format!("[\"{}\"]", hub.endpoint())))
            .arg(set("admin.listen", "off"))
            .arg(set("log.filter", "warn"))
            .arg(set(
                "service.journal",
                &quoted(&folder.join("journal/bridge.redb")),
            ))
            .arg(set("service.catalogue", &quoted(&folder.join("objects"))))
            .arg(set(
                "service.cells",
                &format!("{{ cell-1 = {{ place_duration_s = {place_duration_s:?} }} }}"),
            ))
            .env("XDG_CACHE_HOME", folder.join("cache"))
            .stdin(Stdio::null())
            .spawn()
            .unwrap();
        Self(child)
    }

    /// SIGKILL.
    fn kill(mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }
}

impl Drop for BridgeProcess {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

struct Rig {
    controller: Controller,
    caller: Process,
    hub: Hub,
    folder: tempfile::TempDir,
}

impl Rig {
    fn new() -> Self {
        let hub = embedded::hub().unwrap();
        let caller = embedded::process(&hub, Service::Planner, "test").unwrap();
        let folder = tempfile::tempdir().unwrap();
        std::fs::rename(objects().keep(), folder.path().join("objects")).unwrap();
        Self {
            controller: Controller::new(caller.session()),
            caller,
            hub,
            folder,
        }
    }

    fn start(&self, place_duration_s: f64) -> BridgeProcess {
        BridgeProcess::start(&self.hub, self.folder.path(), place_duration_s)
    }

    /// The points of the next cloud.
    fn points(&self) -> (u64, Vec<u8>) {
        let clouds: Latest<v1::PointCloud> =
            Latest::subscribe(&self.caller, &cell(), Stream::Cloud, MAX_CLOUD_BYTES).unwrap();
        let cloud = clouds.wait(deadline()).unwrap().message.unwrap();
        (cloud.state_number, cloud.data)
    }
}

#[test]
fn killed_between_acceptance_and_outcome_nothing_is_lost_and_nothing_done_twice() {
    let rig = Rig::new();
    let controller = &rig.controller;

    // Set-up: two items are placed, the second of which is then asked for again.
    let bridge = rig.start(0.0);
    let state = controller.state_number();
    for (index, (id, x_m)) in [("p1", 0.08), ("p2", 0.2)].into_iter().enumerate() {
        controller.place(place(id, state + index as u64, x_m));
        assert_eq!(controller.outcome(id).kind(), OutcomeKind::Placed);
    }
    let before = controller.state_apart_from_time();
    let outcomes = ["p1", "p2"].map(|id| controller.outcome(id));
    let seen = rig.points();
    bridge.kill();

    // Fault: killed while a third one takes its time.
    let bridge = rig.start(600.0);
    assert_eq!(controller.state_apart_from_time(), before);
    assert_eq!(rig.points(), seen);
    let third = place("p3", before.state_number, 0.14);
    assert_eq!(
        controller.place(third.clone()).phase(),
        ExecutionPhase::Accepted
    );
    assert_eq!(controller.state().executing_placement_id, "p3");
    bridge.kill();

    // Recovery and invariants.
    let _bridge = rig.start(0.0);
    assert_eq!(controller.state_apart_from_time(), before);
    assert_eq!(rig.points(), seen);
    assert_eq!(["p1", "p2"].map(|id| controller.outcome(id)), outcomes);
    let outcome = controller.outcome("p3");
    assert_eq!(outcome.kind(), OutcomeKind::NotPlaced);
    assert!(outcome.failure.contains("restarted"), "{}", outcome.failure);
    let again = controller.place(third);
    assert_eq!(again.phase(), ExecutionPhase::Ended);
    assert_eq!(again.outcome, Some(outcome));
    assert_eq!(controller.state_apart_from_time(), before);
    controller.place(place("p4", before.state_number, 0.14));
    assert_eq!(controller.outcome("p4").kind(), OutcomeKind::Placed);
    assert_eq!(controller.state().bodies.len(), 3);
}

#[test]
fn a_renewal_outlives_a_kill() {
    let rig = Rig::new();
    let bridge = rig.start(0.0);
    let state = rig.controller.state_number();
    rig.controller.place(place("p1", state, 0.16));
    rig.controller.outcome("p1");
    let renewed = rig.controller.renew("r1");
    bridge.kill();
    let _bridge = rig.start(0.0);
    assert_eq!(rig.controller.renew("r1"), renewed);
    let after = rig.controller.state();
    assert_eq!((after.state_number, after.bodies.len()), (renewed, 0));
}

#[test]
fn with_a_lost_or_damaged_journal_nothing_is_said_of_earlier_placements() {
    let rig = Rig::new();
    let journal = rig.folder.path().join("journal/bridge.redb");
    let bridge = rig.start(0.0);
    let request = place("p1", rig.controller.state_number(), 0.16);
    rig.controller.place(request.clone());
    rig.controller.outcome("p1");
    bridge.kill();

    let mut bytes = std::fs::read(&journal).unwrap();
    let middle = bytes.len() / 2;
    bytes
        .iter_mut()
        .skip(64)
        .take(middle)
        .for_each(|byte| *byte ^= 0x5a);
    std::fs::write(&journal, &bytes).unwrap();
    let bridge = rig.start(0.0);
    assert_eq!(rig.controller.refused(request.clone()), Status::Forgotten);
    let after = rig.controller.state();
    assert!(after.bodies.is_empty() && after.state_number > request.state_number + 1);
    let names = std::fs::read_dir(journal.parent().unwrap()).unwrap();
    let aside = names.filter(|entry| {
        let name = entry.as_ref().unwrap().file_name();
        name.to_string_lossy().contains("damaged")
    });
    assert_eq!(aside.count(), 1);
    bridge.kill();

    std::fs::remove_file(&journal).unwrap();
    let _bridge = rig.start(0.0);
    assert_eq!(rig.controller.refused(request), Status::Forgotten);
    assert_ne!(rig.controller.state_number(), after.state_number);
}
