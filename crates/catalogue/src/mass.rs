//! Volume, centre of mass and inertia of a closed mesh of uniform density.

use nalgebra::{Matrix3, Point3, Vector3};

use crate::mesh::Mesh;
use crate::object::MassProperties;

/// The density that an object is given where nothing else is known, in kg/m^3: a mean of packed
/// goods.
pub const DEFAULT_DENSITY_KG_M3: f64 = 400.0;

/// Moments of space around a point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Moments {
    /// Volume, in cubic metres.
    pub(crate) volume_m3: f64,
    /// Integrals of x.
    pub(crate) first: Vector3<f64>,
    /// Integrals of x x^T.
    pub(crate) second: Matrix3<f64>,
}

/// The mass properties of a closed mesh of uniform density, in kg/m^3, exact for its triangles.
///
/// Sums the signed tetrahedra between each triangle and a point near the mesh.
pub fn mass_properties(mesh: &Mesh, density_kg_m3: f64) -> MassProperties {
    mass_properties_without(mesh, &Moments::default(), density_kg_m3)
}

/// The point around which moments of a mesh are: near it, which keeps the sums free of
/// cancellation.
pub(crate) fn reference(mesh: &Mesh) -> Point3<f64> {
    mesh.bounds().map_or_else(Point3::origin, |bounds| {
        nalgebra::center(&bounds.lowest, &bounds.highest)
    })
}

/// The mass properties of a mesh less those of space that it counts too often, by its moments
/// around the [`reference`].
pub(crate) fn mass_properties_without(
    mesh: &Mesh,
    excess: &Moments,
    density_kg_m3: f64,
) -> MassProperties {
    let reference = reference(mesh);
    let mut volume = 0.0 - excess.volume_m3;
    let mut first = Vector3::zeros() - excess.first;
    let mut second = Matrix3::zeros() - excess.second;
    for corners in mesh.corners() {
        let [a, b, c] = corners.map(|corner| corner - reference);
        let determinant = a.dot(&b.cross(&c));
        let sum = a + b + c;
        volume += determinant / 6.0;
        first += sum * (determinant / 24.0);
        let products =
            a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose();
        second += products * (determinant / 120.0);
    }
    let centre = if volume == 0.0 {
        Vector3::zeros()
    } else {
        first / volume
    };
    let central = second - centre * centre.transpose() * volume;
    let inertia = Matrix3::identity() * central.trace() - central;
    MassProperties {
        mass_kg: density_kg_m3 * volume,
        centre_of_mass_m: reference + centre,
        inertia_kg_m2: inertia * density_kg_m3,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::mesh::Bounds;

    proptest! {
        #[test]
        fn a_cuboid_has_the_textbook_inertia(
            size in prop::array::uniform3(0.01..0.5_f64),
            at in prop::array::uniform3(-2.0..2.0_f64),
        ) {
            let [x, y, z] = size;
            let lowest = Point3::from(at);
            let bounds = Bounds { lowest, highest: lowest + Vector3::from(size) };
            let mass = mass_properties(&bounds.mesh(), 500.0);
            let expected_kg = 500.0 * x * y * z;
            prop_assert!((mass.mass_kg - expected_kg).abs() < 1e-9 * expected_kg);
            let centre = lowest + Vector3::from(size) / 2.0;
            prop_assert!((mass.centre_of_mass_m - centre).norm() < 1e-9);
            let squares = Vector3::new(y * y + z * z, x * x + z * z, x * x + y * y);
            let expected = Matrix3::from_diagonal(&(squares * (expected_kg / 12.0)));
            prop_assert!((mass.inertia_kg_m2 - expected).norm() < 1e-6 * expected.norm());
        }
    }
}
