//! Makes the types of `ros/ppnpack_msgs` as hiroz reads its interface files.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use hiroz_codegen::{GeneratorConfig, MessageGenerator, discover_bundled_packages};

fn main() -> anyhow::Result<()> {
    let package = Path::new("../../ros/ppnpack_msgs");
    println!("cargo:rerun-if-changed={}", package.display());
    let standard = discover_bundled_packages(false)?;
    let standard: Vec<&Path> = standard.iter().map(PathBuf::as_path).collect();
    let generator = MessageGenerator::new(GeneratorConfig {
        generate_cdr: true,
        generate_protobuf: false,
        generate_type_info: true,
        is_humble: false,
        output_dir: PathBuf::from(std::env::var("OUT_DIR")?),
        external_crate: Some("hiroz_msgs".to_owned()),
        local_packages: HashSet::from(["ppnpack_msgs".to_owned()]),
        json_out: None,
    });
    generator.generate_from_msg_files_with_deps(&[package], &standard)
}
