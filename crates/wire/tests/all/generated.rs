//! `generated/` is what the schemas in `proto/` compile to. `PPNPACK_RECORD=1` writes it anew.
//!
//! It is kept with the sources because the compiler of the schemas takes longer to build than all of this crate.

use std::path::{Path, PathBuf};

use prost::Message;

const CODE: &str = "ppnpack.v1.rs";
const DESCRIPTORS: &str = "descriptors.binpb";

fn schemas(root: &Path) -> Vec<PathBuf> {
    let folder = std::fs::read_dir(root.join("ppnpack/v1")).unwrap();
    let mut files: Vec<PathBuf> = folder.map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| {
        file.extension()
            .is_some_and(|extension| extension == "proto")
    });
    files.sort();
    files
}

/// Compiles the schemas into a folder, without a `protoc`.
fn compile(out: &Path) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../proto");
    let descriptors = protox::compile(schemas(&root), [&root]).unwrap();
    // Comments are for the code's documentation alone.
    let mut bare = descriptors.clone();
    bare.file
        .iter_mut()
        .for_each(|file| file.source_code_info = None);
    std::fs::write(out.join(DESCRIPTORS), bare.encode_to_vec()).unwrap();
    prost_build::Config::new()
        .enable_type_names()
        // Most cells have no arm: what carries a cycle stays small without one.
        .boxed(".ppnpack.v1.Decision.cycle")
        .boxed(".ppnpack.v1.PlaceRequest.cycle")
        .boxed(".ppnpack.v1.Decision.load")
        // Sessions have many items, and few of these.
        .boxed(".ppnpack.v1.SessionItem.load")
        .boxed(".ppnpack.v1.SessionItem.order_line")
        .boxed(".ppnpack.v1.SessionItem.waits_at")
        .out_dir(out)
        .compile_fds(descriptors)
        .unwrap();
}

#[test]
fn the_generated_code_is_that_of_the_schemas() {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("generated");
    if std::env::var_os("PPNPACK_RECORD").is_some() {
        return compile(&kept);
    }
    let fresh = tempfile::tempdir().unwrap();
    compile(fresh.path());
    for name in [CODE, DESCRIPTORS] {
        let read = |folder: &Path| std::fs::read(folder.join(name)).unwrap();
        assert!(
            read(&kept) == read(fresh.path()),
            "generated/{name} is not current: run this test with PPNPACK_RECORD=1"
        );
    }
}
