//! Result documents: a generated part, and notes by hand that a new run keeps.

use std::fmt::Debug;
use std::io::ErrorKind;
use std::path::Path;

use anyhow::Context;
use ppnpack_chart::{Bar, Bars, ChartError};
use serde::{Serialize, Serializer};

use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_cli::output::{print_json, print_line};
use ppnpack_files::write_whole;

use crate::origin::Origin;
use crate::page;

/// The page of an experiment, in its folder.
const PAGE: &str = "report.html";

/// Everything from this line on is written by hand.
const NOTES: &str = "<!-- Notes: what follows is kept when the experiment is run again. -->";

/// Writes the generated part of a Markdown document; keeps the notes of the one that is there.
pub(crate) fn write(path: &Path, generated: &str) -> Outcome {
    let existing = match std::fs::read_to_string(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
        // What cannot be read may have notes.
        read => {
            let read = read.with_context(|| format!("the notes in {}", path.display()));
            read.or_run()?
        }
    };
    let notes = existing.split_once(NOTES).map_or("\n", |(_, notes)| notes);
    let document = format!("{}\n\n{NOTES}{notes}", generated.trim_end());
    Ok(write_whole(path, document.as_bytes())?)
}

/// What an experiment came to, as its files say it.
pub(crate) struct Document<'a, R> {
    /// What its files are named by.
    pub(crate) name: &'a str,
    /// What its page says first.
    pub(crate) answer: Answer<'a>,
    pub(crate) results: &'a R,
    /// All options of the command, with those that were not given.
    pub(crate) asked: &'a dyn Debug,
    /// The names of what was measured, at any depth of the results: all else in them are settings.
    pub(crate) measured: &'a [&'a str],
    /// The document in Markdown.
    pub(crate) markdown: String,
}

/// What was asked, and what came out.
pub(crate) struct Answer<'a> {
    pub(crate) question: &'a str,
    /// What came out, in a sentence or two.
    pub(crate) text: String,
    /// The file beside the document that shows it, an SVG or a PNG.
    pub(crate) picture: String,
}

/// Results, with what made them.
#[derive(Serialize)]
pub(crate) struct Made<'a, R> {
    origin: Origin,
    #[serde(flatten)]
    results: &'a R,
}

impl<R: Serialize> Document<'_, R> {
    /// Writes the results as `<name>.json`, the document as `<name>.md` and its page as `report.html`; gives what is in the first.
    pub(crate) fn save(&self, folder: &Path) -> Outcome<Made<'_, R>> {
        let results = self.results;
        let origin = Origin::now()?;
        let markdown = format!("{}\n\n{}", self.markdown.trim_end(), origin.in_words());
        let page = page::page(self, &origin, folder)?;
        let made = Made { origin, results };
        let json = serde_json::to_vec_pretty(&made).or_run()?;
        write_whole(&folder.join(format!("{}.json", self.name)), &json)?;
        write(&folder.join(format!("{}.md", self.name)), &markdown)?;
        write_whole(&folder.join(PAGE), page.as_bytes())?;
        Ok(made)
    }

    /// Writes all of them, and prints one.
    pub(crate) fn publish(&self, folder: &Path, as_json: bool) -> Outcome {
        let made = self.save(folder)?;
        if as_json {
            return Ok(print_json(&made)?);
        }
        print_line(&self.markdown)?;
        let path = folder.join(format!("{}.md", self.name));
        let page = folder.join(PAGE);
        Ok(print_line(&format!(
            "Written to {}\nReport: {}",
            path.display(),
            page.display()
        ))?)
    }
}

/// Writes settings into results, with the version of this program.
pub(crate) fn with_version<T: Serialize, S: Serializer>(
    settings: &T,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Versioned<'a, T> {
        version: &'static str,
        #[serde(flatten)]
        settings: &'a T,
    }
    let version = env!("CARGO_PKG_VERSION");
    Versioned { version, settings }.serialize(serializer)
}

/// Writes a chart as `<name>.svg`.
pub(crate) fn figure(folder: &Path, name: &str, svg: Result<String, ChartError>) -> Outcome {
    let path = folder.join(format!("{name}.svg"));
    Ok(write_whole(&path, svg.or_run()?.as_bytes())?)
}

/// Writes bars, one for each name and value, as `<name>.svg`.
pub(crate) fn bars(
    folder: &Path,
    name: &str,
    [title, value_label]: [&str; 2],
    bars: impl IntoIterator<Item = (String, f64)>,
) -> Outcome {
    let bars = bars.into_iter();
    let chart = Bars {
        title: title.to_owned(),
        value_label: value_label.to_owned(),
        bars: bars.map(|(label, value)| Bar { label, value }).collect(),
    };
    let rows = u32::try_from(chart.bars.len()).unwrap_or(u32::MAX).min(100);
    figure(folder, name, chart.to_svg([760, 160 + 36 * rows]))
}

/// The name of an enum's variant, as files spell it.
pub(crate) fn name_of(variant: &impl serde::Serialize) -> String {
    match serde_json::to_value(variant) {
        Ok(serde_json::Value::String(name)) => name,
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_in_results_name_the_version() {
        #[derive(Serialize)]
        struct Results<'a> {
            #[serde(serialize_with = "with_version")]
            settings: &'a Settings,
        }
        #[derive(Serialize)]
        struct Settings {
            seed: u64,
        }
        let settings = &Settings { seed: 1 };
        let json = serde_json::to_value(Results { settings }).unwrap();
        let version = env!("CARGO_PKG_VERSION");
        let expected = serde_json::json!({ "settings": { "version": version, "seed": 1 } });
        assert_eq!(json, expected);
    }

    #[test]
    fn notes_survive_a_new_run() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.md");
        write(&path, "one").unwrap();
        let mut text = std::fs::read_to_string(&path).unwrap();
        text.push_str("by hand\n");
        std::fs::write(&path, text).unwrap();
        write(&path, "two").unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let is_kept = text.starts_with("two\n") && text.ends_with("by hand\n");
        assert!(is_kept, "{text}");
    }

    #[test]
    fn a_document_that_cannot_be_read_is_left_as_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.md");
        std::fs::write(&path, b"by hand \xff").unwrap();
        assert!(write(&path, "one").is_err());
        assert_eq!(std::fs::read(&path).unwrap(), b"by hand \xff");
    }
}
