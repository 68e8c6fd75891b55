//! What stands on a laid table, empty, and cutlery.

use crate::field::{Field, block, cylinder, ellipsoid, rod, torus, trunk};
use crate::outline::Point;
use crate::set::Recipe;
use crate::solid::Solid;
use crate::surfaces::lathe;

pub(crate) const RECIPES: &[Recipe] = &[
    ("bowl", 330.0, || lathe(BOWL)),
    ("salad_bowl", 720.0, || lathe(SALAD_BOWL)),
    ("dinner_plate", 560.0, || lathe(DINNER_PLATE)),
    ("tumbler", 240.0, || cup(76.0, 60.0, 112.0, 4.0)),
    ("flower_pot", 460.0, || cup(150.0, 105.0, 135.0, 7.0)),
    ("mug", 330.0, || mug(46.0, 86.0, 5.0, 26.0)),
    ("espresso_cup", 130.0, || mug(31.0, 58.0, 4.5, 17.0)),
    ("pitcher", 260.0, pitcher),
    ("teapot", 640.0, teapot),
    ("frying_pan", 620.0, frying_pan),
    ("fork", 38.0, fork),
    ("spoon", 44.0, spoon),
    ("table_knife", 70.0, table_knife),
    ("spatula", 90.0, spatula),
];

/// Profiles, `[radius, height]`: up along the outside, over the rim, down along the inside.
const BOWL: &[Point] = &[
    [0.0, 0.0],
    [30.0, 0.0],
    [46.0, 6.0],
    [63.0, 20.0],
    [75.0, 42.0],
    [80.0, 56.0],
    [76.5, 56.0],
    [71.0, 43.0],
    [60.0, 23.0],
    [44.0, 10.0],
    [30.0, 5.0],
    [0.0, 5.0],
];
const SALAD_BOWL: &[Point] = &[
    [0.0, 0.0],
    [55.0, 0.0],
    [80.0, 14.0],
    [102.0, 45.0],
    [115.0, 90.0],
    [109.0, 90.0],
    [96.0, 48.0],
    [76.0, 20.0],
    [54.0, 7.0],
    [0.0, 7.0],
];
const DINNER_PLATE: &[Point] = &[
    [0.0, 0.0],
    [80.0, 0.0],
    [92.0, 7.0],
    [125.0, 19.0],
    [129.0, 23.0],
    [124.0, 23.0],
    [91.0, 12.0],
    [79.0, 6.0],
    [0.0, 6.0],
];

/// A cup that widens towards its rim.
fn cup(rim_diameter: f64, foot_diameter: f64, height: f64, wall: f64) -> Solid {
    let (rim, foot) = (rim_diameter / 2.0, foot_diameter / 2.0);
    lathe(&[
        [0.0, 0.0],
        [foot, 0.0],
        [rim, height],
        [rim - wall, height],
        [foot - wall, wall],
        [0.0, wall],
    ])
}

/// How far rims are rounded on their outside.
const EDGE: f64 = 2.0;

/// A straight cup with a ring for a handle.
fn mug(radius: f64, height: f64, wall: f64, handle_radius: f64) -> Solid {
    let handle = torus(handle_radius, 5.5)
        .about_x(90.0)
        .at(radius, 0.0, height * 0.52);
    let hollow = cylinder(radius - wall, height).at(0.0, 0.0, wall);
    let body = cylinder(radius - EDGE, height - EDGE).grown(EDGE);
    body.blended(handle, 5.0).hollowed(hollow, 4.0).carved(2.0)
}

fn pitcher() -> Solid {
    let body = trunk(52.0 - EDGE, 60.0 - EDGE, 225.0 - EDGE).grown(EDGE);
    let hollow = trunk(46.0, 54.0, 225.0).at(0.0, 0.0, 7.0);
    let handle = rod([52.0, 0.0, 195.0], [92.0, 0.0, 195.0], [9.0, 9.0])
        .blended(rod([92.0, 0.0, 195.0], [84.0, 0.0, 70.0], [9.0, 8.0]), 8.0)
        .blended(rod([84.0, 0.0, 70.0], [50.0, 0.0, 50.0], [8.0, 8.0]), 8.0);
    let spout = trunk(6.0, 22.0, 60.0).at(-50.0, 0.0, 165.0);
    let pour = trunk(1.0, 16.0, 60.0).at(-50.0, 0.0, 168.0);
    body.and(spout)
        .blended(handle, 6.0)
        .without(pour)
        .hollowed(hollow, 4.0)
        .carved(3.25)
}

/// A teapot with its lid on.
fn teapot() -> Solid {
    let body = ellipsoid([140.0, 140.0, 118.0]).at(0.0, 0.0, 50.0);
    let lid = ellipsoid([84.0, 84.0, 30.0]).at(0.0, 0.0, 104.0);
    let knob = ellipsoid([20.0, 20.0, 18.0]).at(0.0, 0.0, 125.0);
    let spout = rod([-58.0, 0.0, 45.0], [-112.0, 0.0, 100.0], [17.0, 9.0]);
    let handle = torus(33.0, 7.5).about_x(90.0).at(68.0, 0.0, 58.0);
    body.blended(spout, 12.0)
        .blended(handle, 8.0)
        .and(lid)
        .blended(knob, 5.0)
        .carved(4.0)
}

fn frying_pan() -> Solid {
    let pan = trunk(72.0 - EDGE, 95.0 - EDGE, 42.0 - EDGE)
        .grown(EDGE)
        .at(-55.0, 0.0, 0.0);
    let hollow = trunk(67.0, 90.0, 42.0).at(-55.0, 0.0, 5.0);
    let handle = rod([20.0, 0.0, 30.0], [142.0, 0.0, 46.0], [8.0, 10.0]);
    pan.blended(handle, 6.0).hollowed(hollow, 4.0).carved(2.75)
}

/// A flat bar from one point to another in the plane y = 0.
fn bar(from: [f64; 2], to: [f64; 2], width: f64, thickness: f64) -> Field {
    let [rise, run] = [to[1] - from[1], to[0] - from[0]];
    let length = rise.hypot(run) + thickness;
    block([length, width, thickness], thickness * 0.4)
        .about_y(-rise.atan2(run).to_degrees())
        .at((from[0] + to[0]) / 2.0, 0.0, (from[1] + to[1]) / 2.0)
}

/// Handle and raised neck of fork and spoon; the neck ends at x = 40, 12 mm up.
fn cutlery_handle() -> Field {
    bar([-100.0, 2.0], [-30.0, 4.0], 18.0, 4.5)
        .blended(bar([-35.0, 4.0], [10.0, 12.0], 11.0, 4.5), 6.0)
        .blended(bar([10.0, 12.0], [40.0, 12.0], 9.0, 4.5), 6.0)
}

fn fork() -> Solid {
    let palm = bar([38.0, 12.0], [62.0, 2.5], 26.0, 4.0);
    let tine = |y: f64| bar([60.0, 2.5], [102.0, 2.5], 4.2, 4.0).at(0.0, y, 0.0);
    let tines = tine(3.65).and(tine(10.9)).mirrored();
    cutlery_handle()
        .blended(palm, 6.0)
        .blended(tines, 2.0)
        .carved(1.25)
}

fn spoon() -> Solid {
    let bowl = ellipsoid([64.0, 44.0, 28.0]);
    let hollow =
        ellipsoid([58.0, 38.0, 22.0]).and(block([80.0, 60.0, 20.0], 0.0).at(0.0, 0.0, 11.0));
    cutlery_handle()
        .blended(bowl.at(68.0, 0.0, 13.0), 3.0)
        .without(hollow.at(68.0, 0.0, 13.5))
        .carved(1.4)
}

fn table_knife() -> Solid {
    let handle = bar([-105.0, 4.0], [-5.0, 4.0], 19.0, 10.0);
    let blade = bar([-10.0, 2.0], [100.0, 2.0], 20.0, 3.6)
        .blended(ellipsoid([40.0, 20.0, 4.0]).at(100.0, 0.0, 2.0), 2.0);
    handle.blended(blade, 4.0).carved(1.5)
}

fn spatula() -> Solid {
    let handle = rod([-135.0, 0.0, 10.0], [-20.0, 0.0, 8.0], [10.0, 8.0]);
    let neck = bar([-25.0, 7.0], [70.0, 3.0], 11.0, 6.0);
    let slots = [-18.0, 0.0, 18.0].map(|y| block([50.0, 7.0, 40.0], 2.0).at(104.0, y, 0.0));
    let head = block([80.0, 76.0, 4.0], 1.5).at(102.0, 0.0, 2.0);
    let slotted = slots.into_iter().fold(head, Field::without);
    handle.blended(neck, 4.0).blended(slotted, 3.0).carved(2.0)
}
