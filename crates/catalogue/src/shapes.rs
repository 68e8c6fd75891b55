//! Simple closed meshes for tests.

use nalgebra::Point3;

use crate::mesh::Mesh;

#[path = "../../../tests/shapes.rs"]
mod shared;

pub(crate) use self::shared::ball;

/// A cube around the origin.
pub(crate) fn cube(edge_m: f64) -> Mesh {
    Mesh::cuboid([-edge_m / 2.0; 3], [edge_m / 2.0; 3])
}

/// A tube along z by its outer and inner radius and its length.
pub(crate) fn tube(outer_m: f64, inner_m: f64, length_m: f64, around: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for step in 0..around {
        let turn = std::f64::consts::TAU * f64::from(step) / f64::from(around);
        let (sin, cos) = turn.sin_cos();
        for (radius_m, ends_m) in [(outer_m, [0.0, length_m]), (inner_m, [length_m, 0.0])] {
            let at = |z| Point3::new(radius_m * cos, radius_m * sin, z);
            mesh.vertices.extend(ends_m.map(at));
        }
        let next = (step + 1) % around;
        for side in 0..4 {
            let (a, b) = (4 * step + side, 4 * next + side);
            let (c, d) = (4 * next + (side + 1) % 4, 4 * step + (side + 1) % 4);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}
