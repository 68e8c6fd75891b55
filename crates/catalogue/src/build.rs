//! Meshes to models.

use nalgebra::{Isometry3, Point2, UnitQuaternion, Vector3};
use ppnpack_packing::kernel::rectangle::{least_turn_rad, sides_m};
use serde::{Deserialize, Serialize};

use crate::convex::pieces_of_volume;
use crate::error::ObjectError;
use crate::hull::{hull, sides};
use crate::mass::{DEFAULT_DENSITY_KG_M3, mass_properties, mass_properties_without};
use crate::mesh::Mesh;
use crate::object::Model;
use crate::overlap::excess;
use crate::repair::{Repair, doubted, repaired};
use crate::resting::resting_poses;
use crate::unit::LengthUnit;

/// The pose in which objects are packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Pose {
    /// Pose of the mesh file, z up.
    #[default]
    AsGiven,
    /// The most probable resting pose, its footprint turned to fill the least rectangle, the longer
    /// side along x.
    MostProbable,
}

/// Settings by which a mesh becomes a model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ModelSettings {
    /// The unit in which the mesh was drawn; the mesh itself is in metres.
    pub unit: LengthUnit,
    /// The density of objects whose mass is not known, in kg/m^3.
    pub density_kg_m3: f64,
    /// The mass, in kilograms, where it is known.
    pub mass_kg: Option<f64>,
    /// The greatest mass that may rest on it, in kilograms, where it is known.
    pub carries_kg: Option<f64>,
    /// The pose in which it is packed.
    pub pose: Pose,
}

impl Default for ModelSettings {
    fn default() -> Self {
        Self {
            unit: LengthUnit::Metres,
            density_kg_m3: DEFAULT_DENSITY_KG_M3,
            mass_kg: None,
            carries_kg: None,
            pose: Pose::AsGiven,
        }
    }
}

/// The model of a mesh in metres, and what was repaired about the mesh.
///
/// # Errors
/// [`ObjectError`] where the mesh is no solid and cannot be made one.
pub fn model(
    name: &str,
    mesh: Mesh,
    settings: &ModelSettings,
) -> Result<(Model, Vec<Repair>), ObjectError> {
    let (mut mesh, mut repairs) = repaired(mesh, settings.unit)?;
    if settings.pose == Pose::MostProbable {
        mesh = most_probable(mesh);
    }
    let mut volume_m3 = mesh.signed_volume_m3();
    let excess = excess(&mesh).unwrap_or_default();
    if excess.volume_m3 != 0.0 {
        let percent = (100.0 * excess.volume_m3.abs() / volume_m3).round();
        repairs.push(Repair::Shared(percent as usize));
        volume_m3 -= excess.volume_m3;
    }
    let density = settings
        .mass_kg
        .map_or(settings.density_kg_m3, |mass_kg| mass_kg / volume_m3);
    let mass = mass_properties_without(&mesh, &excess, density);
    repairs.extend(doubted(&mesh, mass.mass_kg, settings.unit));
    let model = Model {
        name: name.to_owned(),
        volume_m3,
        pieces: pieces_of_volume(&mesh, volume_m3),
        resting_poses: resting_poses(&mesh, &mass.centre_of_mass_m),
        mass,
        carries_kg: settings.carries_kg,
        mesh,
    };
    Ok((model, repairs))
}

/// The mesh in its most probable resting pose, turned to fill the least rectangle.
fn most_probable(mesh: Mesh) -> Mesh {
    let centre = mass_properties(&mesh, 1.0).centre_of_mass_m;
    let poses = resting_poses(&mesh, &centre);
    let Some(pose) = poses.first() else {
        return mesh;
    };
    let laid = mesh.transformed(&nalgebra::convert(pose.rotation));
    let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), least_rectangle_yaw(&laid));
    laid.transformed(&nalgebra::convert::<_, Isometry3<f64>>(yaw))
}

/// The yaw at which the rectangle around a mesh seen from above is least, its longer side along x,
/// in radians.
fn least_rectangle_yaw(mesh: &Mesh) -> f64 {
    let Some(hull) = hull(&mesh.vertices) else {
        return 0.0;
    };
    let plan: Vec<Point2<f64>> = hull.vertices.iter().map(|vertex| vertex.xy()).collect();
    // The outline's edges are among those of the hull.
    let edges = hull
        .triangles
        .iter()
        .flat_map(|corners| sides(*corners))
        .filter_map(|(from, to)| Some(plan.get(to as usize)? - plan.get(from as usize)?));
    longer_side_along_x(&plan, least_turn_rad(&plan, edges))
}

/// The yaw that lays a rectangle around points along the axes, or a quarter turn more, so that its
/// longer side is along x, in radians.
pub(crate) fn longer_side_along_x(plan: &[Point2<f64>], yaw_rad: f64) -> f64 {
    let sides_m = sides_m(plan, yaw_rad);
    if sides_m.y > sides_m.x * (1.0 + 1e-6) {
        yaw_rad + std::f64::consts::FRAC_PI_2
    } else {
        yaw_rad
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_probable_pose_lies_flat_and_straight() {
        let tilt = UnitQuaternion::from_euler_angles(0.3, -0.5, 0.8);
        let mesh = Mesh::cuboid([0.1, 0.2, 0.3], [0.12, 0.4, 0.4])
            .transformed(&nalgebra::convert::<_, Isometry3<f64>>(tilt));
        let settings = ModelSettings {
            pose: Pose::MostProbable,
            ..ModelSettings::default()
        };
        let (model, _) = model("tile", mesh, &settings).unwrap();
        let extents = model.mesh.bounds().unwrap().extents_m();
        assert!(
            (extents - Vector3::new(0.2, 0.1, 0.02)).norm() < 1e-6,
            "{extents}"
        );
        let down = model.resting_poses[0].rotation * -Vector3::z();
        assert!((down + Vector3::z()).norm() < 1e-6 || (down - Vector3::z()).norm() < 1e-6);
    }

    #[test]
    fn a_known_mass_replaces_the_density() {
        let mesh = Mesh::cuboid([0.0; 3], [0.1; 3]);
        let settings = ModelSettings {
            mass_kg: Some(2.0),
            ..ModelSettings::default()
        };
        let (heavy, repairs) = model("weight", mesh, &settings).unwrap();
        assert!(repairs.is_empty());
        assert!((heavy.mass.mass_kg - 2.0).abs() < 1e-9);
        assert!((heavy.volume_m3 - 0.001).abs() < 1e-12);
        assert_eq!(heavy.pieces.len(), 1);
    }

    #[test]
    fn space_that_parts_share_is_counted_once() {
        let mut mesh = Mesh::cuboid([0.0; 3], [0.06; 3]);
        mesh.append(&Mesh::cuboid([0.04, 0.02, 0.02], [0.1, 0.04, 0.04]));
        let (model, repairs) = model("handle", mesh, &ModelSettings::default()).unwrap();
        // 216 and 24 cm³, less 8 that are of both.
        assert!(
            (model.volume_m3 * 1e6 - 232.0).abs() < 0.2,
            "{}",
            model.volume_m3
        );
        assert!((model.mass.mass_kg - 400.0 * model.volume_m3).abs() < 1e-9);
        let centre_x = (216.0 * 0.03 + 16.0 * 0.08) / 232.0;
        assert!((model.mass.centre_of_mass_m.x - centre_x).abs() < 1e-4);
        assert_eq!(repairs, vec![Repair::Shared(3)]);
    }

    #[test]
    fn a_size_that_is_not_likely_is_said_with_the_likely_unit() {
        let block = Mesh::cuboid([0.0; 3], [4.0, 2.0, 1.5]);
        let (_, repairs) = model("block", block, &ModelSettings::default()).unwrap();
        let [doubt] = &repairs[..] else {
            panic!("{repairs:?}")
        };
        assert!(doubt.is_doubt());
        assert_eq!(
            doubt.to_string(),
            "4 m long and 4800 kg is not likely: it was read in m; give in or cm as its unit if it was drawn so"
        );
    }
}
