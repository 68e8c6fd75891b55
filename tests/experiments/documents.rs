//! The figures in the documents are those of the files that they come from.
//!
//! Each mean with its interval (`a ± b`) in the generated part of `docs/results/NAME.md` has to be
//! in a `NAME*.json` beside it. A figure that is quoted elsewhere names its source in a comment
//! that readers do not see:
//! `16.9<!-- docs/results/pareto.json#/grids/2/lines/0/decision_s/mean * 1000 --> ms`.
//!
//! What a page links to is there: files, and the headings in them. Every page is in the book.

use std::fs;
use std::path::{Path, PathBuf};

use ppnpack_service::metrics::Metric;
use serde_json::Value;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// The mark behind which a page is written by hand.
const NOTES: &str = "<!-- Notes:";

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
    let found = paths.filter(|path| path.to_string_lossy().ends_with(end));
    let mut found: Vec<PathBuf> = found.collect();
    found.sort();
    found
}

/// All pages.
fn pages() -> Vec<PathBuf> {
    let root = root();
    let mut pages = vec![root.join("README.md")];
    for folder in ["docs", "docs/guides", "docs/results"] {
        pages.extend(files(&root.join(folder), ".md"));
    }
    pages
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
    match text.trim_matches(['-', '0', '.']) {
        "" => text.trim_start_matches('-').to_owned(),
        _ => text,
    }
}

/// All means with their intervals that results hold. Shares of candidates have a standard error by
/// sequence.
fn means(results: &Value, found: &mut Vec<[f64; 2]>) {
    match results {
        Value::Object(fields) => {
            let number = |name| fields.get(name).and_then(Value::as_f64);
            if let (Some(mean), Some(half_width)) = (number("mean"), number("half_width")) {
                found.push([mean, half_width]);
            }
            if let Some(sequences) = number("sequences")
                && let Ok(student) = StudentsT::new(0.0, 1.0, sequences - 1.0)
            {
                let shares = fields.values().filter_map(Value::as_array).flatten();
                found.extend(shares.filter_map(|of| {
                    let error = of.get("standard_error")?.as_f64()?;
                    let half_width = student.inverse_cdf(0.975) * error;
                    Some([of.get("share")?.as_f64()?, half_width])
                }));
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
    let mut means = means.iter();
    means.any(|pair| FACTORS.iter().any(|factor| is_it(pair, *factor)))
}

/// The means with their intervals that a text shows.
fn shown(text: &str) -> Vec<(&str, &str)> {
    let split = text.match_indices(" ± ").map(|(at, sign)| {
        let after = &text[at + sign.len()..];
        (last_number(&text[..at]), first_number(after))
    });
    split.collect()
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
        let stem = document.file_stem().unwrap().to_string_lossy();
        let mut known = Vec::new();
        for results in files(document.parent().unwrap(), ".json") {
            let of = results.file_name().unwrap().to_string_lossy();
            if of.starts_with(stem.as_ref()) {
                means(&json(&results), &mut known);
            }
        }
        for (mean, half_width) in shown(generated) {
            let shown = format!("{name} shows {mean} ± {half_width}");
            assert!(is_among(&known, mean, half_width), "{shown}: no results do");
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
    let mut compared = 0;
    for document in pages() {
        let text = fs::read_to_string(&document).unwrap();
        for figure in quoted(&text) {
            let Quoted { file, pointer, .. } = figure;
            let source = json(&root.join(file));
            let value = source.pointer(&format!("/{pointer}"));
            let value = value.and_then(Value::as_f64);
            let place = format!("{}: {file}#/{pointer}", document.display());
            let value = value.unwrap_or_else(|| panic!("{place} is not there"));
            let expected = written_as(value * figure.factor, figure.number);
            assert_eq!(figure.number, expected, "{place}");
            compared += 1;
        }
    }
    assert!(compared >= 50, "{compared}");
}

/// A page's text, without what is between fences and without code in its lines.
fn prose(text: &str) -> String {
    let mut is_code = false;
    let lines = text.lines().filter(|line| {
        let is_fence = line.starts_with("```");
        is_code ^= is_fence;
        !is_code && !is_fence
    });
    let lines: Vec<&str> = lines.collect();
    // Every other part is between backticks; code does not go over paragraphs.
    let paragraphs = lines.split(|line| line.is_empty());
    let plain = paragraphs.map(|paragraph| {
        let paragraph = paragraph.join("\n");
        let parts: Vec<&str> = paragraph.split('`').step_by(2).collect();
        parts.join("`")
    });
    plain.collect::<Vec<_>>().join("\n\n")
}

/// The links of a text, those of pictures too.
fn links(text: &str) -> Vec<String> {
    let text = prose(text);
    let starts = text.match_indices("](");
    let links = starts.map(|(at, sign)| {
        let link = &text[at + sign.len()..];
        link[..link.find(')').unwrap()].to_owned()
    });
    links.filter(|link| !link.contains("://")).collect()
}

/// The names of a page's headings in links, as code hosts and the book make them.
fn anchors(text: &str) -> Vec<String> {
    let mut is_code = false;
    let mut names: Vec<String> = Vec::new();
    let mut anchors = Vec::new();
    for line in text.lines() {
        is_code ^= line.starts_with("```");
        let heading = line.trim_start_matches('#');
        if is_code || heading.len() == line.len() || !heading.starts_with(' ') {
            continue;
        }
        let letters = heading.trim().chars().flat_map(char::to_lowercase);
        let name: String = letters
            .filter(|letter| letter.is_alphanumeric() || matches!(letter, ' ' | '-' | '_'))
            .map(|letter| if letter == ' ' { '-' } else { letter })
            .collect();
        // A later heading of the same name has a number.
        let before = names.iter().filter(|known| **known == name).count();
        anchors.push(match before {
            0 => name.clone(),
            count => format!("{name}-{count}"),
        });
        names.push(name);
    }
    anchors
}

#[test]
fn what_pages_link_to_is_there() {
    let mut followed = 0;
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        for link in links(&text) {
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target = match file {
                "" => page.clone(),
                file => page.parent().unwrap().join(file),
            };
            let place = format!("{}: {link}", page.display());
            assert!(target.exists(), "{place}: there is no such file");
            if !anchor.is_empty() {
                let text = fs::read_to_string(&target).unwrap();
                let known = anchors(&text);
                let is_known = known.iter().any(|name| name == anchor);
                assert!(is_known, "{place}: of {known:?}");
            }
            followed += 1;
        }
    }
    assert!(followed > 300, "{followed}");
}

#[test]
fn every_page_is_in_the_book() {
    let docs = root().join("docs");
    let summary = fs::read_to_string(docs.join("SUMMARY.md")).unwrap();
    let listed = links(&summary);
    for page in pages() {
        let Ok(name) = page.strip_prefix(&docs) else {
            continue;
        };
        let name = name.to_string_lossy();
        let is_listed = name == "SUMMARY.md" || listed.iter().any(|link| *link == name);
        assert!(is_listed, "docs/SUMMARY.md does not list {name}");
    }
}

/// The guides that a page links to, in the order of their first mention.
fn guides_of(page: &Path) -> Vec<String> {
    let mut guides = Vec::new();
    for link in links(&fs::read_to_string(page).unwrap()) {
        let guide = link.rsplit_once("guides/").map(|(_, guide)| guide);
        if let Some(guide) = guide.map(str::to_owned)
            && !guides.contains(&guide)
        {
            guides.push(guide);
        }
    }
    guides
}

#[test]
fn guides_are_in_one_order_everywhere() {
    let root = root();
    let order = guides_of(&root.join("docs/SUMMARY.md"));
    assert_eq!(order.len(), files(&root.join("docs/guides"), ".md").len());
    for page in ["README.md", "docs/README.md"] {
        assert_eq!(guides_of(&root.join(page)), order, "{page}");
    }
}

#[test]
fn every_reason_check_and_metric_is_explained() {
    let root = root();
    let guide = fs::read_to_string(root.join("docs/guides/figures.md")).unwrap();
    let metrics = Metric::ALL.iter();
    let mut names: Vec<String> = metrics.map(|metric| metric.name().to_owned()).collect();
    for schema in ["planner.proto", "placement.proto"] {
        let text = fs::read_to_string(root.join("proto/ppnpack/v1").join(schema)).unwrap();
        let lines = text.lines();
        let values = lines.filter_map(|line| line.trim().split_once(" = "));
        let values = values.map(|(name, _)| name.to_owned()).filter(|name| {
            (name.starts_with("REASON_") || name.starts_with("CHECK_"))
                && !name.ends_with("_UNSPECIFIED")
        });
        names.extend(values);
    }
    assert!(names.len() > 30, "{names:?}");
    for name in names {
        let is_explained = guide.contains(&format!("`{name}`"));
        assert!(is_explained, "docs/guides/figures.md lacks {name}");
    }
}

#[test]
fn links_and_headings_are_read() {
    let text = "# A `b` of c\n[d](e.md#f), ![g](h.png)\n`[i](j)`\n\n```\n# [k](l)\n```\n## Twice\n## Twice\n";
    assert_eq!(links(text), ["e.md#f", "h.png"]);
    assert_eq!(anchors(text), ["a-b-of-c", "twice", "twice-1"]);
    assert_eq!(links("[a](https://b.c)"), Vec::<String>::new());
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
