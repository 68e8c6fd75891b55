//! The least rectangle around something seen from above.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::{Point2, Vector2};

/// Directions in which the outermost point is kept.
const DIRECTIONS: usize = 360;

/// Yaws are tried in steps of a degree, and around the best in steps that are a twentieth of those before.
const STEP_RAD: f64 = FRAC_PI_2 / 90.0;
const FINER: f64 = 20.0;
const FINEST_RAD: f64 = 1e-11;

/// The yaw of the rectangle of the least area around some points, from 0 up to a quarter turn, in radians; `None`
/// without points.
///
/// It is sought around the outermost point of each direction from the middle.
pub(crate) fn least_rectangle_rad(
    points: impl Iterator<Item = Point2<f64>> + Clone,
) -> Option<f64> {
    let (count, sum) = points
        .clone()
        .fold((0_usize, Vector2::zeros()), |(count, sum), point| {
            (count + 1, sum + point.coords)
        });
    if count == 0 {
        return None;
    }
    let middle = sum / count as f64;
    let mut outermost = vec![Vector2::zeros(); DIRECTIONS];
    for point in points {
        let offset = point.coords - middle;
        let share = offset.y.atan2(offset.x).rem_euclid(TAU) / TAU;
        let direction = (share * DIRECTIONS as f64) as usize;
        if let Some(place) = outermost.get_mut(direction.min(DIRECTIONS - 1))
            && place.norm_squared() < offset.norm_squared()
        {
            *place = offset;
        }
    }
    let best = |from_rad: f64, step_rad: f64, steps: usize| {
        let yaws_rad = (0..steps).map(|step| from_rad + step as f64 * step_rad);
        let areas = yaws_rad.map(|yaw_rad| (yaw_rad, area_m2(&outermost, yaw_rad)));
        let least = areas.min_by(|a, b| a.1.total_cmp(&b.1));
        least.map_or(from_rad, |(yaw_rad, _)| yaw_rad)
    };
    let mut step_rad = STEP_RAD;
    let mut yaw_rad = best(0.0, step_rad, (FRAC_PI_2 / STEP_RAD).round() as usize);
    while step_rad > FINEST_RAD {
        let from_rad = yaw_rad - step_rad;
        step_rad /= FINER;
        yaw_rad = best(from_rad, step_rad, 2 * FINER as usize + 1);
    }
    Some(yaw_rad.rem_euclid(FRAC_PI_2))
}

/// The area of the rectangle at a yaw around points.
fn area_m2(points: &[Vector2<f64>], yaw_rad: f64) -> f64 {
    let (sin, cos) = yaw_rad.sin_cos();
    let turned = points
        .iter()
        .map(|point| Vector2::new(cos * point.x + sin * point.y, cos * point.y - sin * point.x));
    let none = (
        Vector2::from_element(f64::INFINITY),
        Vector2::from_element(f64::NEG_INFINITY),
    );
    let (lowest, highest) = turned.fold(none, |(lowest, highest), point| {
        (lowest.inf(&point), highest.sup(&point))
    });
    (highest.x - lowest.x) * (highest.y - lowest.y)
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
            assert!(off_rad.min(FRAC_PI_2 - off_rad) < 1e-6, "{yaw_deg}");
        }
        assert_eq!(least_rectangle_rad(std::iter::empty()), None);
    }
}
