//! A container by its size, or by a file where it is no box.

use ppnpack_packing::kernel::grid::ContainerSize;
use serde::Deserialize;

use super::file;
use crate::quantity::{parse_angle, parse_distance, parse_size};

/// The content of a container's file, in the way that the options write lengths.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ContainerFile {
    /// Inner lengths at the rim, and the height from the floor.
    size: String,
    /// Angle by which each wall leans outwards.
    draft: Option<String>,
    /// Radius of the vertical edges.
    corner_radius: Option<String>,
}

/// Parses three inner lengths, such as `32x32x30cm`, or reads the TOML file of this name.
pub(crate) fn parse_container(text: &str) -> Result<ContainerSize, String> {
    if !text.trim().ends_with(".toml") {
        return parse_size(text);
    }
    let in_file = |error: String| format!("{text} is no container: {error}");
    let file: ContainerFile = file::settings(text.trim()).map_err(in_file)?;
    file.container().map_err(in_file)
}

impl ContainerFile {
    fn container(&self) -> Result<ContainerSize, String> {
        let named = |name: &'static str| move |error: String| format!("{name}: {error}");
        let angle = self.draft.as_deref().map(parse_angle).transpose();
        let radius = self
            .corner_radius
            .as_deref()
            .map(parse_distance)
            .transpose();
        let container = ContainerSize {
            draft_rad: angle.map_err(named("draft"))?.unwrap_or_default(),
            corner_radius_m: radius.map_err(named("corner_radius"))?.unwrap_or_default(),
            ..parse_size(&self.size).map_err(named("size"))?
        };
        let shape = container.validate_shape();
        shape.map_err(|error| error.to_string())?;
        Ok(container)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(content: &str) -> Result<ContainerSize, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tote.toml");
        std::fs::write(&path, content).unwrap();
        parse_container(path.to_str().unwrap())
    }

    #[test]
    fn a_file_has_the_size_and_how_the_walls_stand() {
        let tote = "size = \"40x30x25cm\"\ndraft = \"3deg\"\ncorner_radius = \"3cm\"\n";
        let expected = ContainerSize {
            draft_rad: 3.0_f64.to_radians(),
            corner_radius_m: 0.03,
            ..ContainerSize::cuboid(0.4, 0.3, 0.25)
        };
        assert_eq!(read(tote), Ok(expected));
        assert_eq!(read("size = \"32x32x30cm\""), Ok(ContainerSize::REFERENCE));
        assert_eq!(parse_container("32x32x30cm"), Ok(ContainerSize::REFERENCE));
    }

    #[test]
    fn what_is_wrong_in_a_file_is_named() {
        let with = |more: &str| format!("size = \"40x30x25cm\"\n{more}");
        for (content, expected) in [
            ("draft = \"3deg\"".to_owned(), "size"),
            (
                "size = \"40x30cm\"".to_owned(),
                "size: '40x30cm' must be three lengths",
            ),
            (with("draft = \"3\""), "draft: '3' is no angle"),
            (
                with("draft = \"50deg\""),
                "draft_rad must be at least 0 and below",
            ),
            (with("draft = \"40deg\""), "walls do not meet"),
            (with("corner_radius = \"-1cm\""), "must not be negative"),
            (with("corner_radius = \"16cm\""), "at most half the floor's"),
            (with("drafft = \"3deg\""), "drafft"),
        ] {
            let error = read(&content).unwrap_err();
            assert!(error.contains(expected), "{error}");
            assert!(error.contains("tote.toml"), "{error}");
        }
        assert!(
            parse_container("none.toml")
                .unwrap_err()
                .contains("none.toml")
        );
    }
}
