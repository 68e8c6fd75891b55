//! Conservative rasterisation against each triangle's extremes over each square, by brute force.

use std::collections::{HashMap, HashSet};

use nalgebra::{Isometry3, Point2, Point3, Vector2, Vector3};
use ppnpack_packing::scene::model::mesh::Mesh;
use ppnpack_packing::scene::model::raster::{Raster, SLACK_M, raise_surface, rasterise};

use crate::support::*;

fn raster(n: usize, pitch_m: f64) -> Raster {
    Raster {
        origin: Point2::origin(),
        pitch_m,
        nx: n,
        ny: n,
    }
}

fn touched(triangle: &[Point3<f64>; 3], raster: &Raster) -> HashMap<(usize, usize), (f64, f64)> {
    let mut squares = HashMap::new();
    rasterise(triangle, raster, |x, y, lowest, highest| {
        let before = squares.insert((x, y), (lowest, highest));
        assert!(before.is_none(), "square ({x}, {y}) came twice");
    });
    squares
}

fn triangles(range: f64) -> impl Strategy<Value = [Point3<f64>; 3]> {
    prop::array::uniform3(prop::array::uniform3(-range..range))
        .prop_map(|corners| corners.map(|[x, y, z]| Point3::new(x + 0.05, y + 0.05, z)))
}

/// The range of z of a triangle over a rectangle, where it meets it, from every possible extreme.
fn range_over(
    triangle: &[Point3<f64>; 3],
    low: Point2<f64>,
    high: Point2<f64>,
) -> Option<(f64, f64)> {
    let within =
        |at: &Point3<f64>| (low.x..=high.x).contains(&at.x) && (low.y..=high.y).contains(&at.y);
    let corners = triangle.iter().filter(|at| within(at));
    let mut heights: Vec<f64> = corners.map(|at| at.z).collect();
    let [a, b, c] = *triangle;
    for (from, to) in [(a, b), (b, c), (c, a)] {
        for (axis, line) in [(0, low.x), (0, high.x), (1, low.y), (1, high.y)] {
            let share = (line - from[axis]) / (to[axis] - from[axis]);
            if (0.0..=1.0).contains(&share) {
                let mut crossing = from + (to - from) * share;
                crossing[axis] = line;
                heights.extend(within(&crossing).then_some(crossing.z));
            }
        }
    }
    let cross = |a: Point3<f64>, b: Point3<f64>, c: Point2<f64>| {
        (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
    };
    let whole = cross(a, b, c.xy());
    for corner in [
        low,
        high,
        Point2::new(low.x, high.y),
        Point2::new(high.x, low.y),
    ] {
        let shares = [(b, c), (c, a), (a, b)].map(|(from, to)| cross(from, to, corner) / whole);
        if shares.iter().all(|share| *share >= 0.0) {
            heights.push(shares[0] * a.z + shares[1] * b.z + shares[2] * c.z);
        }
    }
    let lowest = heights.iter().copied().reduce(f64::min)?;
    let highest = heights.iter().copied().reduce(f64::max)?;
    Some((lowest, highest))
}

#[test]
fn what_only_meets_a_border_touches_nothing_and_rounding_adds_no_squares() {
    let wall = [[0.03, 0.0, 0.0], [0.03, 0.05, 0.0], [0.03, 0.0, 0.1]].map(Point3::from);
    assert!(touched(&wall, &raster(8, 0.01)).is_empty());
    let inside = wall.map(|corner| corner + Vector3::new(0.005, 0.0, 0.0));
    assert_eq!(touched(&inside, &raster(8, 0.01)).len(), 5);
    for noise in [-1e-9, 0.0, 1e-10, 5e-7] {
        let mesh = Mesh::cuboid([0.01, 0.02, 0.0], [0.04 + noise, 0.05, 0.04]);
        let squares = mesh
            .corners()
            .flat_map(|triangle| touched(&triangle, &raster(16, 0.01)));
        let squares: HashSet<(usize, usize)> = squares.map(|(square, _)| square).collect();
        assert_eq!(squares.len(), 9, "noise {noise}");
    }
    let bad = [
        [f64::NAN, 0.0, 0.0],
        [f64::INFINITY, 0.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    assert!(touched(&bad.map(Point3::from), &raster(4, 0.01)).is_empty());
}

#[test]
fn a_surface_takes_the_upper_envelope_of_what_is_above_it() {
    let mut surface = Surface::empty(&grid_of([10, 10], 0.01, 50, 4));
    let mesh = Mesh::cuboid([0.0; 3], [0.02, 0.02, 0.03]);
    // Half beside the container, and half below its floor; then wholly below it.
    for (x_m, z_m) in [(-0.01, -0.01), (0.05, -0.5)] {
        raise_surface(&mesh, &Isometry3::translation(x_m, 0.05, z_m), &mut surface);
    }
    let raised = surface.heights_m().iter().filter(|height| **height > 0.0);
    assert_eq!(raised.count(), 4 * 8);
    assert!((surface.heights_m()[20] - 0.02).abs() < 1e-7);
}

proptest! {
    #[test]
    fn the_range_is_that_of_the_triangle_over_the_square(triangle in triangles(0.08)) {
        let squares = touched(&triangle, &raster(10, 0.01));
        for (x, y) in (0..10).flat_map(|x| (0..10).map(move |y| (x, y))) {
            let low = Point2::new(x as f64, y as f64) * 0.01;
            // The slack is left to either side of the true border.
            let grown = |by: f64| {
                let by = Vector2::new(by, by);
                range_over(&triangle, low - by, low + Vector2::new(0.01, 0.01) + by)
            };
            let (inner, outer) = (grown(-1.1 * SLACK_M), grown(1.1 * SLACK_M));
            match squares.get(&(x, y)) {
                None => prop_assert!(inner.is_none(), "({x}, {y}) is touched, but was not visited"),
                Some((lowest, highest)) => {
                    prop_assert!(outer.is_some(), "({x}, {y}) was visited, but is not touched");
                    let (outer_lowest, outer_highest) = outer.unwrap();
                    prop_assert!(*lowest >= outer_lowest - 1e-9);
                    prop_assert!(*highest <= outer_highest + 1e-9);
                    if let Some((inner_lowest, inner_highest)) = inner {
                        prop_assert!(*lowest <= inner_lowest + 1e-9);
                        prop_assert!(*highest >= inner_highest - 1e-9);
                    }
                }
            }
        }
    }

    #[test]
    fn a_surface_is_that_of_all_triangles_whichever_way_they_face(
        triangles in prop::collection::vec(triangles(0.12), 1..40),
    ) {
        let grid = Grid::reference();
        let mut surface = Surface::empty(&grid);
        let mut expected = surface.clone();
        let raster = raster(surface.nx(), surface.pitch_m());
        for triangle in &triangles {
            rasterise(triangle, &raster, |x, y, _, highest| {
                expected.raise(x, y, highest.max(0.0) as f32);
            });
        }
        let indices = 0..triangles.len() as u32;
        let mesh = Mesh {
            vertices: triangles.concat(),
            triangles: indices.map(|number| [0, 1, 2].map(|corner| 3 * number + corner)).collect(),
        };
        raise_surface(&mesh, &Isometry3::identity(), &mut surface);
        prop_assert_eq!(&surface, &expected);
    }
}
