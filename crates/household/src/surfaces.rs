//! Solids from sections: revolved, lofted, extruded, swept. All lengths in millimetres.

use std::f64::consts::{PI, TAU};

use nalgebra::{Point3, Rotation3, Unit, Vector3};

use super::outline::{Point, triangulate};
use super::solid::Solid;

/// Sides of everything round. Divisible by four, so that a facet looks in each of +-x and +-y, and
/// what lies on its side lies on a facet.
const ROUND: usize = 32;

/// Rings of a superellipsoid, pole to pole.
const LATITUDES: usize = 16;

/// Stretches a surface over rings of equally many points each, which run counter-clockwise seen
/// against the direction in which they are stacked. `ends` are the points, below the first ring and
/// above the last, to which fans close the surface; without them the last ring continues in the
/// first.
fn skin(rings: &[Vec<Point3<f64>>], ends: Option<[Point3<f64>; 2]>) -> Solid {
    let sides = rings.first().map_or(0, Vec::len) as u32;
    let count = rings.len() as u32;
    let mut solid = Solid {
        vertices_mm: rings.iter().flatten().copied().collect(),
        triangles: Vec::new(),
    };
    let last_ring = count.saturating_sub(1);
    let spans = if ends.is_some() { last_ring } else { count };
    for lower in 0..spans {
        let upper = (lower + 1) % count;
        for side in 0..sides {
            let next = (side + 1) % sides;
            let [a, b] = [lower * sides + side, lower * sides + next];
            let [d, c] = [upper * sides + side, upper * sides + next];
            solid.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    if let Some(ends) = ends {
        let (low, last) = (sides * count, sides * last_ring);
        solid.vertices_mm.extend(ends);
        for side in 0..sides {
            let next = (side + 1) % sides;
            solid
                .triangles
                .extend([[low, next, side], [low + 1, last + side, last + next]]);
        }
    }
    solid
}

/// A circle's or superellipse's points, for radius 1. Exponent 2 is a circle; 4 a rounded square;
/// from 8 on the sides are all but straight.
fn unit_ring(sides: usize, exponent: f64) -> impl Iterator<Item = Point> {
    (0..sides).map(move |side| {
        let (sin, cos) = (TAU * (side as f64 + 0.5) / sides as f64).sin_cos();
        let stretch = |value: f64| value.abs().powf(2.0 / exponent).copysign(value);
        [stretch(cos), stretch(sin)]
    })
}

/// [`skin`] with ends on the z axis.
fn upright(rings: &[Vec<Point3<f64>>], bottom: f64, top: f64) -> Solid {
    skin(rings, Some([bottom, top].map(|z| Point3::new(0.0, 0.0, z))))
}

fn level_ring(sides: usize, exponent: f64, half: Point, height: f64) -> Vec<Point3<f64>> {
    let [half_x, half_y] = half;
    unit_ring(sides, exponent)
        .map(|[x, y]| Point3::new(x * half_x, y * half_y, height))
        .collect()
}

/// Revolves a profile of `[radius, height]` about the z axis. It begins and ends on the axis and
/// has the material on its left: up along the outside, for a hollow body down again along the
/// inside.
pub(crate) fn lathe(profile: &[Point]) -> Solid {
    lathe_with_sides(profile, ROUND)
}

/// [`lathe`] with a chosen number of sides: 6 makes a hexagonal jar.
pub(crate) fn lathe_with_sides(profile: &[Point], sides: usize) -> Solid {
    let [[_, bottom], between @ .., [_, top]] = profile else {
        return Solid::default();
    };
    upright(&circles(between, sides), *bottom, *top)
}

fn circles(profile: &[Point], sides: usize) -> Vec<Vec<Point3<f64>>> {
    let circle = |&[radius, z]: &Point| level_ring(sides, 2.0, [radius; 2], z);
    profile.iter().map(circle).collect()
}

/// Revolves a closed profile of `[radius, height]`, counter-clockwise and clear of the axis: a
/// ring.
pub(crate) fn lathe_ring(profile: &[Point]) -> Solid {
    skin(&circles(profile, ROUND), None)
}

/// A horizontal cut through a lofted body, centred on the z axis: its height above the ground, its
/// sizes along x and y, and the superellipse's exponent: 2 is an ellipse, 8 almost a rectangle.
pub(crate) type Section = [f64; 4];

/// Stretches a body over sections from the bottom up; flat at both ends.
pub(crate) fn loft(sections: &[Section]) -> Solid {
    let (Some([bottom, ..]), Some([top, ..])) = (sections.first(), sections.last()) else {
        return Solid::default();
    };
    let ring = |&[z, width, depth, exponent]: &Section| {
        level_ring(ROUND, exponent, [width / 2.0, depth / 2.0], z)
    };
    let rings: Vec<_> = sections.iter().map(ring).collect();
    upright(&rings, *bottom, *top)
}

/// A prism: the outline at z = 0, extruded to the height.
pub(crate) fn extrude(outline: &[Point], height_mm: f64) -> Solid {
    let sides = outline.len() as u32;
    let level = |z: f64| outline.iter().map(move |&[x, y]| Point3::new(x, y, z));
    let caps = triangulate(outline);
    let walls = (0..sides).flat_map(|a| {
        let b = (a + 1) % sides;
        [[a, b, b + sides], [a, b + sides, a + sides]]
    });
    let bottom = caps.iter().map(|&[a, b, c]| [c, b, a]);
    let top = caps.iter().map(|cap| cap.map(|corner| corner + sides));
    Solid {
        vertices_mm: level(0.0).chain(level(height_mm)).collect(),
        triangles: walls.chain(bottom).chain(top).collect(),
    }
}

/// A round body along a path: each station a point and the radius there. Frames follow the path
/// without twisting (parallel transport). Its ends are flat.
pub(crate) fn sweep(stations: &[(Point3<f64>, f64)]) -> Solid {
    let (Some(first), Some(last)) = (stations.first(), stations.last()) else {
        return Solid::default();
    };
    let before = std::iter::once(first).chain(stations);
    let after = stations.iter().skip(1).chain(std::iter::once(last));
    let mut direction = Vector3::z();
    let (mut across, mut up) = (Vector3::x(), Vector3::y());
    let rings: Vec<Vec<_>> = before
        .zip(stations)
        .zip(after)
        .map(|((behind, (centre, radius)), ahead)| {
            let heading = Unit::new_normalize(ahead.0 - behind.0).into_inner();
            // A path that turns straight back has no shortest turn; such paths are not swept.
            let turn = Rotation3::rotation_between(&direction, &heading)
                .unwrap_or_else(Rotation3::identity);
            (direction, across, up) = (heading, turn * across, turn * up);
            unit_ring(ROUND, 2.0)
                .map(|[x, y]| centre + (across * x + up * y) * *radius)
                .collect()
        })
        .collect();
    skin(&rings, Some([first.0, last.0]))
}

/// A body between ball and brick. `vertical` is the exponent of its upright sections, `horizontal`
/// that of its level ones: 2 and 2 make an ellipsoid, 6 and 6 a brick with soft edges.
pub(crate) fn superellipsoid(size_mm: [f64; 3], vertical: f64, horizontal: f64) -> Solid {
    let [half_x, half_y, half_z] = size_mm.map(|edge| edge / 2.0);
    let rings: Vec<_> = (0..LATITUDES)
        .map(|ring| {
            let (sin, cos) = (PI * ((ring as f64 + 0.5) / LATITUDES as f64 - 0.5)).sin_cos();
            let reach = cos.powf(2.0 / vertical);
            let height = sin.abs().powf(2.0 / vertical).copysign(sin) * half_z;
            level_ring(ROUND, horizontal, [half_x * reach, half_y * reach], height)
        })
        .collect();
    upright(&rings, -half_z, half_z)
}
