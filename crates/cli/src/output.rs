//! Output of commands.

use std::io::Write;
use std::path::{Path, PathBuf};

use crate::failure::Outcome;
use crate::text::{self, Template};
use anyhow::Context;

/// Prints a value as JSON where that is asked for, and as a template's text for people otherwise.
pub(crate) fn print(
    value: &impl serde::Serialize,
    as_json: bool,
    template: Template,
) -> anyhow::Result<()> {
    if as_json {
        print_json(value)
    } else {
        print_line(text::render(template, value)?.trim_end())
    }
}

/// Does something with each file, under its name where there are several and that is no JSON. Gives
/// the first failure once all are done.
pub(crate) fn of_each(files: &[PathBuf], as_json: bool, act: impl Fn(&Path) -> Outcome) -> Outcome {
    let mut outcome = Ok(());
    for file in files {
        if files.len() > 1 && !as_json {
            print_line(&format!("{}:", file.display()))?;
        }
        outcome = outcome.and(act(file));
    }
    outcome
}

/// Prints a value as JSON on standard output.
pub fn print_json(value: &impl serde::Serialize) -> anyhow::Result<()> {
    let text = serde_json::to_string(value)?;
    print_line(&text)
}

/// Prints a line on standard output. That the reader went away is no failure: it has what it
/// wanted.
pub fn print_line(text: &str) -> anyhow::Result<()> {
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(error).context("standard output cannot be written")
        }
        _ => Ok(()),
    }
}
