//! Origin of an experiment's results.

use std::time::SystemTime;

use ppnpack_cli::failure::{OrRun, Outcome};
use serde::Serialize;

use crate::runs::program;

#[derive(Debug, Serialize)]
pub(crate) struct Origin {
    command: String,
    version: &'static str,
    /// The hash of the program, in hexadecimal digits.
    program_blake3: String,
    machine: String,
    /// The time in UTC, as in RFC 3339.
    made: String,
}

impl Origin {
    /// This program, this command, now.
    ///
    /// # Errors
    /// That the program's file cannot be read.
    pub(crate) fn now() -> Outcome<Self> {
        let arguments = std::env::args_os().skip(1);
        let arguments = arguments.map(|argument| quoted(&argument.to_string_lossy()));
        let arguments: Vec<String> = arguments.collect();
        Ok(Self {
            command: format!("ppnpack {}", arguments.join(" ")),
            version: env!("CARGO_PKG_VERSION"),
            program_blake3: program().or_run()?,
            machine: machine(),
            made: humantime::format_rfc3339_seconds(SystemTime::now()).to_string(),
        })
    }
}

/// An argument that a shell reads as it was.
fn quoted(argument: &str) -> String {
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "-_./=,:%+@".contains(letter);
    match !argument.is_empty() && argument.chars().all(is_plain) {
        true => argument.to_owned(),
        false => format!("'{}'", argument.replace('\'', "'\\''")),
    }
}

/// The processor that figures were measured on.
fn machine() -> String {
    let cpus = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let mut lines = cpus.lines();
    let model = lines.find_map(|line| line.strip_prefix("model name")?.split(':').nth(1));
    let model = model.map_or("unknown processor", str::trim);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    format!("{model}, {cores} cores")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_reads_arguments_as_they_were() {
        assert_eq!(quoted("--cell=1cm"), "--cell=1cm");
        assert_eq!(quoted("a b"), "'a b'");
        assert_eq!(quoted("it's"), "'it'\\''s'");
        assert_eq!(quoted(""), "''");
    }
}
