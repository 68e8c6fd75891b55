//! Shading normals: smooth across curved surfaces, sharp at creases.

use nalgebra::{Point3, Vector3};

/// Neighbouring faces that bend by more than this keep their own shading: 35 degrees.
const CREASE_COSINE: f32 = 0.819_152;

/// At most so many faces around a vertex are averaged, so that a fan around one vertex cannot cost quadratic time.
const MOST_NEIGHBOURS: usize = 64;

/// The shading normal at each corner of each triangle: the mean, by area, of the faces around the vertex that bend
/// away by less than the crease angle. Vertices at equal positions count as one, since many files repeat them for
/// each triangle. Indices must be in range; those beyond get no neighbours.
pub(super) fn corner_normals(
    vertices: &[Point3<f32>],
    triangles: &[[u32; 3]],
) -> Vec<[Vector3<f32>; 3]> {
    let point = |index: u32| vertices.get(index as usize).copied().unwrap_or_default();
    let areas: Vec<Vector3<f32>> = triangles
        .iter()
        .map(|[a, b, c]| (point(*b) - point(*a)).cross(&(point(*c) - point(*a))))
        .collect();
    let directions: Vec<Vector3<f32>> = areas
        .iter()
        .map(|area| area.try_normalize(0.0).unwrap_or_else(Vector3::z))
        .collect();

    let welded = welded(vertices);
    let faces = FacesAround::new(&welded, triangles);
    triangles
        .iter()
        .zip(&directions)
        .map(|(triangle, own)| {
            triangle.map(|corner| {
                let mean: Vector3<f32> = faces
                    .around(welded.get(corner as usize).copied().unwrap_or(corner))
                    .iter()
                    .take(MOST_NEIGHBOURS)
                    .filter_map(|face| Some((areas.get(*face)?, directions.get(*face)?)))
                    .filter(|(_, direction)| direction.dot(own) >= CREASE_COSINE)
                    .map(|(area, _)| area)
                    .sum();
                mean.try_normalize(0.0).unwrap_or(*own)
            })
        })
        .collect()
}

/// Per vertex the lowest index of a vertex at the same position.
fn welded(vertices: &[Point3<f32>]) -> Vec<u32> {
    let mut order: Vec<(u32, &Point3<f32>)> = (0..).zip(vertices).collect();
    order.sort_unstable_by(|(i, p), (j, q)| {
        p.x.total_cmp(&q.x)
            .then(p.y.total_cmp(&q.y))
            .then(p.z.total_cmp(&q.z))
            .then(i.cmp(j))
    });
    let mut representatives = vec![0; vertices.len()];
    for group in order.chunk_by(|(_, p), (_, q)| p == q) {
        let lowest = group.iter().map(|(index, _)| *index).min().unwrap_or(0);
        for (index, _) in group {
            if let Some(slot) = representatives.get_mut(*index as usize) {
                *slot = lowest;
            }
        }
    }
    representatives
}

/// The faces around each vertex, one after the other in a single list.
struct FacesAround {
    starts: Vec<usize>,
    faces: Vec<usize>,
}

impl FacesAround {
    fn new(welded: &[u32], triangles: &[[u32; 3]]) -> Self {
        let mut corners: Vec<(u32, usize)> = triangles
            .iter()
            .enumerate()
            .flat_map(|(face, triangle)| triangle.map(|corner| (corner, face)))
            .filter_map(|(corner, face)| Some((*welded.get(corner as usize)?, face)))
            .collect();
        corners.sort_unstable();
        let starts = (0..=welded.len() as u32)
            .map(|vertex| corners.partition_point(|(corner, _)| *corner < vertex))
            .collect();
        Self {
            starts,
            faces: corners.into_iter().map(|(_, face)| face).collect(),
        }
    }

    fn around(&self, vertex: u32) -> &[usize] {
        let vertex = vertex as usize;
        match self.starts.get(vertex..vertex + 2) {
            Some(&[start, end]) => self.faces.get(start..end).unwrap_or_default(),
            _ => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles that share the edge from the origin to (1, 0, 0), the second raised by `angle`.
    fn hinge(angle_deg: f32) -> Vec<[Vector3<f32>; 3]> {
        let (sine, cosine) = angle_deg.to_radians().sin_cos();
        let vertices = [
            Point3::origin(),
            Point3::new(1.0, 0.0, 0.0),
            Point3::new(0.0, -1.0, 0.0),
            // The shared edge again, as in files without shared vertices.
            Point3::origin(),
            Point3::new(1.0, 0.0, 0.0),
            Point3::new(0.0, cosine, sine),
        ];
        corner_normals(&vertices, &[[0, 2, 1], [3, 4, 5]])
    }

    #[test]
    fn smooth_below_the_crease_angle_and_sharp_above() {
        let smooth = hinge(30.0);
        assert!((smooth[0][0] - smooth[1][0]).norm() < 1e-6);
        let sharp = hinge(40.0);
        assert!((sharp[0][0] - Vector3::z()).norm() < 1e-6);
        assert!(sharp[1][0].angle(&Vector3::z()).to_degrees() > 39.0);
    }

    #[test]
    fn degenerate_triangles_have_unit_normals() {
        let normals = corner_normals(&[Point3::origin()], &[[0, 0, 0], [0, 7, 9]]);
        assert!(
            normals
                .iter()
                .flatten()
                .all(|normal| (normal.norm() - 1.0).abs() < 1e-6)
        );
    }
}
