//! Generates the code of the messages from `descriptors.binpb`, which a test compiles of the
//! schemas in `proto/`.
//!
//! The compiler of the schemas would cost each build as much again.

use std::error::Error;
use std::path::PathBuf;
use std::{env, fs};

use prost::Message;
use prost_types::FileDescriptorSet;

const DESCRIPTORS: &str = "descriptors.binpb";

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed={DESCRIPTORS}");
    let mut schema = FileDescriptorSet::decode(fs::read(DESCRIPTORS)?.as_slice())?;
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
        .compile_fds(schema.clone())?;
    // Comments are for the code's documentation alone.
    schema
        .file
        .iter_mut()
        .for_each(|file| file.source_code_info = None);
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("cargo sets no OUT_DIR")?);
    fs::write(out.join(DESCRIPTORS), schema.encode_to_vec())?;
    Ok(())
}
