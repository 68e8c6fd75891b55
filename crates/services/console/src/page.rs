//! The files of the page, all of them within the program.

pub(crate) struct File {
    pub(crate) name: &'static str,
    /// Its media type.
    pub(crate) kind: &'static str,
    pub(crate) content: &'static str,
}

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";

macro_rules! files {
    ($($name:literal: $kind:expr,)*) => {
        &[$(File {
            name: $name,
            kind: $kind,
            content: include_str!(concat!("../page/", $name)),
        },)*]
    };
}

const FILES: &[File] = files! {
    "index.html": HTML,
    "style.css": CSS,
    "above.js": SCRIPT,
    "buffer.js": SCRIPT,
    "charts.js": SCRIPT,
    "connection.js": SCRIPT,
    "contents.js": SCRIPT,
    "controls.js": SCRIPT,
    "decision.js": SCRIPT,
    "dialogs.js": SCRIPT,
    "dom.js": SCRIPT,
    "events.js": SCRIPT,
    "figures.js": SCRIPT,
    "format.js": SCRIPT,
    "gl.js": SCRIPT,
    "main.js": SCRIPT,
    "orbit.js": SCRIPT,
    "preferences.js": SCRIPT,
    "scene.js": SCRIPT,
    "services.js": SCRIPT,
    "shapes.js": SCRIPT,
    "stage.js": SCRIPT,
    "state.js": SCRIPT,
    "status.js": SCRIPT,
    "vectors.js": SCRIPT,
};

pub(crate) const INDEX: &str = "index.html";

pub(crate) fn file(name: &str) -> Option<&'static File> {
    FILES.iter().find(|file| file.name == name)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn every_file_of_the_page_is_within_the_program() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("page");
        let entries = std::fs::read_dir(folder).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.collect();
        names.sort_unstable();
        let mut known: Vec<&str> = FILES.iter().map(|file| file.name).collect();
        known.sort_unstable();
        assert_eq!(names, known);
    }

    #[test]
    fn nothing_is_fetched_from_elsewhere() {
        for file in FILES {
            for foreign in ["http://", "https://", "//cdn", "@import"] {
                let content = file.content.replace("http://www.w3.org/", "");
                assert!(!content.contains(foreign), "{} has {foreign}", file.name);
            }
        }
        assert!(file(INDEX).is_some() && file("../Cargo.toml").is_none());
    }
}
