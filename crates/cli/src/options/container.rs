//! A container by its size, or by a file where it is no box.

use std::path::{Path, PathBuf};

use ppnpack_catalogue::unit::LengthUnit;
use ppnpack_catalogue::{container, reader};
use ppnpack_packing::kernel::grid::ContainerSize;
use serde::Deserialize;

use super::file;
use crate::quantity::{parse_angle, parse_distance, parse_size};

/// Maximum side of a container's mesh, in metres: above it the unit is most likely wrong.
const MOST_SIDE_M: f64 = 5.0;

/// The content of a container's file, in the way that the options write lengths.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ContainerFile {
    /// Inner lengths at the rim, and the height from the floor.
    size: Option<String>,
    /// Angle by which each wall leans outwards.
    draft: Option<String>,
    /// Radius of the vertical edges.
    corner_radius: Option<String>,
    /// Mesh of the container, z up, in place of the numbers; beside this file.
    mesh: Option<PathBuf>,
    /// Unit of the mesh.
    unit: Option<LengthUnit>,
}

/// Parses three inner lengths, such as `32x32x30cm`, or reads the TOML file of this name.
pub(crate) fn parse_container(text: &str) -> Result<ContainerSize, String> {
    if !text.trim().ends_with(".toml") {
        return parse_size(text);
    }
    let in_file = |error: String| format!("{text} is no container: {error}");
    let path = text.trim();
    let file: ContainerFile = file::settings(path).map_err(in_file)?;
    let folder = Path::new(path).parent().unwrap_or(Path::new(""));
    file.container(folder).map_err(in_file)
}

/// Gives the inside of a container's mesh.
fn by_mesh(path: &Path, unit: LengthUnit) -> Result<ContainerSize, String> {
    let mesh = reader::read(path, unit).map_err(|error| error.to_string())?;
    let sides_m = mesh.bounds().map(|bounds| bounds.extents_m());
    let longest_m = sides_m.map_or(0.0, |sides_m| sides_m.max());
    if longest_m > MOST_SIDE_M {
        return Err(format!("it is {longest_m:.0} m long: what is its `unit`?"));
    }
    container::inside(&mesh).map_err(|error| error.to_string())
}

impl ContainerFile {
    fn container(&self, folder: &Path) -> Result<ContainerSize, String> {
        match (&self.size, &self.mesh) {
            (Some(size), None) if self.unit.is_none() => self.by_numbers(size),
            (None, Some(mesh)) if self.draft.is_none() && self.corner_radius.is_none() => {
                let found = by_mesh(&folder.join(mesh), self.unit.unwrap_or_default());
                found.map_err(|error| format!("{}: {error}", mesh.display()))
            }
            _ => Err("tell `size` with `draft` and `corner_radius`, or `mesh` with `unit`".into()),
        }
    }

    fn by_numbers(&self, size: &str) -> Result<ContainerSize, String> {
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
            ..parse_size(size).map_err(named("size"))?
        };
        let shape = container.validate_shape();
        shape.map_err(|error| error.to_string())?;
        Ok(container)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3, Vector3};
    use ppnpack_catalogue::mesh::Mesh;
    use ppnpack_physics::cell::SimulatedCell;
    use ppnpack_physics::settings::CellSettings;

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

    /// Writes a container as an ASCII STL, and gives a file that names it.
    fn of_mesh(folder: &Path, mesh: &Mesh, unit: &str) -> String {
        let facet = |[a, b, c]: [Point3<f64>; 3]| {
            let line = |point: Point3<f64>| format!("vertex {} {} {}\n", point.x, point.y, point.z);
            let corners = [a, b, c].map(line).concat();
            format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
        };
        let facets: String = mesh.corners().map(facet).collect();
        let stl = format!("solid tote\n{facets}endsolid tote\n");
        std::fs::write(folder.join("tote.stl"), stl).unwrap();
        let path = folder.join("tote.toml");
        std::fs::write(&path, format!("mesh = \"tote.stl\"\nunit = \"{unit}\"\n")).unwrap();
        path.to_str().unwrap().to_owned()
    }

    /// The walls and floor of a container, as they are simulated.
    fn walls(size: ContainerSize) -> Mesh {
        let settings = CellSettings {
            container: size,
            ..CellSettings::default()
        };
        SimulatedCell::new(settings).unwrap().container_mesh()
    }

    #[test]
    fn a_container_by_its_mesh_is_the_one_by_its_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let tote = |draft_deg: f64, corner_radius_m: f64| ContainerSize {
            draft_rad: draft_deg.to_radians(),
            corner_radius_m,
            ..ContainerSize::cuboid(0.4, 0.3, 0.25)
        };
        let boxes = [
            ContainerSize::REFERENCE,
            ContainerSize::cuboid(0.25, 0.6, 0.1),
        ];
        let totes = [
            tote(3.0, 0.0),
            tote(3.0, 0.03),
            tote(0.0, 0.02),
            tote(5.0, 0.05),
        ];
        for size in boxes.into_iter().chain(totes) {
            let mut mesh = walls(size);
            // Anywhere, and in millimetres.
            for vertex in &mut mesh.vertices {
                *vertex = Point3::from(1e3 * (vertex.coords + Vector3::new(0.7, -0.2, 0.1)));
            }
            let path = of_mesh(folder.path(), &mesh, "mm");
            let found = parse_container(&path).unwrap();
            // A round corner is a polygon in a mesh.
            assert!((found.corner_radius_m - size.corner_radius_m).abs() < 0.0015);
            let corner_radius_m = found.corner_radius_m;
            assert_eq!(
                found,
                ContainerSize {
                    corner_radius_m,
                    ..size
                }
            );
            assert_eq!(found.is_box(), size.is_box());
        }
    }

    #[test]
    fn a_mesh_that_is_no_container_is_refused_with_what_to_change() {
        let folder = tempfile::tempdir().unwrap();
        let size = ContainerSize::cuboid(0.4, 0.3, 0.25);
        let with = |lowest: [f64; 3], highest: [f64; 3]| {
            let mut mesh = walls(size);
            mesh.append(&Mesh::cuboid(lowest, highest));
            mesh
        };
        let turned = Isometry3::rotation(Vector3::new(0.0, 0.0, 0.5));
        let mut narrow = walls(size);
        for vertex in narrow.vertices.iter_mut().filter(|vertex| vertex.z > 0.2) {
            vertex.x = 0.2 + 0.9 * (vertex.x - 0.2);
        }
        let large = walls(ContainerSize::cuboid(10.0, 8.0, 5.0));
        for (mesh, unit, expected) in [
            (large, "m", "tote.stl: it is 10 m long: what is its `unit`?"),
            (walls(size), "mm", "z has to be up, and the unit"),
            (Mesh::cuboid([0.0; 3], [0.4, 0.3, 0.25]), "m", "no inside"),
            // A divider up to below the rim, one up to the rim, and a block.
            (
                with([0.25, 0.0, 0.0], [0.26, 0.3, 0.2]),
                "m",
                "mm into its inside",
            ),
            (with([0.25, 0.0, 0.0], [0.26, 0.3, 0.25]), "m", "a divider"),
            (
                with([0.3, 0.1, 0.0], [0.32, 0.12, 0.02]),
                "m",
                "mm into its inside",
            ),
            (walls(size).transformed(&turned), "m", "along x and y"),
            (narrow, "m", "leans inwards by"),
        ] {
            let path = of_mesh(folder.path(), &mesh, unit);
            let error = parse_container(&path).unwrap_err();
            assert!(error.contains(expected), "{expected}: {error}");
        }
    }

    #[test]
    fn what_is_wrong_in_a_file_is_named() {
        let with = |more: &str| format!("size = \"40x30x25cm\"\n{more}");
        for (content, expected) in [
            ("draft = \"3deg\"".to_owned(), "tell `size`"),
            (with("mesh = \"tote.stl\""), "tell `size`"),
            ("mesh = \"none.stl\"".to_owned(), "none.stl"),
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
