//! Result documents: a generated part, and notes by hand that a new run keeps.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_cli::output::{print_json, print_line};
use ppnpack_files::write_whole;
use serde::Serialize;
use serde_json::{Map, Value};

use crate::origin::Origin;

/// Everything from this line on is written by hand.
const NOTES: &str = "<!-- Notes: what follows is kept when the experiment is run again. -->";

/// Where results are written, and how they are printed.
#[derive(Debug, Args)]
pub(crate) struct OutOptions {
    /// Where the document and its figures as JSON are written [default: out/NAME]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Print the results as JSON instead of tables
    #[arg(long)]
    json: bool,
}

impl OutOptions {
    /// The folder of an experiment's results.
    pub(crate) fn folder(&self, name: &str) -> PathBuf {
        self.out
            .clone()
            .unwrap_or_else(|| Path::new("out").join(name))
    }
}

/// A page of results: its text, and the figures beside it.
#[derive(Debug)]
pub(crate) struct Page {
    name: String,
    text: String,
    kept: Map<String, Value>,
}

impl Page {
    /// A page that begins so.
    pub(crate) fn new(name: &str, text: String) -> Self {
        Self {
            name: name.to_owned(),
            text,
            kept: Map::new(),
        }
    }

    /// Adds to the text.
    pub(crate) fn say(&mut self, text: &str) {
        self.text += text;
    }

    /// Keeps something among the figures.
    pub(crate) fn keep(&mut self, key: &str, value: impl Serialize) {
        let value = serde_json::to_value(value).unwrap_or_default();
        self.kept.insert(key.to_owned(), value);
    }

    /// Writes the figures as `<name>.json` and the text as `<name>.md`, each with what made it, and prints one of them.
    pub(crate) fn publish(mut self, out: &OutOptions) -> Outcome {
        let folder = out.folder(&self.name);
        let origin = Origin::now()?;
        self.keep("origin", &origin);
        let json = serde_json::to_vec_pretty(&self.kept).or_run()?;
        write_whole(&folder.join(format!("{}.json", self.name)), &json)?;
        let path = folder.join(format!("{}.md", self.name));
        let with_origin = format!("{}\n\n{}", self.text.trim_end(), origin.in_words());
        write(&path, &with_origin)?;
        if out.json {
            return Ok(print_json(&self.kept)?);
        }
        print_line(&self.text)?;
        Ok(print_line(&format!("Written to {}", path.display()))?)
    }
}

/// Writes the generated part of a Markdown document; keeps the notes of the one that is there.
fn write(path: &Path, generated: &str) -> Outcome {
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

/// The name of an enum's variant, as files spell it.
pub(crate) fn name_of(variant: &impl Serialize) -> String {
    match serde_json::to_value(variant) {
        Ok(serde_json::Value::String(name)) => name,
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
