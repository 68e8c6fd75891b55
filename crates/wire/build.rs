//! Compiles the schemas in `proto/`, without a `protoc`.

use std::error::Error;
use std::path::{Path, PathBuf};

use prost::Message;

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new("../../proto");
    println!("cargo:rerun-if-changed={}", root.display());
    let mut files: Vec<PathBuf> = std::fs::read_dir(root.join("ppnpack/v1"))?
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<_, std::io::Error>>()?;
    files.retain(|file| {
        file.extension()
            .is_some_and(|extension| extension == "proto")
    });
    files.sort();
    let descriptors = protox::compile(&files, [root])?;
    let out = PathBuf::from(std::env::var_os("OUT_DIR").ok_or("cargo names no OUT_DIR")?);
    // Comments are for the code's documentation alone.
    let mut bare = descriptors.clone();
    bare.file
        .iter_mut()
        .for_each(|file| file.source_code_info = None);
    std::fs::write(out.join("descriptors.binpb"), bare.encode_to_vec())?;
    prost_build::Config::new()
        .enable_type_names()
        // Most cells have no arm: what carries a cycle stays small without one.
        .boxed(".ppnpack.v1.Decision.cycle")
        .boxed(".ppnpack.v1.PlaceRequest.cycle")
        .compile_fds(descriptors)?;
    Ok(())
}
