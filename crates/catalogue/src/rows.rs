//! Tables with a header, as CSV.

use std::fs::File;

use serde::de::DeserializeOwned;

/// Reads the rows of a table, each with its line, from 1. An error has the line and what is wrong
/// there; where a row lacks a column, also what is `needed`.
pub(crate) fn rows<Row: DeserializeOwned>(
    file: File,
    needed: &str,
) -> impl Iterator<Item = Result<(u64, Row), (u64, String)>> {
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_reader(file);
    let headers = reader.headers().cloned();
    let (headers, unreadable) = match headers {
        Ok(headers) => (headers, None),
        Err(error) => (csv::StringRecord::new(), Some(Err((1, error.to_string())))),
    };
    let line = |position: Option<&csv::Position>| position.map_or(0, csv::Position::line);
    let rows = reader.into_records().map(move |record| {
        let record = record.map_err(|error| (line(error.position()), error.to_string()))?;
        let line = line(record.position());
        let row = record.deserialize(Some(&headers));
        Ok((
            line,
            row.map_err(|error| (line, format!("{error}; {needed}")))?,
        ))
    });
    unreadable.into_iter().chain(rows)
}
