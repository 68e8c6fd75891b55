//! Closed outlines in the plane, in millimetres, counter-clockwise, and their triangulation.

use std::f64::consts::{FRAC_PI_2, TAU};

/// A point in the plane, in millimetres.
pub(crate) type Point = [f64; 2];

/// Points per quarter turn of a rounded corner.
const CORNER_STEPS: usize = 4;

/// A rectangle around the origin.
pub(crate) fn rectangle(width_mm: f64, depth_mm: f64) -> Vec<Point> {
    let (x, y) = (width_mm / 2.0, depth_mm / 2.0);
    vec![[-x, -y], [x, -y], [x, y], [-x, y]]
}

/// A rectangle around the origin with rounded corners.
pub(crate) fn rounded_rectangle(width_mm: f64, depth_mm: f64, radius_mm: f64) -> Vec<Point> {
    let (x, y) = (width_mm / 2.0 - radius_mm, depth_mm / 2.0 - radius_mm);
    [[x, y], [-x, y], [-x, -y], [x, -y]]
        .into_iter()
        .enumerate()
        .flat_map(|(corner, centre)| {
            let start = corner as f64 * FRAC_PI_2;
            arc(centre, radius_mm, start, start + FRAC_PI_2, CORNER_STEPS)
        })
        .collect()
}

/// A regular polygon around the origin; its corners lie on the circle of the given diameter.
pub(crate) fn regular(corners: usize, diameter_mm: f64) -> Vec<Point> {
    let step = TAU / corners as f64;
    (0..corners)
        .map(|corner| {
            let (sin, cos) = (step * (corner as f64 + 0.5)).sin_cos();
            [diameter_mm / 2.0 * cos, diameter_mm / 2.0 * sin]
        })
        .collect()
}

/// Points along an arc, both ends included; it runs clockwise where `to_rad < from_rad`.
pub(crate) fn arc(
    centre: Point,
    radius_mm: f64,
    from_rad: f64,
    to_rad: f64,
    steps: usize,
) -> Vec<Point> {
    let [x, y] = centre;
    (0..=steps)
        .map(|step| {
            let (sin, cos) =
                (from_rad + (to_rad - from_rad) * step as f64 / steps as f64).sin_cos();
            [x + radius_mm * cos, y + radius_mm * sin]
        })
        .collect()
}

/// A smooth curve through the points (Catmull-Rom), `steps` pieces from each to the next.
pub(crate) fn spline(points: &[Point], steps: usize) -> Vec<Point> {
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return Vec::new();
    };
    // The ends are doubled, so that the curve begins and ends in them.
    let controls: Vec<Point> = std::iter::once(first)
        .chain(points)
        .chain(std::iter::once(last))
        .copied()
        .collect();
    let mut curve = Vec::new();
    for window in controls.windows(4) {
        let [p0, p1, p2, p3] = window else { continue };
        for step in 0..steps {
            let t = step as f64 / steps as f64;
            let blend = |a: f64, b: f64, c: f64, d: f64| {
                b + 0.5
                    * t
                    * ((c - a)
                        + t * ((2.0 * a - 5.0 * b + 4.0 * c - d) + t * (3.0 * (b - c) + d - a)))
            };
            curve.push([
                blend(p0[0], p1[0], p2[0], p3[0]),
                blend(p0[1], p1[1], p2[1], p3[1]),
            ]);
        }
    }
    curve.push(*last);
    curve
}

fn twice_area(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn squared_distance(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
}

/// Triangulates a simple polygon by ear clipping: its corners' indices, counter-clockwise. Of the
/// ears the one with the shortest cut goes first, which keeps slivers rare.
pub(crate) fn triangulate(outline: &[Point]) -> Vec<[u32; 3]> {
    let mut remaining: Vec<(u32, Point)> = (0..).zip(outline.iter().copied()).collect();
    let mut triangles = Vec::with_capacity(outline.len());
    while remaining.len() >= 3 {
        let before = remaining.iter().cycle().skip(remaining.len() - 1);
        let after = remaining.iter().cycle().skip(1);
        let is_ear = |a: Point, b: Point, c: Point| {
            twice_area(a, b, c) > 0.0
                && remaining
                    .iter()
                    .map(|(_, p)| *p)
                    .filter(|p| ![a, b, c].contains(p))
                    .all(|p| {
                        twice_area(a, b, p) < 0.0
                            || twice_area(b, c, p) < 0.0
                            || twice_area(c, a, p) < 0.0
                    })
        };
        let best = before
            .zip(&remaining)
            .zip(after)
            .enumerate()
            .filter(|(_, ((a, b), c))| is_ear(a.1, b.1, c.1))
            .min_by(|(_, ((a, _), c)), (_, ((d, _), f))| {
                squared_distance(a.1, c.1).total_cmp(&squared_distance(d.1, f.1))
            })
            .map(|(position, ((a, b), c))| (position, [a.0, b.0, c.0]));
        // Only an outline that crosses itself runs out of ears.
        let Some((position, triangle)) = best else {
            break;
        };
        triangles.push(triangle);
        remaining.remove(position);
    }
    triangles
}
