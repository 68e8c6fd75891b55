//! Small flat holes are closed.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

use super::orientation::boundary;
use crate::mesh::{Bounds, Mesh};

/// A hole wider than this share of the object is left open: the object may be a shell without
/// thickness.
const MAX_WIDTH_SHARE: f64 = 0.2;

/// A hole's border lies within this share of its width of a plane.
const FLATNESS_SHARE: f64 = 0.02;

/// Closes the small flat holes of a surface by a fan around their middle; returns how many.
///
/// Nothing is closed where borders of holes touch each other.
pub(super) fn cap(mesh: &mut Mesh, size_m: f64) -> usize {
    let Some(loops) = loops(mesh) else { return 0 };
    let mut count = 0;
    for border in loops {
        if let Some(middle) = middle(mesh, &border, size_m) {
            let hub = mesh.vertices.len() as u32;
            mesh.vertices.push(middle);
            let next = border.iter().cycle().skip(1);
            mesh.triangles
                .extend(border.iter().zip(next).map(|(from, to)| [hub, *from, *to]));
            count += 1;
        }
    }
    count
}

/// The borders of holes, each in the direction in which a cap passes it.
fn loops(mesh: &Mesh) -> Option<Vec<Vec<u32>>> {
    let mut next = BTreeMap::new();
    for side in boundary(mesh)? {
        let (from, to) = side.ends();
        if next.insert(to, from).is_some() {
            return None;
        }
    }
    let mut loops = Vec::new();
    while let Some((start, mut at)) = next.pop_first() {
        let mut border = vec![start];
        while at != start {
            border.push(at);
            at = next.remove(&at)?;
        }
        loops.push(border);
    }
    Some(loops)
}

/// The middle of a hole that a fan around it closes without folds; `None` for others.
fn middle(mesh: &Mesh, border: &[u32], size_m: f64) -> Option<Point3<f64>> {
    let points: Option<Vec<Point3<f64>>> = border
        .iter()
        .map(|vertex| mesh.vertices.get(*vertex as usize).copied())
        .collect();
    let points = points?;
    let width_m = Bounds::of(&points)?.extents_m().norm();
    if width_m > MAX_WIDTH_SHARE * size_m {
        return None;
    }
    let sum: Vector3<f64> = points.iter().map(|point| point.coords).sum();
    let middle = Point3::from(sum / points.len() as f64);
    let spokes = points.iter().map(|point| point - middle);
    let next = points.iter().cycle().skip(1).map(|point| point - middle);
    let normals: Vec<Vector3<f64>> = spokes.zip(next).map(|(a, b)| a.cross(&b)).collect();
    let normal = normals.iter().sum::<Vector3<f64>>().try_normalize(0.0)?;
    let flat = points
        .iter()
        .all(|point| (point - middle).dot(&normal).abs() <= FLATNESS_SHARE * width_m);
    let unfolded = normals.iter().all(|part| part.dot(&normal) > 0.0);
    (flat && unfolded).then_some(middle)
}
