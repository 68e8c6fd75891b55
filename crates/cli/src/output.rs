//! What commands print.

use std::io::Write;

use anyhow::Context;
use comfy_table::Table;
use comfy_table::presets::UTF8_HORIZONTAL_ONLY;

/// Rows under a header as a table for the terminal.
pub(crate) fn columns<const N: usize>(
    header: [&str; N],
    rows: impl IntoIterator<Item = [String; N]>,
) -> String {
    let mut table = table();
    table.set_header(header);
    for row in rows {
        table.add_row(row);
    }
    table.to_string()
}

/// Names and values as a table for the terminal.
pub(crate) fn rows<Name: Into<String>>(rows: impl IntoIterator<Item = (Name, String)>) -> String {
    let mut table = table();
    for (name, value) in rows {
        table.add_row([name.into(), value]);
    }
    table.to_string()
}

fn table() -> Table {
    let mut table = Table::new();
    table.load_style(UTF8_HORIZONTAL_ONLY);
    table
}

/// Prints a value as JSON where that is asked for, and as text for people otherwise.
pub(crate) fn print(
    value: &impl serde::Serialize,
    as_json: bool,
    text: impl FnOnce() -> String,
) -> anyhow::Result<()> {
    if as_json {
        print_json(value)
    } else {
        print_line(&text())
    }
}

/// Prints a value as JSON on standard output.
///
/// # Errors
/// That it cannot be written.
pub fn print_json(value: &impl serde::Serialize) -> anyhow::Result<()> {
    let text = serde_json::to_string(value)?;
    print_line(&text)
}

/// Prints a line on standard output. That the reader went away is no failure: it has what it wanted.
///
/// # Errors
/// That it cannot be written for another reason.
pub fn print_line(text: &str) -> anyhow::Result<()> {
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(error).context("standard output cannot be written")
        }
        _ => Ok(()),
    }
}
