//! The figures in the documents are those of the files that they come from.
//!
//! Each mean with its interval (`a ± b`) in the generated part of `docs/results/NAME.md` has to be in a `NAME*.json` beside it. A figure
//! that is quoted elsewhere names its source in a comment that readers do not see:
//! `16.9<!-- docs/results/pareto.json#/grids/2/lines/0/decision_s/mean * 1000 --> ms`.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::panic,
    reason = "a panic in a test is a failing test"
)]

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

/// What follows is written by hand.
const NOTES: &str = "<!-- Notes:";

/// Documents whose generated part is of a run of which no JSON was kept.
const WITHOUT_JSON: [&str; 2] = ["loads.md", "stream.md"];

/// Results keep SI units and shares; tables show milliseconds, cubic centimetres and percent.
const FACTORS: [f64; 5] = [1.0, 100.0, 1e3, 1e6, 1e-3];

fn root() -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    root.canonicalize().unwrap()
}

fn json(path: &Path) -> Value {
    let bytes = fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_slice(&bytes).unwrap()
}

/// The files of a folder that end so.
fn files(folder: &Path, end: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let mut found: Vec<PathBuf> = paths
        .filter(|path| path.to_string_lossy().ends_with(end))
        .collect();
    found.sort();
    found
}

/// Whether a letter may be of a number.
fn is_of_number(letter: char) -> bool {
    letter.is_ascii_digit() || letter == '.' || letter == '-'
}

/// The last number of a text, with nothing of a number behind it, as it is written.
fn last_number(text: &str) -> &str {
    let end = text.rfind(|letter: char| letter.is_ascii_digit());
    let text = &text[..end.map_or(0, |end| end + 1)];
    let start = text.rfind(|letter| !is_of_number(letter));
    let start = start.map_or(0, |at| at + text[at..].chars().next().unwrap().len_utf8());
    &text[start..]
}

fn first_number(text: &str) -> &str {
    let end = text.find(|letter| !is_of_number(letter));
    text[..end.unwrap_or(text.len())].trim_end_matches(['.', '-'])
}

/// A value with as many decimals as a number is written with.
fn written_as(value: f64, number: &str) -> String {
    let decimals = number.split_once('.').map_or(0, |(_, after)| after.len());
    let text = format!("{value:.decimals$}");
    // Nothing is minus nothing.
    let is_zero = text.trim_matches(['-', '0', '.']).is_empty();
    if is_zero {
        text.trim_start_matches('-').to_owned()
    } else {
        text
    }
}

/// All means with their intervals that results hold.
fn means(results: &Value, found: &mut Vec<[f64; 2]>) {
    match results {
        Value::Object(fields) => {
            let number = |name| fields.get(name).and_then(Value::as_f64);
            if let (Some(mean), Some(half_width)) = (number("mean"), number("half_width")) {
                found.push([mean, half_width]);
            }
            fields.values().for_each(|value| means(value, found));
        }
        Value::Array(values) => values.iter().for_each(|value| means(value, found)),
        _ => {}
    }
}

fn is_among(means: &[[f64; 2]], mean: &str, half_width: &str) -> bool {
    let is_it = |[of_mean, of_half_width]: &[f64; 2], factor: f64| {
        written_as(of_mean * factor, mean) == mean
            && written_as(of_half_width * factor, half_width) == half_width
    };
    means
        .iter()
        .any(|pair| FACTORS.iter().any(|factor| is_it(pair, *factor)))
}

/// The means with their intervals that a text shows.
fn shown(text: &str) -> Vec<(&str, &str)> {
    let signs = text.match_indices(" ± ");
    signs
        .map(|(at, sign)| {
            (
                last_number(&text[..at]),
                first_number(&text[at + sign.len()..]),
            )
        })
        .collect()
}

#[test]
fn tables_are_those_of_the_results_beside_them() {
    let mut compared = 0;
    for document in files(&root().join("docs/results"), ".md") {
        let name = document.file_name().unwrap().to_string_lossy().into_owned();
        let text = fs::read_to_string(&document).unwrap();
        let Some((generated, _)) = text.split_once(NOTES) else {
            continue;
        };
        if WITHOUT_JSON.contains(&name.as_str()) {
            continue;
        }
        let stem = document.file_stem().unwrap().to_string_lossy();
        let mut known = Vec::new();
        for results in files(document.parent().unwrap(), ".json") {
            let of = results.file_name().unwrap().to_string_lossy();
            if of.starts_with(stem.as_ref()) {
                means(&json(&results), &mut known);
            }
        }
        for (mean, half_width) in shown(generated) {
            assert!(
                is_among(&known, mean, half_width),
                "{name} shows {mean} ± {half_width}, which no results beside it hold"
            );
            compared += 1;
        }
    }
    assert!(compared > 300, "{compared}");
}

/// A figure that a document quotes.
struct Quoted<'a> {
    number: &'a str,
    file: &'a str,
    pointer: &'a str,
    factor: f64,
}

/// The figures of a text that name their source.
fn quoted(text: &str) -> Vec<Quoted<'_>> {
    let mut quoted = Vec::new();
    for (at, sign) in text.match_indices("<!-- ") {
        let comment = &text[at + sign.len()..];
        let comment = &comment[..comment.find(" -->").unwrap_or(0)];
        let Some((file, rest)) = comment.split_once("#/") else {
            continue;
        };
        let (pointer, factor) = rest.split_once(" * ").unwrap_or((rest, "1"));
        quoted.push(Quoted {
            number: last_number(&text[..at]),
            file,
            pointer,
            factor: factor.parse().unwrap(),
        });
    }
    quoted
}

#[test]
fn quoted_figures_are_those_of_their_sources() {
    let root = root();
    let mut documents = files(&root.join("docs"), ".md");
    documents.extend(files(&root.join("docs/results"), ".md"));
    documents.push(root.join("README.md"));
    let mut compared = 0;
    for document in documents {
        let text = fs::read_to_string(&document).unwrap();
        for Quoted {
            number,
            file,
            pointer,
            factor,
        } in quoted(&text)
        {
            let source = json(&root.join(file));
            let value = source.pointer(&format!("/{pointer}"));
            let value = value.and_then(Value::as_f64);
            let place = format!("{}: {file}#/{pointer}", document.display());
            let value = value.unwrap_or_else(|| panic!("{place} is not there"));
            let expected = written_as(value * factor, number);
            assert_eq!(number, expected, "{place}");
            compared += 1;
        }
    }
    assert!(compared >= 10, "{compared}");
}

#[test]
fn a_figure_of_another_run_is_found() {
    let results = serde_json::json!({ "lines": [{ "mean": 0.01234, "half_width": 0.0005 }] });
    let mut known = Vec::new();
    means(&results, &mut known);
    let text = "| a | 12.3 ± 0.5 ms | -0.012 ± 0.001 |";
    assert_eq!(shown(text), [("12.3", "0.5"), ("-0.012", "0.001")]);
    assert!(is_among(&known, "12.3", "0.5"));
    assert!(!is_among(&known, "12.4", "0.5") && !is_among(&known, "-0.012", "0.001"));
    let text = "takes 16.9<!-- a.json#/b/0 * 1000 --> ms <!-- nothing -->";
    let quoted = quoted(text);
    assert_eq!(quoted.len(), 1);
    assert_eq!((quoted[0].number, quoted[0].file), ("16.9", "a.json"));
    assert_eq!((quoted[0].pointer, quoted[0].factor), ("b/0", 1e3));
}
