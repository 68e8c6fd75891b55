//! Files that are not what they say: an error, never a panic.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    missing_docs,
    reason = "a panic in a test is a failing test"
)]

mod support;

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use ppnpack_dataset::{Dataset, DatasetError, MANIFEST_FILE, Split};
use proptest::prelude::*;
use serde_json::{Value, json};
use support::{settings, write};
use tempfile::{TempDir, tempdir};

/// A good dataset of one sequence.
static GOOD: LazyLock<TempDir> = LazyLock::new(|| {
    let folder = tempdir().unwrap();
    write(folder.path(), &settings(true), 1);
    folder
});

/// A copy of the good dataset in which one file is replaced, its digest in the manifest and its own checksum with it,
/// so that what is inside is read.
fn replaced(file: &str, content: &[u8]) -> TempDir {
    let folder = tempdir().unwrap();
    for name in [MANIFEST_FILE, "items.bin", "shard-00000.bin"] {
        fs::copy(GOOD.path().join(name), folder.path().join(name)).unwrap();
    }
    fs::write(folder.path().join(file), content).unwrap();
    if file != MANIFEST_FILE {
        name_digests(folder.path());
    }
    folder
}

fn name_digests(folder: &Path) {
    let mut manifest = manifest(folder);
    let mut name = |pointer: &str, file: &str| {
        let content = fs::read(folder.join(file)).unwrap();
        let digest = blake3::hash(&content).to_hex().to_string();
        let entry = manifest.pointer_mut(pointer).unwrap();
        entry["bytes"] = json!(content.len());
        entry["blake3"] = json!(digest);
        digest
    };
    let items = name("/items", "items.bin");
    let shard = name("/shards/0", "shard-00000.bin");
    // The settings' digest is in the shard's header.
    let header = fs::read(GOOD.path().join("shard-00000.bin")).unwrap();
    let parts = [&header[12..44], items.as_bytes(), shard.as_bytes()].concat();
    manifest["hash"] = json!(blake3::hash(&parts).to_hex().to_string());
    fs::write(folder.join(MANIFEST_FILE), manifest.to_string()).unwrap();
}

fn manifest(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join(MANIFEST_FILE)).unwrap()).unwrap()
}

fn load(folder: &Path) -> Result<usize, DatasetError> {
    let dataset = Dataset::open(folder)?;
    Ok(dataset.load(Split::Train, true, &|_, _| {})?.len())
}

/// Reads a dataset to its end, which is either records or what is wrong with the file.
fn ends_well(folder: &Path) {
    let is_told = |error| {
        matches!(
            error,
            DatasetError::Damaged { .. } | DatasetError::Version { .. }
        )
    };
    assert!(load(folder).map_or_else(is_told, |_| true));
}

/// Brings the checksum in a shard's header up to date.
fn checksummed(mut shard: Vec<u8>) -> Vec<u8> {
    if shard.len() >= 76 {
        let digest = blake3::hash(&shard[76..]);
        shard[44..76].copy_from_slice(digest.as_bytes());
    }
    shard
}

#[test]
fn replacing_a_file_by_itself_changes_nothing() {
    for file in ["items.bin", "shard-00000.bin"] {
        let content = fs::read(GOOD.path().join(file)).unwrap();
        assert!(load(replaced(file, &content).path()).unwrap() > 0);
    }
}

#[test]
fn other_versions_are_named() {
    for (file, at) in [("items.bin", 8), ("shard-00000.bin", 8)] {
        let mut content = fs::read(GOOD.path().join(file)).unwrap();
        content[at] = 9;
        let error = load(replaced(file, &content).path()).unwrap_err();
        assert!(
            matches!(error, DatasetError::Version { found: 9, .. }),
            "{error}"
        );
    }
    let mut manifest = manifest(GOOD.path());
    manifest["settings"]["format_version"] = json!(9);
    manifest["settings"]["seed"] = json!("of a kind that this version does not know");
    let error = load(replaced(MANIFEST_FILE, manifest.to_string().as_bytes()).path()).unwrap_err();
    assert!(
        matches!(error, DatasetError::Version { found: 9, .. }),
        "{error}"
    );
    assert!(error.to_string().contains("version 9"), "{error}");
}

#[test]
fn manifests_that_contradict_themselves_are_refused() {
    for (pointer, value) in [
        ("/hash", json!("00")),
        ("/steps", json!(1)),
        ("/sequences", json!(2)),
        ("/sequences", json!(u32::MAX)),
        ("/shards/0/file", json!("../../etc/passwd")),
        ("/items/file", json!("/etc/passwd")),
        ("/shards/0/first_sequence", json!(u32::MAX)),
        ("/shards/0/sequences", json!(u32::MAX)),
        ("/shards/0/steps", json!(u64::MAX)),
        ("/shards", json!([])),
        ("/settings/seed", json!(5)),
        ("/settings/length", json!(0)),
        ("/settings/sequences_per_shard", json!(0)),
        ("/settings/grid/nx", json!(100_000)),
        ("/settings/grid/resolution/cell_m", json!(0.0)),
        ("/settings/grid/resolution/yaws", json!([])),
        ("/settings/grid/container/x_m", json!(1e300)),
    ] {
        let mut manifest = manifest(GOOD.path());
        *manifest.pointer_mut(pointer).unwrap() = value;
        let folder = replaced(MANIFEST_FILE, manifest.to_string().as_bytes());
        let error = load(folder.path()).unwrap_err();
        assert!(
            matches!(error, DatasetError::Damaged { .. }),
            "{pointer}: {error}"
        );
    }
    for text in ["", "{", "[]", "null", "{}"] {
        assert!(load(replaced(MANIFEST_FILE, text.as_bytes()).path()).is_err());
    }
}

#[test]
fn missing_files_are_named() {
    let error = load(Path::new("/nowhere")).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("/nowhere/manifest.json cannot be read"),
        "{error}"
    );
}

#[test]
fn sizes_that_promise_too_much_are_refused() {
    let good = fs::read(GOOD.path().join("shard-00000.bin")).unwrap();
    // The numbers of a shard after its checksum: first, count, then the sizes of the first sequence.
    for at in [76, 80, 84, 92, 100] {
        let mut shard = good.clone();
        shard[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(
            load(replaced("shard-00000.bin", &checksummed(shard)).path()).is_err(),
            "at {at}"
        );
    }
    let mut items = fs::read(GOOD.path().join("items.bin")).unwrap();
    items[12..20].copy_from_slice(&u64::MAX.to_le_bytes());
    assert!(load(replaced("items.bin", &items).path()).is_err());
}

/// A shard whose records are replaced by others, compressed; `size` is what it says of them.
fn with_records(records: &[u8], size: u64) -> Vec<u8> {
    let shard = fs::read(GOOD.path().join("shard-00000.bin")).unwrap();
    let packed = packed_records(&shard).len();
    let again = zstd::encode_all(records, 1).unwrap();
    let mut changed = shard[..84].to_vec();
    changed.extend(size.to_le_bytes());
    changed.extend((again.len() as u64).to_le_bytes());
    changed.extend(&shard[100..108]);
    changed.extend(again);
    changed.extend(&shard[108 + packed..]);
    checksummed(changed)
}

/// The compressed records of a shard of one sequence.
fn packed_records(shard: &[u8]) -> &[u8] {
    let size = u64::from_le_bytes(shard[92..100].try_into().unwrap());
    &shard[108..108 + size as usize]
}

#[test]
fn records_that_expand_to_more_than_their_size_are_refused() {
    let shard = with_records(&vec![0; 1 << 26], 1000);
    let error = load(replaced("shard-00000.bin", &shard).path()).unwrap_err();
    assert!(error.to_string().contains("the size it names"), "{error}");
    let shard = with_records(&vec![0; 1 << 26], 1 << 26);
    let error = load(replaced("shard-00000.bin", &shard).path()).unwrap_err();
    assert!(
        error.to_string().contains("larger than they can be"),
        "{error}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Whatever is inside, reading ends with records or an error.
    #[test]
    fn no_shard_makes_the_reader_panic(
        at in 76_usize..5000,
        with in prop::collection::vec(any::<u8>(), 1..8),
        cut in any::<bool>(),
    ) {
        let mut shard = fs::read(GOOD.path().join("shard-00000.bin")).unwrap();
        let at = at % shard.len();
        if cut {
            shard.truncate(at);
        }
        shard.splice(at..(at + with.len()).min(shard.len()), with);
        ends_well(replaced("shard-00000.bin", &checksummed(shard)).path());
    }

    /// The same of what is compressed: records that can be decoded are checked.
    #[test]
    fn no_record_makes_the_reader_panic(
        at in any::<prop::sample::Index>(),
        with in prop::collection::vec(any::<u8>(), 1..8),
    ) {
        let shard = fs::read(GOOD.path().join("shard-00000.bin")).unwrap();
        let mut records = zstd::decode_all(packed_records(&shard)).unwrap();
        let at = at.index(records.len());
        records.splice(at..(at + with.len()).min(records.len()), with);
        let damaged = with_records(&records, records.len() as u64);
        ends_well(replaced("shard-00000.bin", &damaged).path());
    }

    #[test]
    fn no_items_make_the_reader_panic(
        at in any::<prop::sample::Index>(),
        with in prop::collection::vec(any::<u8>(), 1..8),
    ) {
        let items = fs::read(GOOD.path().join("items.bin")).unwrap();
        let mut stored = zstd::decode_all(&items[20..]).unwrap();
        let at = at.index(stored.len());
        stored.splice(at..(at + with.len()).min(stored.len()), with);
        let mut damaged = items[..12].to_vec();
        damaged.extend((stored.len() as u64).to_le_bytes());
        damaged.extend(zstd::encode_all(&stored[..], 1).unwrap());
        ends_well(replaced("items.bin", &damaged).path());
    }
}
