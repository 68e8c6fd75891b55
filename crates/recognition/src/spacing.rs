//! How far apart the points of a cloud lie.

use nalgebra::Point3;

use crate::segmentation::Cluster;

/// The edge of the squares that points are counted in, in metres.
const SQUARE_M: f64 = 0.005;

/// The least and greatest spacing, in metres.
const SPACING_M: (f64, f64) = (0.0007, 0.004);

/// The distance between neighbouring points of a cluster at the support, in metres: of what a square in the middle of
/// others holds, at the support's distance from the camera.
pub(crate) fn spacing_m(cluster: &Cluster) -> f64 {
    let all = || cluster.points_m.iter().chain(&cluster.surroundings_m);
    let Some(first) = all().next() else {
        return SPACING_M.1;
    };
    let (mut lowest, mut highest) = (first.xy(), first.xy());
    for point in all() {
        lowest = lowest.inf(&point.xy());
        highest = highest.sup(&point.xy());
    }
    let extents = (highest - lowest) / SQUARE_M;
    let (nx, ny) = (
        (extents.x as usize).min(400) + 1,
        (extents.y as usize).min(400) + 1,
    );
    let mut counts = vec![0_u32; nx * ny];
    let square = |point: &Point3<f64>| {
        let offset = (point.xy() - lowest) / SQUARE_M;
        (offset.x as usize).min(nx - 1) * ny + (offset.y as usize).min(ny - 1)
    };
    for point in all() {
        if let Some(count) = counts.get_mut(square(point)) {
            *count += 1;
        }
    }
    counts.retain(|count| *count > 0);
    let middle = counts.len() / 2;
    if counts.is_empty() {
        return SPACING_M.1;
    }
    let (_, typical, _) = counts.select_nth_unstable(middle);
    (SQUARE_M / f64::from((*typical).max(1)).sqrt()).clamp(SPACING_M.0, SPACING_M.1)
}
