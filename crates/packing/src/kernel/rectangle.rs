//! The least rectangle around something seen from above.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Point2, Vector2};

use crate::kernel::polygon::convex_hull;

/// Edges shorter than this have no direction, in metres.
const SHORTEST_EDGE_M: f64 = 1e-9;

/// Minimum share of its area by which a rectangle is less to be preferred: else the first stays.
const LESS: f64 = 1e-6;

/// The yaw of the least rectangle around points, 0 to a quarter turn, in radians; `None` without
/// any.
pub fn least_rectangle_rad(points: impl Iterator<Item = Point2<f64>>) -> Option<f64> {
    let mut points: Vec<Point2<f64>> = points.collect();
    let mut hull = Vec::new();
    convex_hull(&mut points, &mut hull);
    let ends = hull.iter().cycle().skip(1);
    let edges = hull.iter().zip(ends).map(|(start, end)| end - start);
    (!points.is_empty()).then(|| (-least_turn_rad(&hull, edges)).rem_euclid(FRAC_PI_2))
}

/// Gives the turn that lays one of the edges along x and makes the rectangle around points least,
/// in radians; 0 where none makes it less.
///
/// The least rectangle around a convex outline has a side along one of the outline's edges.
///
/// Source: Freeman and Shapira, *Determining the Minimum-Area Encasing Rectangle*, 1975.
pub fn least_turn_rad(points: &[Point2<f64>], edges: impl Iterator<Item = Vector2<f64>>) -> f64 {
    let turns = edges
        .filter(|edge| edge.norm() > SHORTEST_EDGE_M)
        .map(|edge| -edge.y.atan2(edge.x));
    let area_m2 = |turn_rad: f64| sides_m(points, turn_rad).product();
    let mut best = (0.0, area_m2(0.0));
    for turn_rad in turns {
        let area_m2 = area_m2(turn_rad);
        if area_m2 < best.1 * (1.0 - LESS) {
            best = (turn_rad, area_m2);
        }
    }
    best.0
}

/// The sides of the rectangle along the axes around turned points, in metres.
pub fn sides_m(points: &[Point2<f64>], turn_rad: f64) -> Vector2<f64> {
    let (sin, cos) = turn_rad.sin_cos();
    let turned = points
        .iter()
        .map(|at| Vector2::new(cos * at.x - sin * at.y, sin * at.x + cos * at.y));
    let none = (
        Vector2::repeat(f64::INFINITY),
        Vector2::repeat(f64::NEG_INFINITY),
    );
    let (lowest, highest) = turned.fold(none, |(lowest, highest), at| {
        (lowest.inf(&at), highest.sup(&at))
    });
    highest - lowest
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation2;

    use super::*;

    #[test]
    fn a_turned_box_is_found() {
        let corners = [(0.0, 0.0), (0.3, 0.0), (0.3, 0.1), (0.0, 0.1), (0.1, 0.05)];
        for yaw_deg in [0.0, 7.0, 31.0, 88.0] {
            let turn = Rotation2::new(f64::to_radians(yaw_deg));
            let points = corners.iter().map(|(x, y)| turn * Point2::new(*x, *y));
            let found_rad = least_rectangle_rad(points).unwrap();
            let off_rad = (found_rad - yaw_deg.to_radians()).rem_euclid(FRAC_PI_2);
            assert!(off_rad.min(FRAC_PI_2 - off_rad) < 1e-9, "{yaw_deg}");
        }
    }

    #[test]
    fn what_has_no_area_has_a_rectangle_all_the_same() {
        assert_eq!(least_rectangle_rad(std::iter::empty()), None);
        let point = Point2::new(0.1, 0.2);
        let same = std::iter::repeat_n(point, 3);
        assert_eq!(least_rectangle_rad(same), Some(0.0));
        let line = (0..5).map(|step| Point2::new(f64::from(step), f64::from(step)));
        let found_rad = least_rectangle_rad(line).unwrap();
        assert!((found_rad - FRAC_PI_2 / 2.0).abs() < 1e-9);
    }
}
