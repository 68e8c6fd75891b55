//! What commands print.

use std::io::Write;

use anyhow::Context;
pub(crate) use ppnpack_files::{StagedFolder, write_whole};

/// Prints a value as JSON on standard output.
pub(crate) fn print_json(value: &impl serde::Serialize) -> anyhow::Result<()> {
    let text = serde_json::to_string(value)?;
    print_line(&text)
}

/// Prints a line on standard output. That the reader went away is no failure: it has what it wanted.
pub(crate) fn print_line(text: &str) -> anyhow::Result<()> {
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(error).context("standard output cannot be written")
        }
        _ => Ok(()),
    }
}
