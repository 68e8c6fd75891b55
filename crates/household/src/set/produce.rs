//! Fruit and vegetables.

use nalgebra::Point3;

use crate::outline::{Point, spline};
use crate::set::Recipe;
use crate::solid::Solid;
use crate::surfaces::{lathe, superellipsoid, sweep};

/// How far ripe fruit gives way where it rests, in millimetres.
const GIVE: f64 = 1.0;

pub(crate) const RECIPES: &[Recipe] = &[
    ("apple", 220.0, || revolved(APPLE).pressed(GIVE)),
    ("orange", 245.0, || {
        superellipsoid([80.0, 80.0, 77.0], 2.0, 2.0).pressed(GIVE)
    }),
    ("pear", 250.0, || revolved(PEAR).lying(GIVE)),
    ("lemon", 115.0, || revolved(LEMON).lying(GIVE)),
    ("strawberry", 25.0, || revolved(STRAWBERRY).lying(GIVE)),
    ("plum", 80.0, || {
        superellipsoid([60.0, 51.0, 49.0], 2.0, 2.0).pressed(GIVE)
    }),
    ("avocado", 240.0, || revolved(AVOCADO).lying(GIVE)),
    ("potato", 330.0, || {
        superellipsoid([112.0, 76.0, 64.0], 2.3, 2.2).pressed(GIVE)
    }),
    ("banana", 175.0, banana),
];

/// Control points of outer profiles, `[radius, height]`, from the bottom to the top.
const APPLE: &[Point] = &[
    [0.0, 6.0],
    [8.0, 2.5],
    [18.0, 0.5],
    [30.0, 12.0],
    [38.5, 34.0],
    [38.0, 50.0],
    [28.0, 66.0],
    [15.0, 70.0],
    [6.0, 65.0],
    [0.0, 60.0],
];
const PEAR: &[Point] = &[
    [0.0, 3.0],
    [12.0, 0.0],
    [28.0, 10.0],
    [36.0, 32.0],
    [31.0, 55.0],
    [20.0, 78.0],
    [15.0, 92.0],
    [9.0, 101.0],
    [2.5, 103.0],
    [2.0, 116.0],
    [0.0, 116.5],
];
const LEMON: &[Point] = &[
    [0.0, 0.0],
    [5.0, 2.0],
    [12.0, 8.0],
    [23.0, 20.0],
    [27.5, 38.0],
    [23.0, 56.0],
    [12.0, 68.0],
    [7.0, 74.0],
    [0.0, 77.0],
];
const STRAWBERRY: &[Point] = &[
    [0.0, 0.0],
    [6.0, 3.0],
    [14.0, 15.0],
    [20.0, 32.0],
    [19.0, 41.0],
    [10.0, 46.0],
    [0.0, 45.0],
];
const AVOCADO: &[Point] = &[
    [0.0, 0.0],
    [15.0, 4.0],
    [29.0, 20.0],
    [34.0, 40.0],
    [28.0, 66.0],
    [18.0, 90.0],
    [9.0, 100.0],
    [0.0, 103.0],
];

fn revolved(controls: &[Point]) -> Solid {
    lathe(&spline(controls, 3))
}

/// A bent body that tapers to the stalk and the tip, lying on its side.
fn banana() -> Solid {
    let bend_radius = 105.0;
    let radii = [
        4.0, 5.0, 6.0, 11.0, 16.0, 18.5, 19.5, 20.0, 19.5, 18.0, 15.5, 10.5, 5.0, 4.0,
    ];
    let steps = (radii.len() - 1) as f64;
    let stations = radii.iter().enumerate().map(|(step, &radius)| {
        let (sin, cos) = (105.0_f64.to_radians() * (step as f64 / steps - 0.5)).sin_cos();
        (
            Point3::new(bend_radius * sin, bend_radius * cos, 0.0),
            radius,
        )
    });
    sweep(&stations.collect::<Vec<_>>()).pressed(2.0 * GIVE)
}
