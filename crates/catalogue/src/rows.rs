//! Tables with a header, as CSV, also as spreadsheets write them.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use csv::StringRecord;
use serde::de::DeserializeOwned;

/// Why a table cannot be read, and how to mend it, for people.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct TableError(String);

/// Reads a table that has at least one row, and gives each to `take`, which says what is wrong
/// with it; for the rest as [`rows`].
pub(crate) fn read<Row: DeserializeOwned>(
    path: &Path,
    known: &[&str],
    needed: &str,
    mut take: impl FnMut(Row) -> Result<(), String>,
) -> Result<(), TableError> {
    let name = path.display();
    let wrong = |(line, reason)| TableError(format!("{name}, line {line}: {reason}"));
    let file = File::open(path);
    let unread = |error| TableError(format!("the table {name} cannot be read: {error}"));
    let file = file.map_err(unread)?;
    let mut rows = rows::<Row>(file, known, needed).peekable();
    if rows.peek().is_none() {
        let empty = format!("{name} has no line below its header");
        return Err(TableError(empty));
    }
    for row in rows {
        let (line, row) = row.map_err(wrong)?;
        take(row).map_err(|reason| wrong((line, reason)))?;
    }
    Ok(())
}

/// Reads the rows of a table, each with its line, from 1. An error has the line and what is wrong
/// there; where a row lacks a column, also what is `needed`.
///
/// Columns are apart by commas, by semicolons or by tabs, with decimal commas beside the latter.
/// Rows without any value are left out. A column that is nearly a `known` one is wrong, others are
/// left out.
pub(crate) fn rows<Row: DeserializeOwned>(
    file: File,
    known: &[&str],
    needed: &str,
) -> impl Iterator<Item = Result<(u64, Row), (u64, String)>> {
    let mut file = BufReader::new(file);
    let delimiter = file.fill_buf().map_or(b',', delimiter);
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .delimiter(delimiter)
        .from_reader(file);
    let headers = reader.headers().map_err(|error| error.to_string());
    let headers = headers.and_then(|headers| checked(headers, known));
    let (headers, unreadable) = match headers {
        Ok(headers) => (headers, None),
        Err(error) => (StringRecord::new(), Some(Err((1, error)))),
    };
    let line = |position: Option<&csv::Position>| position.map_or(0, csv::Position::line);
    let rows = reader.into_records().filter_map(move |record| {
        let mut record = match record {
            Ok(record) => record,
            Err(error) => return Some(Err((line(error.position()), error.to_string()))),
        };
        let line = line(record.position());
        if record.iter().all(str::is_empty) {
            return None;
        }
        if delimiter != b',' {
            record = record.iter().map(with_point).collect();
        }
        let row = record.deserialize(Some(&headers));
        Some(match row {
            Ok(row) => Ok((line, row)),
            Err(error) => Err((line, fault(&error, &headers, &record, needed))),
        })
    });
    unreadable.into_iter().chain(rows)
}

/// Says what is wrong with a record: the value of a column, or that it lacks one that is `needed`.
fn fault(
    error: &csv::Error,
    headers: &StringRecord,
    record: &StringRecord,
    needed: &str,
) -> String {
    let value = || {
        let csv::ErrorKind::Deserialize { err, .. } = error.kind() else {
            return None;
        };
        let field = usize::try_from(err.field()?).ok()?;
        let (column, value) = (headers.get(field)?, record.get(field)?);
        Some(format!(
            "the column '{column}' has '{value}': {}",
            err.kind()
        ))
    };
    value().unwrap_or_else(|| format!("{error}; {needed}"))
}

/// Finds what the columns of a header are apart by.
fn delimiter(start: &[u8]) -> u8 {
    let header = start
        .split(|byte| *byte == b'\n')
        .next()
        .unwrap_or_default();
    let count = |delimiter: &u8| header.iter().filter(|byte| *byte == delimiter).count();
    let delimiters = [b'\t', b';', b','].into_iter();
    delimiters.max_by_key(count).unwrap_or(b',')
}

/// Writes a number with a point in place of its comma; leaves any other text as it is.
fn with_point(field: &str) -> String {
    let number = field.replace(',', ".");
    match number.parse::<f64>() {
        Ok(_) => number,
        Err(_) => field.to_owned(),
    }
}

/// Gives the header in lower case; refuses a column that is nearly a known one that it lacks.
fn checked(headers: &StringRecord, known: &[&str]) -> Result<StringRecord, String> {
    let headers: StringRecord = headers.iter().map(str::to_lowercase).collect();
    for header in headers.iter().filter(|header| !known.contains(header)) {
        let lacked = |name: &&&str| !headers.iter().any(|header| header == **name);
        let mut lacked = known.iter().filter(lacked);
        if let Some(near) = lacked.find(|name| is_near(header, name)) {
            return Err(format!(
                "the column '{header}' is not read: call it '{near}', or otherwise"
            ));
        }
    }
    Ok(headers)
}

/// Says whether one name begins the other, or hardly differs from it.
fn is_near(header: &str, name: &str) -> bool {
    let letters = |text: &str| text.replace(|letter: char| !letter.is_alphanumeric(), "");
    let (header, name) = (letters(header), letters(name));
    let shortest = header.len().min(name.len());
    let alike =
        |pairs: &mut dyn Iterator<Item = (char, char)>| pairs.take_while(|(a, b)| a == b).count();
    let start = alike(&mut header.chars().zip(name.chars()));
    let end = alike(&mut header.chars().rev().zip(name.chars().rev()));
    let differ = header.len().max(name.len()).saturating_sub(start + end);
    shortest >= 3 && (start == shortest || differ <= 1 + shortest / 6)
}
