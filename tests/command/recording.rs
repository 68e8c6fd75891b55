//! Recordings, made by the program as a running stack works: read by others, inspected, planned
//! again.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::{Duration, Instant};

use nix::sys::signal::Signal;
use ppnpack_wire::v1;
use prost::Message;
use prost_reflect::{DescriptorPool, DynamicMessage};
use serde_json::Value;
use tempfile::TempDir;

use crate::support::{Running, command, errors, fails, has, names, packed, ppnpack, text};

/// The grid on which steps are planned.
const GRID: &str = "--cell 1cm --yaws 4";

/// A stack that is recorded into a folder.
struct Recorded {
    up: Running,
    recorder: Running,
    folder: TempDir,
}

impl Recorded {
    fn start(options: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let up = Running::up(GRID);
        let mut command = command(&format!("record --connect {} {options}", up.endpoint()));
        command.arg("--out").arg(folder.path().join("recordings"));
        let recorder = Running::start(command, "Recording");
        Self {
            up,
            recorder,
            folder,
        }
    }

    /// Packs some items through the stack.
    fn pack(&self, options: &str) {
        packed(&format!(
            "up --pack --connect {} {GRID} {options}",
            self.up.endpoint()
        ));
    }

    fn files(&self) -> Vec<PathBuf> {
        let recordings = self.folder.path().join("recordings");
        let files = names(&recordings).into_iter();
        files.map(|name| recordings.join(name)).collect()
    }
}

fn asked(command: &str, file: &Path) -> Output {
    ppnpack(&format!("{command} --json {}", file.display()))
}

/// Reads the output of a command, whether it succeeded or not.
fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|error| panic!("{error}: {}", errors(output)))
}

/// Counts the messages of each channel by the format's own library; each is decoded whole by its
/// own schema.
fn decoded(file: &Path) -> BTreeMap<String, usize> {
    let bytes = std::fs::read(file).unwrap();
    let mut counts = BTreeMap::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let channel = &message.channel;
        let schema = channel.schema.as_ref().unwrap();
        assert_eq!(
            (schema.encoding.as_str(), channel.message_encoding.as_str()),
            ("protobuf", "protobuf")
        );
        let pool = DescriptorPool::decode(schema.data.as_ref()).unwrap();
        let descriptor = pool.get_message_by_name(&schema.name).unwrap();
        let decoded = DynamicMessage::decode(descriptor, message.data.as_ref()).unwrap();
        let unknown = decoded.unknown_fields().count();
        assert_eq!(
            unknown, 0,
            "{} has fields that its schema does not have",
            channel.topic
        );
        *counts.entry(channel.topic.clone()).or_default() += 1;
    }
    counts
}

/// A copy of a recording in which the decision of a step is another one.
fn changed(file: &Path, to: &Path, change: impl Fn(&mut v1::Decision), of_step: u64) {
    let bytes = std::fs::read(file).unwrap();
    let mut writer = mcap::Writer::new(std::fs::File::create(to).unwrap()).unwrap();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let mut message = message.unwrap();
        if message.channel.topic.ends_with("/record") {
            let mut record = v1::PlanningRecord::decode(message.data.as_ref()).unwrap();
            if record.step == of_step {
                change(record.decision.as_mut().unwrap());
            }
            message.data = record.encode_to_vec().into();
        }
        writer.write(&message).unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn what_a_stack_does_is_recorded_and_decided_again() {
    let mut recorded = Recorded::start("");
    // Eight that all find a place: a step that sets an item aside is a record without a plan.
    recorded.pack("--random 8 --seed 1");
    assert_eq!(recorded.recorder.signal(Signal::SIGINT), Some(0));
    let files = recorded.files();
    assert_eq!(files.len(), 1, "{files:?}");
    let file = &files[0];

    let counts = decoded(file);
    for stream in "heightmap state outcome plan session record shape".split(' ') {
        let topic = format!("/cell-1/{stream}");
        assert!(counts.contains_key(&topic), "{topic}: {counts:?}");
    }
    assert!(counts["/all/health"] >= 4, "{counts:?}");
    let decisions = counts["/cell-1/plan"] as u64;
    assert_eq!(decisions, 8);

    let inspected = asked("inspect", file);
    assert!(inspected.status.success());
    let contents = json(&inspected);
    assert_eq!(contents["is_whole"], true, "{contents}");
    assert_eq!(contents["decisions"]["decided"], decisions, "{contents}");
    let plans = &contents["topics"]["/cell-1/plan"];
    assert_eq!(plans["messages"], decisions);
    assert_eq!(plans["schema"], "ppnpack.v1.Decision");
    assert_eq!(contents["cells"], serde_json::json!(["cell-1"]));

    let replayed = asked("replay", file);
    let again = json(&replayed);
    assert_eq!(again["equal"], decisions, "{again}");
    assert_eq!(again["different"], serde_json::json!([]), "{again}");
    assert_eq!(again["not_replayed"], serde_json::json!({}), "{again}");
    assert!(replayed.status.success());
    is_told_to_people(file);

    several_are_told_one_after_another(file, recorded.folder.path());
    is_found_where_it_was_changed(file, recorded.folder.path());
    is_said_to_be_damaged(file, recorded.folder.path());
}

fn is_told_to_people(file: &Path) {
    for (command, parts) in [
        (
            "inspect",
            &["8 decided", "whole", "/cell-1/plan", "ppnpack.v1.Decision"][..],
        ),
        ("replay", &["8 steps go as they were recorded, bit for bit"]),
    ] {
        let told = text(&ppnpack(&format!("{command} {}", file.display())));
        has(&told, parts);
    }
}

fn several_are_told_one_after_another(file: &Path, folder: &Path) {
    let nothing = folder.join("nothing.mcap");
    std::fs::write(&nothing, "").unwrap();
    let files = format!("{} {}", nothing.display(), file.display());
    let told = text(&ppnpack(&format!("replay {files}")));
    let parts = [
        "nothing.mcap:\nno step is recorded here",
        "8 steps go as they were recorded, bit for bit",
    ];
    has(&told, &parts);
    let inspected = text(&ppnpack(&format!("inspect --json {files}")));
    assert_eq!(inspected.lines().count(), 2, "{inspected}");
}

fn is_found_where_it_was_changed(file: &Path, folder: &Path) {
    let other = folder.join("changed.mcap");
    let change = |decision: &mut v1::Decision| decision.value = decision.value.next_up();
    changed(file, &other, change, 3);
    let replayed = asked("replay", &other);
    let again = json(&replayed);
    assert_eq!(replayed.status.code(), Some(1), "{again}");
    assert_eq!(again["equal"], 7, "{again}");
    let different = &again["different"][0];
    assert_eq!(different["step"], 3, "{again}");
    assert_eq!(different["field"], "value", "{again}");
    assert_ne!(different["recorded"], different["replayed"], "{again}");
    let error = errors(&replayed);
    assert!(error.contains("step 3: value is recorded as"), "{error}");
}

/// The largest record of a file that is a chunk: an opcode and a length are before each record.
fn largest_chunk(bytes: &[u8]) -> std::ops::Range<usize> {
    let mut chunks = Vec::new();
    let mut at = mcap::MAGIC.len();
    while at + 9 <= bytes.len() - mcap::MAGIC.len() {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap());
        let end = at + 9 + usize::try_from(length).unwrap();
        if bytes[at] == mcap::records::op::CHUNK {
            chunks.push(at + 9..end);
        }
        at = end;
    }
    chunks
        .into_iter()
        .max_by_key(ExactSizeIterator::len)
        .unwrap()
}

fn is_said_to_be_damaged(file: &Path, folder: &Path) {
    let mut bytes = std::fs::read(file).unwrap();
    let chunk = largest_chunk(&bytes);
    let middle = (chunk.start + chunk.end) / 2;
    for byte in &mut bytes[middle..middle + 16] {
        *byte ^= 0x55;
    }
    let damaged = folder.join("damaged.mcap");
    std::fs::write(&damaged, &bytes).unwrap();
    for command in ["inspect", "replay"] {
        let output = asked(command, &damaged);
        fails(&output, 1, &["damaged at byte"]);
    }
    let other = folder.join("other.mcap");
    std::fs::write(&other, "no recording").unwrap();
    let output = asked("inspect", &other);
    fails(&output, 2, &["is no MCAP file"]);
}

#[test]
fn a_recorder_that_is_killed_leaves_what_it_had_flushed() {
    let mut recorded = Recorded::start("--without cloud");
    recorded.pack("--random 3");
    let file = recorded.files()[0].clone();
    // The recorder flushes every second.
    let deadline = Instant::now() + Duration::from_secs(20);
    let decided = loop {
        let contents = json(&asked("inspect", &file));
        let decided = contents["decisions"]["decided"].as_u64().unwrap();
        if decided == 3 {
            assert_eq!(contents["is_whole"], false, "{contents}");
            break decided;
        }
        assert!(Instant::now() < deadline, "{contents}");
        std::thread::sleep(Duration::from_millis(50));
    };
    // The cell goes on to publish its state: the recorder is killed as it writes.
    recorded.recorder.signal(Signal::SIGKILL);
    let contents = json(&asked("inspect", &file));
    assert_eq!(contents["is_whole"], false, "{contents}");
    assert_eq!(contents["decisions"]["decided"], decided, "{contents}");
    assert!(
        contents["topics"].get("/cell-1/cloud").is_none(),
        "{contents}"
    );
    let replayed = asked("replay", &file);
    let again = json(&replayed);
    assert_eq!(again["equal"], decided, "{again}");
    assert!(replayed.status.success(), "{again}");
    assert_eq!(again["is_whole"], false, "{again}");
}

#[test]
fn recordings_go_on_in_other_files_and_the_oldest_are_deleted() {
    let mut recorded = Recorded::start("--rotate-size 1B --keep 2");
    recorded.pack("--random 2");
    assert_eq!(recorded.recorder.signal(Signal::SIGINT), Some(0));
    let files = recorded.files();
    assert_eq!(files.len(), 2, "{files:?}");
    for file in &files {
        let contents = json(&asked("inspect", file));
        assert_eq!(contents["is_whole"], true, "{contents}");
    }
}
