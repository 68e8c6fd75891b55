//! The commands of the guides do what the guides say: every `sh` block of README.md, docs/guides and [`REFERENCE`] is run, those of a page in
//! one shell, in a folder of its own. What follows `sh` says how:
//!
//! - nothing: it has to end with 0;
//! - `beside`: one command that runs beside those after it, as in a terminal of its own; they begin when it says that it is ready;
//! - `ends-beside`: it is run when what runs beside was ended, the last of it alone, as by Ctrl-C;
//! - `not-run: REASON`: it cannot be run here, for one of the reasons of [`NOT_RUN`].

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a panic in a test is a failing test"
)]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::net::TcpListener;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

/// Why blocks are not run, and how many there are for each reason: one more is one that nobody tries.
const NOT_RUN: [(&str, usize); 6] = [
    // `cargo build` and what begins with it; scripts/run and scripts/test are tried from a fresh clone.
    ("compiles", 5),
    // From package registries. deploy/test-stack runs the Python controller.
    ("fetches packages", 3),
    // deploy/test-stack runs the stack in containers, with and without certificates.
    ("needs a Docker engine", 1),
    // scripts/test-python runs Ray on one machine.
    ("needs a cluster", 1),
    // scripts/test-python builds it, and runs what is shown.
    ("needs the Python package", 3),
    ("takes hours", 2),
];

/// Pages of the reference whose commands are held to the same.
const REFERENCE: [&str; 2] = ["docs/python.md", "docs/recording.md"];

/// Guides that are run at the same time.
const AT_ONCE: usize = 2;

/// How long one guide may take at most, in seconds: far more than any does.
const LIMIT_S: u32 = 300;

#[derive(Debug, Clone, PartialEq)]
enum How {
    Run,
    Beside,
    EndsBeside,
    Not(String),
}

/// A block of commands.
#[derive(Debug, Clone, PartialEq)]
struct Block {
    /// Of its first command, from 1.
    line: usize,
    how: How,
    commands: String,
}

struct Guide {
    name: String,
    blocks: Vec<Block>,
}

fn root() -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    root.canonicalize().unwrap()
}

/// How a block is run, by what stands behind its fence; `None` where it has no commands.
fn how(info: &str) -> Option<How> {
    let (language, marker) = info.split_once(',').unwrap_or((info, ""));
    match (language, marker) {
        ("sh", "") => Some(How::Run),
        ("sh", "beside") => Some(How::Beside),
        ("sh", "ends-beside") => Some(How::EndsBeside),
        ("sh", other) => match other.strip_prefix("not-run: ") {
            Some(reason) => Some(How::Not(reason.to_owned())),
            None => panic!("a block of commands is marked as '{other}'"),
        },
        ("bash" | "shell" | "console", _) => panic!("a block of commands begins with ```sh"),
        _ => None,
    }
}

/// The blocks of commands of a page.
fn blocks(text: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut lines = (1..).zip(text.lines());
    while let Some((number, line)) = lines.next() {
        let Some(info) = line.strip_prefix("```") else {
            continue;
        };
        let mut commands = String::new();
        for (_, line) in lines.by_ref().take_while(|(_, line)| *line != "```") {
            commands += line;
            commands.push('\n');
        }
        blocks.extend(how(info).map(|how| Block {
            line: number + 1,
            how,
            commands,
        }));
    }
    blocks
}

fn guides() -> Vec<Guide> {
    let root = root();
    let folder = fs::read_dir(root.join("docs/guides")).unwrap();
    let mut pages: Vec<PathBuf> = folder.map(|entry| entry.unwrap().path()).collect();
    pages.extend(REFERENCE.map(|page| root.join(page)));
    pages.push(root.join("README.md"));
    pages.sort();
    let guide = |page: &PathBuf| Guide {
        name: page.strip_prefix(&root).unwrap().display().to_string(),
        blocks: blocks(&fs::read_to_string(page).unwrap()),
    };
    pages.iter().map(guide).collect()
}

/// One script of a guide's blocks, which says before each where it stands.
fn script(guide: &Guide) -> String {
    // What runs beside ends with the script.
    let mut script =
        "set -euo pipefail\ntrap 'kill $(jobs -p) 2>/dev/null || true; wait' EXIT\n".to_owned();
    for block in &guide.blocks {
        let (name, line, commands) = (&guide.name, block.line, &block.commands);
        match block.how {
            How::Not(_) => continue,
            How::Run => writeln!(script, "echo '>>> {name}:{line}'\n{commands}").unwrap(),
            How::EndsBeside => writeln!(
                script,
                "echo '>>> {name}:{line}'\nkill \"$beside\"\nwait \"$beside\"\n{commands}"
            )
            .unwrap(),
            How::Beside => {
                let command = commands.trim_end();
                assert!(
                    !command.contains('\n'),
                    "{name}:{line}: one command runs beside"
                );
                writeln!(
                    script,
                    "echo '>>> {name}:{line}, beside'\n{}",
                    beside(command)
                )
                .unwrap();
            }
        }
    }
    script
}

/// A command in the background, and the wait for the line that says that it is ready. Where it ends before, the script fails.
fn beside(command: &str) -> String {
    format!(
        "mkfifo said; {command} > said 2>&1 & beside=$!; exec 3< said; rm said\n\
         while true; do read -r line <&3; echo \"$line\"; [[ $line == Ready* || $line == Recording* ]] && break; done\n\
         cat <&3 &\n"
    )
}

/// A folder with what the commands find in the repository, and the programs.
fn place() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in ["examples", "experiments"] {
        symlink(root().join(name), folder.path().join(name)).unwrap();
    }
    let programs = folder.path().join("programs");
    fs::create_dir(&programs).unwrap();
    // This one has the commands of all three, and is what a test build makes anew.
    symlink(
        env!("CARGO_BIN_EXE_ppnpack-torch"),
        programs.join("ppnpack"),
    )
    .unwrap();
    folder
}

/// Where the stacks of a guide listen: an address of this machine that nothing else uses, with a port that the system finds free.
fn endpoint(number: usize) -> String {
    let process = std::process::id();
    let address = format!(
        "127.{}.{}.{}",
        64 + number % 64,
        process / 256 % 256,
        1 + process % 254
    );
    let port = TcpListener::bind((address.as_str(), 0)).unwrap();
    format!("tcp/{}", port.local_addr().unwrap())
}

/// Runs a guide's commands; says what they said where they fail.
fn run(number: usize, guide: &Guide) -> Result<(), String> {
    let place = place();
    fs::write(place.path().join("script"), script(guide)).unwrap();
    let path = std::env::var("PATH").unwrap();
    let programs = place.path().join("programs");
    // It ends the whole group of processes.
    let output = Command::new("timeout")
        .args(["--kill-after=5", &LIMIT_S.to_string(), "bash", "-c"])
        .arg("bash ./script 2>&1")
        .current_dir(place.path())
        .env("PATH", format!("{}:{path}", programs.display()))
        .env(
            "XDG_CACHE_HOME",
            Path::new(env!("CARGO_TARGET_TMPDIR")).join("cache"),
        )
        .env("PPNPACK_ENDPOINT", endpoint(number))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    match output.status.success() {
        true => Ok(()),
        false => Err(format!("{}: {}\n{said}", guide.name, output.status)),
    }
}

#[test]
fn every_command_of_the_guides_runs() {
    let guides = guides();
    assert!(guides.len() > 10, "{}", guides.len());
    let todo = Mutex::new(guides.iter().enumerate());
    let failures = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..AT_ONCE {
            scope.spawn(|| {
                loop {
                    let Some((number, guide)) = todo.lock().unwrap().next() else {
                        break;
                    };
                    let started = std::time::Instant::now();
                    let done = run(number, guide);
                    eprintln!("{}: {:.1} s", guide.name, started.elapsed().as_secs_f64());
                    failures.lock().unwrap().extend(done.err());
                }
            });
        }
    });
    let failures = failures.into_inner().unwrap();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn what_is_not_run_has_one_of_the_known_reasons() {
    let mut found: BTreeMap<String, usize> = BTreeMap::new();
    for guide in guides() {
        for block in guide.blocks {
            if let How::Not(reason) = block.how {
                *found.entry(reason).or_default() += 1;
            }
        }
    }
    let known = NOT_RUN.map(|(reason, count)| (reason.to_owned(), count));
    assert_eq!(found, BTreeMap::from(known));
}

#[test]
fn blocks_are_read_with_their_markers() {
    let text = "a\n```sh\ncd b\n```\n```rust\nfn c() {}\n```\n```sh,beside\nd\n```\n\n```sh,ends-beside\nf\n```\n```sh,not-run: takes hours\ne\n```\n";
    let block = |line, how, commands: &str| Block {
        line,
        how,
        commands: commands.to_owned(),
    };
    let expected = [
        block(3, How::Run, "cd b\n"),
        block(9, How::Beside, "d\n"),
        block(13, How::EndsBeside, "f\n"),
        block(16, How::Not("takes hours".to_owned()), "e\n"),
    ];
    assert_eq!(blocks(text), expected);
}

#[test]
fn a_command_that_fails_is_found() {
    let guide = |text: &str| Guide {
        name: "guide".to_owned(),
        blocks: blocks(text),
    };
    run(0, &guide("```sh\nppnpack --version\n```\n")).unwrap();
    let error = run(0, &guide("```sh\ntrue\n```\n```sh\nfalse\ntrue\n```\n")).unwrap_err();
    assert!(
        error.contains(">>> guide:5") && error.contains("exit status: 1"),
        "{error}"
    );
    // What is to run beside, and ends.
    assert!(run(0, &guide("```sh,beside\necho no\n```\n```sh\ntrue\n```\n")).is_err());
    run(
        0,
        &guide("```sh,beside\nsh -c 'echo Ready; exec sleep 600'\n```\n```sh\ntrue\n```\n"),
    )
    .unwrap();
    // What does not end as it is told to.
    let stubborn = "```sh,beside\nsh -c 'trap \"exit 3\" TERM; echo Ready; while :; do sleep 0.1; done'\n```\n";
    let error = run(
        0,
        &guide(&format!("{stubborn}```sh,ends-beside\ntrue\n```\n")),
    )
    .unwrap_err();
    assert!(error.contains("exit status: 3"), "{error}");
}
