//! Simple closed meshes for the tests of several crates.

use nalgebra::Point3;
use ppnpack_packing::scene::model::mesh::Mesh;

/// A ball around the origin, as a globe of quadrilaterals and two caps.
pub(crate) fn ball(radius_m: f64, around: u32, rings: u32) -> Mesh {
    let mut vertices = vec![Point3::new(0.0, 0.0, -radius_m)];
    for ring in 1..rings {
        let down = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
        for step in 0..around {
            let turn = std::f64::consts::TAU * f64::from(step) / f64::from(around);
            let (x, y) = (turn.cos() * down.sin(), turn.sin() * down.sin());
            vertices.push(Point3::new(x, y, -down.cos()) * radius_m);
        }
    }
    let top = vertices.len() as u32;
    vertices.push(Point3::new(0.0, 0.0, radius_m));
    let at = |ring: u32, step: u32| 1 + (ring - 1) * around + step % around;
    let mut triangles = Vec::new();
    for step in 0..around {
        triangles.push([0, at(1, step + 1), at(1, step)]);
        triangles.push([top, at(rings - 1, step), at(rings - 1, step + 1)]);
        for ring in 1..rings - 1 {
            let (a, b) = (at(ring, step), at(ring, step + 1));
            let (c, d) = (at(ring + 1, step + 1), at(ring + 1, step));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Mesh {
        vertices,
        triangles,
    }
}
