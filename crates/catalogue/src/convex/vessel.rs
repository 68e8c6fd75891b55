//! Bowls, cups and tubes: a floor, and sectors of the wall around an axis.
//!
//! V-HACD cuts along the axes only, which leaves much of a round vessel's inside filled.

use std::f64::consts::TAU;

use nalgebra::{Point3, Vector3};

use super::merge::MAX_PIECES;
use crate::hull::hull;
use crate::mesh::Mesh;

/// How much of a vessel's height its floor may take. Without one, it is a tube.
const FLOOR_SHARES: [f64; 6] = [0.0, 0.04, 0.08, 0.15, 0.25, 0.4];

/// The hulls of a floor and of wall sectors that together have the least volume over the axes, ends
/// and heights of the floor that are tried; `None` where none has more than `least_m3`, the mesh's
/// own volume, and less than `most_m3`.
///
/// Hulls of less volume than the mesh would leave a solid's inside empty.
pub(super) fn vessel(mesh: &Mesh, least_m3: f64, most_m3: f64) -> Option<Vec<Mesh>> {
    let bounds = mesh.bounds()?;
    let centre = nalgebra::center(&bounds.lowest, &bounds.highest);
    let mut best = None;
    let mut best_m3 = most_m3;
    for axis in [Vector3::z(), Vector3::x(), Vector3::y()] {
        let height_m = axis.dot(&bounds.extents_m());
        for up in [axis, -axis] {
            let bottom = up.dot(&centre.coords) - height_m / 2.0;
            for share in FLOOR_SHARES {
                let floor = bottom + share * height_m;
                if let Some((hulls, total_m3)) =
                    cut(mesh, &centre, &up, floor, share > 0.0, best_m3)
                    && total_m3 >= least_m3
                {
                    best = Some(hulls);
                    best_m3 = total_m3;
                }
            }
        }
    }
    best
}

/// The hulls of a cut at the height `floor` along `up`, and their volume; `None` where that is not
/// below `limit_m3`.
fn cut(
    mesh: &Mesh,
    centre: &Point3<f64>,
    up: &Vector3<f64>,
    floor: f64,
    has_floor: bool,
    limit_m3: f64,
) -> Option<(Vec<Mesh>, f64)> {
    let mut hulls = Vec::with_capacity(MAX_PIECES);
    let mut total_m3 = 0.0;
    let mut add = |planes: &[(Vector3<f64>, f64)]| {
        if let Some(part) = hull(&surface_within(mesh, planes)) {
            total_m3 += part.signed_volume_m3();
            hulls.push(part);
        }
        // The later parts need not be made once those so far have too much.
        (total_m3 < limit_m3).then_some(())
    };
    if has_floor {
        add(&[(-up, -floor)])?;
    }
    let sectors = if has_floor {
        MAX_PIECES - 1
    } else {
        MAX_PIECES
    };
    let across = Vector3::new(up.y.abs(), up.z.abs(), up.x.abs());
    let sideways = up.cross(&across);
    let border = |sector: usize| {
        let (sin, cos) = (TAU * sector as f64 / sectors as f64).sin_cos();
        // The normal of the half plane that starts at this angle, towards greater angles.
        sideways * cos - across * sin
    };
    for sector in 0..sectors {
        let (from, to) = (border(sector), -border(sector + 1));
        add(&[
            (*up, floor),
            (from, from.dot(&centre.coords)),
            (to, to.dot(&centre.coords)),
        ])?;
    }
    Some((hulls, total_m3))
}

/// The corners of a mesh's triangles clipped to where each plane's `normal . p >= offset`.
fn surface_within(mesh: &Mesh, planes: &[(Vector3<f64>, f64)]) -> Vec<Point3<f64>> {
    let mut points = Vec::new();
    let (mut polygon, mut clipped) = (Vec::new(), Vec::new());
    for corners in mesh.corners() {
        polygon.clear();
        polygon.extend_from_slice(&corners);
        for (normal, offset) in planes {
            let height = |point: &Point3<f64>| normal.dot(&point.coords) - offset;
            clipped.clear();
            let before = polygon.iter().cycle().skip(polygon.len().saturating_sub(1));
            for (before, point) in before.zip(&polygon) {
                let (low, high) = (height(before), height(point));
                if (low < 0.0) != (high < 0.0) {
                    clipped.push(before + (point - before) * (low / (low - high)));
                }
                if high >= 0.0 {
                    clipped.push(*point);
                }
            }
            std::mem::swap(&mut polygon, &mut clipped);
        }
        points.extend_from_slice(&polygon);
    }
    points
}
