//! Result documents: a generated part, and notes by hand that a new run keeps.

use std::path::Path;

use ppnpack_chart::ChartError;
use serde::{Serialize, Serializer};

use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_cli::output::{print_json, print_line};
use ppnpack_files::write_whole;

/// Everything from this line on is written by hand.
const NOTES: &str = "<!-- Notes: what follows is kept when the experiment is run again. -->";

/// Writes the generated part of a Markdown document; keeps the notes of the one that is there.
pub(crate) fn write(path: &Path, generated: &str) -> Outcome {
    let existing = std::fs::read_to_string(path).unwrap_or_default();
    let notes = existing.split_once(NOTES).map_or("\n", |(_, notes)| notes);
    let document = format!("{}\n\n{NOTES}{notes}", generated.trim_end());
    Ok(write_whole(path, document.as_bytes())?)
}

/// Writes an experiment's results as `<name>.json` and its document as `<name>.md`.
pub(crate) fn save(folder: &Path, name: &str, results: &impl Serialize, markdown: &str) -> Outcome {
    let json = serde_json::to_vec_pretty(results).or_run()?;
    write_whole(&folder.join(format!("{name}.json")), &json)?;
    write(&folder.join(format!("{name}.md")), markdown)
}

/// Writes both, and prints one of the two.
pub(crate) fn publish(
    folder: &Path,
    name: &str,
    results: &impl Serialize,
    markdown: &str,
    as_json: bool,
) -> Outcome {
    save(folder, name, results, markdown)?;
    if as_json {
        print_json(results)?;
    } else {
        print_line(markdown)?;
        let path = folder.join(format!("{name}.md"));
        print_line(&format!("Written to {}", path.display()))?;
    }
    Ok(())
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

/// The name of an enum's variant, as files spell it.
pub(crate) fn name_of(variant: &impl serde::Serialize) -> String {
    match serde_json::to_value(variant) {
        Ok(serde_json::Value::String(name)) => name,
        _ => String::new(),
    }
}

/// The processor that figures were measured on.
pub(crate) fn machine() -> String {
    let cpus = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let mut lines = cpus.lines();
    let model = lines.find_map(|line| line.strip_prefix("model name")?.split(':').nth(1));
    let model = model.map_or("unknown processor", str::trim);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    format!("{model}, {cores} cores")
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
}
