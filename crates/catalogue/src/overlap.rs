//! Space that a closed surface winds around more than once, or inwards: parts that overlap.

use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;

use crate::mass::{Moments, reference};
use crate::mesh::Mesh;

/// Columns along x and along y in which a mesh is measured.
const COLUMNS: usize = 200;

/// Less than this share of the volume is a crumb or a fold of a scan, and left as it is.
const LEAST_SHARE: f64 = 0.01;

/// Measures by how much the signed volume of a mesh exceeds that of the union of its parts; `None`
/// where it hardly does.
///
/// Each column is passed from below: space within `n` shells is counted `n - 1` times too often,
/// space within an inverted one once too little. The moments are around the mesh's [`reference`].
pub(crate) fn excess(mesh: &Mesh) -> Option<Moments> {
    let bounds = mesh.bounds()?;
    let origin = reference(mesh);
    let step = bounds.extents_m().xy() / COLUMNS as f64;
    // Beside the middle of a column, where no drawn edge runs.
    let at = |index: usize, lowest: f64, step: f64| lowest + (index as f64 + 0.493_817) * step;
    let triangles: Vec<[Point3<f64>; 3]> = mesh.corners().collect();
    let row = |row: usize| {
        let y = at(row, bounds.lowest.y, step.y);
        let of_row = triangles.iter().filter(|corners| {
            let is_above = |corner: &Point3<f64>| corner.y > y;
            corners.iter().any(is_above) && !corners.iter().all(is_above)
        });
        let of_row: Vec<&[Point3<f64>; 3]> = of_row.collect();
        let mut moments = Moments::default();
        let mut crossings = Vec::new();
        for column in 0..COLUMNS {
            let x = at(column, bounds.lowest.x, step.x);
            crossings.clear();
            crossings.extend(of_row.iter().filter_map(|corners| crossing(corners, x, y)));
            crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
            // An edge that a column runs through belongs to none of its triangles.
            if crossings.iter().map(|crossing| crossing.1).sum::<i32>() != 0 {
                continue;
            }
            let mut winding = 0;
            for (from, to) in crossings.iter().zip(crossings.iter().skip(1)) {
                winding += from.1;
                let too_often = winding - winding.clamp(0, 1);
                if too_often != 0 {
                    let middle = Point3::new(x, y, (from.0 + to.0) / 2.0) - origin;
                    let sides = Vector3::new(step.x, step.y, to.0 - from.0);
                    let volume_m3 = sides.product() * f64::from(too_often);
                    moments.volume_m3 += volume_m3;
                    moments.first += middle * volume_m3;
                    let own = Matrix3::from_diagonal(&sides.component_mul(&sides)) / 12.0;
                    moments.second += (middle * middle.transpose() + own) * volume_m3;
                }
            }
        }
        moments
    };
    let rows: Vec<Moments> = (0..COLUMNS).into_par_iter().map(row).collect();
    let mut sum = Moments::default();
    let mut counted_m3 = 0.0;
    for row in rows {
        counted_m3 += row.volume_m3.abs();
        sum.volume_m3 += row.volume_m3;
        sum.first += row.first;
        sum.second += row.second;
    }
    (counted_m3 > LEAST_SHARE * mesh.signed_volume_m3()).then_some(sum)
}

/// The height at which a column crosses a triangle, and 1 where it enters the solid there, -1 where
/// it leaves.
fn crossing(corners: &[Point3<f64>; 3], x: f64, y: f64) -> Option<(f64, i32)> {
    let [a, b, c] = corners.map(|corner| corner.xy() - nalgebra::Point2::new(x, y));
    let shares = [b.perp(&c), c.perp(&a), a.perp(&b)];
    let faces_down = shares.iter().all(|share| *share < 0.0);
    let faces_up = shares.iter().all(|share| *share > 0.0);
    if !faces_down && !faces_up {
        return None;
    }
    let [p, q, r] = corners;
    let height = shares[0] * p.z + shares[1] * q.z + shares[2] * r.z;
    Some((
        height / shares.iter().sum::<f64>(),
        if faces_down { 1 } else { -1 },
    ))
}
