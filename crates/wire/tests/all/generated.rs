//! `descriptors.binpb` is what the schemas in `proto/` compile to, with their comments.
//! `PPNPACK_RECORD=1` writes it anew.
//!
//! It is kept with the sources because the compiler of the schemas takes longer to build than all
//! of this crate.

use std::path::{Path, PathBuf};

use prost::Message;

#[test]
fn the_descriptors_are_those_of_the_schemas() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (root, kept) = (
        package.join("../../proto"),
        package.join("descriptors.binpb"),
    );
    let folder = std::fs::read_dir(root.join("ppnpack/v1")).unwrap();
    let mut files: Vec<PathBuf> = folder.map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|of| of == "proto"));
    files.sort();
    let fresh = protox::compile(files, [root]).unwrap().encode_to_vec();
    if std::env::var_os("PPNPACK_RECORD").is_some() {
        return std::fs::write(kept, fresh).unwrap();
    }
    assert!(
        std::fs::read(kept).unwrap() == fresh,
        "descriptors.binpb is not current: run this test with PPNPACK_RECORD=1"
    );
}
