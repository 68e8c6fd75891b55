//! What else lies about the house.

use crate::field::{block, cylinder, ellipsoid, rod};
use crate::outline::{Point, rounded_rectangle, spline};
use crate::set::Recipe;
use crate::solid::Solid;
use crate::surfaces::{extrude, lathe, lathe_ring, loft, superellipsoid};

pub(crate) const RECIPES: &[Recipe] = &[
    ("large_marker", 18.0, || lathe(MARKER).lying(0.3)),
    ("tape_roll", 140.0, || ring(105.0, 76.0, 48.0)),
    ("toilet_roll", 110.0, || ring(112.0, 42.0, 98.0)),
    ("scrubbing_brush", 120.0, scrubbing_brush),
    ("remote_control", 150.0, remote_control),
    ("candle", 390.0, || lathe(CANDLE)),
    ("light_bulb", 45.0, || {
        lathe(&spline(LIGHT_BULB, 3)).lying(0.5)
    }),
    ("phone", 195.0, || {
        extrude(&rounded_rectangle(74.0, 152.0, 11.0), 10.0)
    }),
    ("glasses_case", 120.0, || {
        superellipsoid([165.0, 68.0, 52.0], 2.6, 3.2).pressed(1.0)
    }),
    ("toothpaste_tube", 130.0, toothpaste_tube),
    ("sponge", 22.0, || soft_brick([112.0, 75.0, 42.0])),
    ("soap_bar", 125.0, || soft_brick([92.0, 60.0, 32.0])),
    ("game_controller", 240.0, game_controller),
    ("alarm_clock", 230.0, alarm_clock),
];

/// Profiles, `[radius, height]`.
const MARKER: &[Point] = &[
    [0.0, 0.0],
    [8.0, 0.0],
    [9.0, 1.5],
    [9.0, 78.0],
    [10.0, 79.0],
    [10.0, 112.0],
    [8.0, 121.0],
    [0.0, 122.0],
];
const CANDLE: &[Point] = &[
    [0.0, 0.0],
    [36.0, 0.0],
    [37.5, 1.5],
    [37.5, 98.0],
    [35.0, 100.0],
    [22.0, 97.0],
    [1.5, 95.0],
    [1.2, 106.0],
    [0.0, 106.0],
];
/// Control points, screw base first.
const LIGHT_BULB: &[Point] = &[
    [0.0, 0.0],
    [8.0, 1.0],
    [13.0, 6.0],
    [13.5, 24.0],
    [14.5, 30.0],
    [22.0, 48.0],
    [30.0, 70.0],
    [29.0, 88.0],
    [18.0, 103.0],
    [7.0, 108.5],
    [0.0, 109.5],
];

/// A roll with a hole through it, standing on its end.
fn ring(outer_diameter: f64, inner_diameter: f64, height: f64) -> Solid {
    let (outer, inner) = (outer_diameter / 2.0, inner_diameter / 2.0);
    lathe_ring(&[[inner, 0.0], [outer, 0.0], [outer, height], [inner, height]])
}

fn soft_brick(size: [f64; 3]) -> Solid {
    superellipsoid(size, 7.0, 7.0).pressed(0.5)
}

fn remote_control() -> Solid {
    loft(&[
        [0.0, 18.0, 42.0, 4.0],
        [4.0, 24.0, 50.0, 4.0],
        [60.0, 22.0, 48.0, 4.0],
        [120.0, 24.0, 50.0, 4.0],
        [178.0, 28.0, 54.0, 4.0],
        [186.0, 22.0, 46.0, 4.0],
    ])
    .lying(0.5)
}

/// A full tube: round at the cap, a flat seam at the other end, lying down.
fn toothpaste_tube() -> Solid {
    loft(&[
        [0.0, 2.0, 60.0, 3.0],
        [10.0, 4.0, 60.0, 3.0],
        [60.0, 24.0, 54.0, 2.4],
        [110.0, 35.0, 47.0, 2.1],
        [142.0, 40.0, 42.0, 2.0],
        [148.0, 30.0, 30.0, 2.0],
        [150.0, 29.0, 29.0, 2.0],
        [172.0, 25.0, 25.0, 2.0],
    ])
    .lying(0.5)
}

/// A brush that stands on its bristles.
fn scrubbing_brush() -> Solid {
    let bristles = block([150.0, 52.0, 34.0], 3.0).at(0.0, 0.0, 15.0);
    let back = ellipsoid([186.0, 66.0, 44.0])
        .at(0.0, 0.0, 36.0)
        .without(block([200.0, 80.0, 30.0], 0.0).at(0.0, 0.0, 13.0));
    let grip = rod([-45.0, 0.0, 66.0], [45.0, 0.0, 66.0], [11.0, 11.0])
        .and(rod([-45.0, 0.0, 66.0], [-60.0, 0.0, 45.0], [11.0, 12.0]))
        .and(rod([45.0, 0.0, 66.0], [60.0, 0.0, 45.0], [11.0, 12.0]));
    bristles.and(back).blended(grip, 6.0).carved(3.5)
}

fn game_controller() -> Solid {
    let shell = block([140.0, 66.0, 36.0], 14.0).at(0.0, 14.0, 17.0);
    let grips = [-1.0, 1.0].map(|side| {
        rod(
            [side * 50.0, 10.0, 18.0],
            [side * 66.0, -46.0, 16.0],
            [22.0, 17.0],
        )
    });
    let sticks = [-1.0, 1.0].map(|side| cylinder(9.0, 18.0).at(side * 24.0, 4.0, 28.0));
    let held = grips
        .into_iter()
        .fold(shell, |body, grip| body.blended(grip, 12.0));
    sticks
        .into_iter()
        .fold(held, |body, stick| body.and(stick))
        .carved(3.0)
}

/// A round clock on two feet, with a bell on top.
fn alarm_clock() -> Solid {
    let case = cylinder(48.0, 46.0).about_x(90.0).at(0.0, 23.0, 56.0);
    let dial = cylinder(42.0, 8.0).about_x(90.0).at(0.0, -19.0, 56.0);
    let foot = |x: f64| rod([x * 0.6, 0.0, 24.0], [x, 0.0, 6.0], [9.0, 8.0]);
    let feet = foot(-40.0).and(foot(40.0));
    let stand = block([92.0, 46.0, 12.0], 3.0).at(0.0, 0.0, 5.0);
    let bell = ellipsoid([46.0, 36.0, 30.0]).at(0.0, 0.0, 106.0);
    case.without(dial)
        .and(feet)
        .and(stand)
        .blended(bell, 4.0)
        .carved(3.0)
}
