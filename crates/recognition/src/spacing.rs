//! The spacing of a cloud's points.

use nalgebra::Vector2;

use crate::groups::Cells;
use crate::segmentation::Cluster;

/// Edge of the squares that points are counted in, in metres.
const SQUARE_M: f64 = 0.005;

/// Maximum number of squares along a side, less one.
const MOST_SQUARES: usize = 400;

/// Minimum and maximum spacing, in metres.
const SPACING_M: (f64, f64) = (0.0007, 0.004);

/// Gives the distance between neighbouring points of a cluster at the support, in metres: of what a
/// square in the middle of others holds, at the support's distance from the camera.
pub(crate) fn spacing_m(cluster: &Cluster) -> f64 {
    let all = || cluster.points_m.iter().chain(&cluster.surroundings_m);
    let none = (Vector2::repeat(f64::MAX), Vector2::repeat(f64::MIN));
    let (lowest, highest) = all().fold(none, |(lowest, highest), point| {
        let place = point.xy().coords;
        (lowest.inf(&place), highest.sup(&place))
    });
    let extents = (highest - lowest) / SQUARE_M;
    let count = |extent: f64| (extent as usize).min(MOST_SQUARES) + 1;
    let squares = Cells {
        origin: lowest.into(),
        edge_m: SQUARE_M,
        nx: count(extents.x),
        ny: count(extents.y),
    };
    let mut counts = vec![0_u32; squares.nx * squares.ny];
    for point in all() {
        if let Some(count) = counts.get_mut(squares.at(point)) {
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
