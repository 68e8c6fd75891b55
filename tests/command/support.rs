//! The program as a user runs it.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::Value;
use tempfile::TempDir;

use crate::printed::is_refused;
pub(crate) use crate::printed::{errors, json, text};

/// The program with these words behind its name. All tests share a cache: the objects are prepared
/// once.
pub(crate) fn command(words: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ppnpack"));
    command.args(words.split_whitespace());
    command.env("XDG_CACHE_HOME", cache());
    command
}

pub(crate) fn ppnpack(words: &str) -> Output {
    command(words).output().unwrap()
}

pub(crate) fn cache() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("cache")
}

/// A copy of the program that lies in a folder alone.
pub(crate) fn alone(folder: &TempDir, words: &str) -> Output {
    let program = folder.path().join("ppnpack");
    std::fs::copy(env!("CARGO_BIN_EXE_ppnpack"), &program).unwrap();
    let mut command = Command::new(program);
    command.args(words.split_whitespace());
    command.env("XDG_CACHE_HOME", cache()).output().unwrap()
}

/// Runs a command that must be refused with exit code 2 and a message that has all of these parts.
pub(crate) fn refused(words: &str, parts: &[&str]) {
    is_refused(&ppnpack(words), parts);
}

/// Asserts that a program ended with this code and a message that has all of these parts.
pub(crate) fn fails(output: &Output, code: i32, parts: &[&str]) {
    let error = errors(output);
    assert_eq!(output.status.code(), Some(code), "{error}");
    has(&error, parts);
}

pub(crate) fn has(text: &str, parts: &[&str]) {
    for part in parts {
        let begin: String = text.chars().take(2000).collect();
        assert!(text.contains(part), "'{part}' is not in: {begin}");
    }
}

/// The files and the summary that packing left.
pub(crate) struct Packed {
    pub(crate) folder: TempDir,
    pub(crate) summary: Value,
}

/// Packs by `pack` or another command with these options.
pub(crate) fn packed(words: &str) -> Packed {
    let folder = tempfile::tempdir().unwrap();
    let mut command = command(words);
    let summary = command.arg("--json").arg("--out").arg(folder.path());
    Packed {
        summary: json(&summary.output().unwrap()),
        folder,
    }
}

impl Packed {
    fn file(&self, name: &str) -> String {
        std::fs::read_to_string(self.folder.path().join(name)).unwrap()
    }

    pub(crate) fn page(&self) -> String {
        self.file("report.html")
    }

    /// The lines of the placements' table, the first with the names of its columns.
    pub(crate) fn placements(&self) -> Vec<Vec<String>> {
        let text = self.file("placements.csv");
        let lines = text.lines();
        let fields = lines.map(|line| line.split(',').map(str::to_owned).collect());
        fields.collect()
    }

    /// The data of the page's viewer.
    pub(crate) fn playback(&self) -> Value {
        let page = self.page();
        let (_, data) = page.split_once("id=playback-data>").unwrap();
        let (data, _) = data.split_once("</script>").unwrap();
        serde_json::from_str(data).unwrap()
    }
}

pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}

/// A running program, ended with the test, which has printed that it is ready.
pub(crate) struct Running {
    child: Child,
    lines: Vec<String>,
}

impl Drop for Running {
    fn drop(&mut self) {
        drop(self.child.kill());
        drop(self.child.wait());
    }
}

impl Running {
    pub(crate) fn start(mut command: Command, ready: &str) -> Self {
        let command = command.stdout(Stdio::piped()).stderr(Stdio::inherit());
        let mut running = Self {
            child: command.spawn().unwrap(),
            lines: Vec::new(),
        };
        let printed = running.child.stdout.take().unwrap();
        for line in BufReader::new(printed).lines() {
            running.lines.push(line.unwrap());
            if running.lines.last().unwrap().starts_with(ready) {
                return running;
            }
        }
        panic!("it ended before it was ready: {:?}", running.lines);
    }

    /// A stack with these options.
    pub(crate) fn up(options: &str) -> Self {
        Self::start(
            command(&format!("up --listen tcp/127.0.0.1:0 {options}")),
            "Ready",
        )
    }

    /// The rest of the line that it printed behind a word.
    pub(crate) fn said(&self, word: &str) -> &str {
        let mut lines = self.lines.iter();
        lines.find_map(|line| line.strip_prefix(word)).unwrap()
    }

    pub(crate) fn endpoint(&self) -> &str {
        self.said("Zenoh: ")
    }

    /// Has it end, and gives its exit code.
    pub(crate) fn signal(&mut self, signal: Signal) -> Option<i32> {
        kill(Pid::from_raw(self.child.id().try_into().unwrap()), signal).unwrap();
        self.child.wait().unwrap().code()
    }
}
