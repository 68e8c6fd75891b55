//! Files that are not what they say: an error, never a panic.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use crate::support::{content, settings, write};
use ppnpack_dataset::{Dataset, DatasetError, SETTINGS_FILE, Settings, Split};
use proptest::prelude::*;
use serde_json::{Value, json};
use tempfile::{TempDir, tempdir};

const ITEMS: &str = "items.safetensors.zst";
const SEQUENCE: &str = "sequence-00000.safetensors.zst";

/// A good dataset of one sequence.
static GOOD: LazyLock<TempDir> = LazyLock::new(|| {
    let folder = tempdir().unwrap();
    let settings = Settings {
        sequences: 1,
        ..settings(true)
    };
    write(folder.path(), &settings);
    folder
});

/// A copy of the good dataset in which one file is replaced.
fn replaced(file: &str, by: &[u8]) -> TempDir {
    let folder = tempdir().unwrap();
    for (name, content) in content(GOOD.path()) {
        fs::write(folder.path().join(name), content).unwrap();
    }
    fs::write(folder.path().join(file), by).unwrap();
    folder
}

fn load(folder: &Path) -> Result<usize, DatasetError> {
    let dataset = Dataset::open(folder)?;
    Ok(dataset.load(Split::Train, true, &|_, _| {})?.len())
}

fn unpacked(file: &str) -> Vec<u8> {
    zstd::decode_all(&fs::read(GOOD.path().join(file)).unwrap()[..]).unwrap()
}

fn packed(content: &[u8]) -> Vec<u8> {
    zstd::encode_all(content, 1).unwrap()
}

#[test]
fn other_versions_are_named() {
    let settings = fs::read(GOOD.path().join(SETTINGS_FILE)).unwrap();
    let mut settings: Value = serde_json::from_slice(&settings).unwrap();
    settings["format_version"] = json!(9);
    settings["seed"] = json!("of a kind that this version does not know");
    let error = load(replaced(SETTINGS_FILE, settings.to_string().as_bytes()).path()).unwrap_err();
    assert!(matches!(error, DatasetError::Version(_, 9)), "{error}");
    assert!(error.to_string().contains("version 9"), "{error}");
}

#[test]
fn settings_that_contradict_themselves_are_refused() {
    let settings = fs::read(GOOD.path().join(SETTINGS_FILE)).unwrap();
    for (pointer, value) in [
        ("/sequences", json!(0)),
        ("/sequences", json!(u32::MAX)),
        ("/length", json!(0)),
        ("/objects", json!(0)),
        ("/expert/buffer", json!(0)),
        ("/grid/nx", json!(100_000)),
        ("/grid/resolution/cell_m", json!(0.0)),
        ("/grid/resolution/yaws", json!([])),
        ("/grid/container/x_m", json!(1e300)),
    ] {
        let mut settings: Value = serde_json::from_slice(&settings).unwrap();
        *settings.pointer_mut(pointer).unwrap() = value;
        let folder = replaced(SETTINGS_FILE, settings.to_string().as_bytes());
        let error = load(folder.path()).unwrap_err();
        assert!(
            matches!(error, DatasetError::Damaged { .. }),
            "{pointer}: {error}"
        );
    }
    for text in ["", "{", "[]", "null", "{}"] {
        assert!(load(replaced(SETTINGS_FILE, text.as_bytes()).path()).is_err());
    }
}

#[test]
fn missing_files_are_named() {
    let error = load(Path::new("/nowhere")).unwrap_err().to_string();
    assert!(
        error.contains("/nowhere/settings.json cannot be read"),
        "{error}"
    );
    let folder = replaced(SEQUENCE, b"");
    fs::remove_file(folder.path().join(SEQUENCE)).unwrap();
    let error = load(folder.path()).unwrap_err().to_string();
    assert!(error.contains(SEQUENCE), "{error}");
}

#[test]
fn what_expands_to_more_than_it_may_is_refused() {
    let zeros = packed(&vec![0; 1 << 26]);
    let error = load(replaced(SEQUENCE, &zeros).path()).unwrap_err();
    assert!(error.to_string().contains("more than"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Whatever is inside, reading ends with records or names the file that is wrong.
    #[test]
    fn no_content_makes_the_reader_panic(
        at in any::<prop::sample::Index>(),
        with in prop::collection::vec(any::<u8>(), 1..8),
        cut in any::<bool>(),
        of_items in any::<bool>(),
    ) {
        let file = if of_items { ITEMS } else { SEQUENCE };
        let mut content = unpacked(file);
        let at = at.index(content.len());
        if cut {
            content.truncate(at);
        }
        content.splice(at..(at + with.len()).min(content.len()), with);
        let folder = replaced(file, &packed(&content));
        let expected = folder.path().join(file);
        if let Err(error) = load(folder.path()) {
            let is_told = matches!(&error, DatasetError::Damaged(path, _) if *path == expected);
            // Other items are other placements, which the records then do not fit.
            prop_assert!(is_told || of_items, "{error}");
        }
    }
}
