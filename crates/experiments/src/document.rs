//! Result documents: a generated part, and notes by hand that a new run keeps.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use ppnpack_chart::ChartError;
use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_cli::output::{print_json, print_line};
use ppnpack_files::write_whole;
use serde::Serialize;

use crate::origin::Origin;

/// Everything from this line on is written by hand.
const NOTES: &str = "<!-- Notes: what follows is kept when the experiment is run again. -->";

/// Where results are written, and how they are printed.
#[derive(Debug, Args)]
pub(crate) struct OutOptions {
    /// Where the document, its figures as JSON and its pictures are written [default: out/NAME]
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

    /// Writes the results as `<name>.json` and the document as `<name>.md`, each with what made it, and prints one of them.
    pub(crate) fn publish(&self, name: &str, results: &impl Serialize, markdown: &str) -> Outcome {
        #[derive(Serialize)]
        struct Made<'a, R> {
            origin: &'a Origin,
            #[serde(flatten)]
            results: &'a R,
        }
        let folder = self.folder(name);
        let origin = &Origin::now()?;
        let made = Made { origin, results };
        let json = serde_json::to_vec_pretty(&made).or_run()?;
        write_whole(&folder.join(format!("{name}.json")), &json)?;
        let path = folder.join(format!("{name}.md"));
        let with_origin = format!("{}\n\n{}", markdown.trim_end(), origin.in_words());
        write(&path, &with_origin)?;
        if self.json {
            return Ok(print_json(&made)?);
        }
        print_line(markdown)?;
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

/// Writes a chart as `<name>.svg`.
pub(crate) fn figure(folder: &Path, name: &str, svg: Result<String, ChartError>) -> Outcome {
    let path = folder.join(format!("{name}.svg"));
    Ok(write_whole(&path, svg.or_run()?.as_bytes())?)
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
