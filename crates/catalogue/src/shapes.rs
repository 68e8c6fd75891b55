//! Simple closed meshes for tests.

use nalgebra::{Point3, Vector3};

use crate::mesh::Mesh;

/// A cuboid by its lowest corner and its edges, in metres.
pub(crate) fn cuboid(lowest: Point3<f64>, size: Vector3<f64>) -> Mesh {
    let corner = |index: u32| {
        let at = |bit: u32| f64::from(index >> bit & 1);
        lowest + Vector3::new(at(0), at(1), at(2)).component_mul(&size)
    };
    let faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    Mesh {
        vertices: (0..8).map(corner).collect(),
        triangles: faces
            .iter()
            .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
            .collect(),
    }
}

/// A cube around the origin.
pub(crate) fn cube(edge_m: f64) -> Mesh {
    cuboid(Point3::from([-edge_m / 2.0; 3]), Vector3::from([edge_m; 3]))
}

/// Two meshes as one.
pub(crate) fn joined(first: &Mesh, second: &Mesh) -> Mesh {
    let mut mesh = first.clone();
    let offset = mesh.vertices.len() as u32;
    mesh.vertices.extend_from_slice(&second.vertices);
    mesh.triangles.extend(
        second
            .triangles
            .iter()
            .map(|corners| corners.map(|at| at + offset)),
    );
    mesh
}

/// A ball as a globe of quadrilaterals and two caps.
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

/// A tube along z by its outer and inner radius and its length.
pub(crate) fn tube(outer_m: f64, inner_m: f64, length_m: f64, around: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for step in 0..around {
        let turn = std::f64::consts::TAU * f64::from(step) / f64::from(around);
        for (radius_m, z) in [
            (outer_m, 0.0),
            (outer_m, length_m),
            (inner_m, length_m),
            (inner_m, 0.0),
        ] {
            mesh.vertices
                .push(Point3::new(radius_m * turn.cos(), radius_m * turn.sin(), z));
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
