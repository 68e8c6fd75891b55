//! Hand tools.

use crate::field::{block, cylinder, prism, rod, torus, trunk};
use crate::outline::{Point, arc};
use crate::set::Recipe;
use crate::solid::Solid;
use crate::surfaces::{extrude, lathe};

pub(crate) const RECIPES: &[Recipe] = &[
    ("hammer", 665.0, hammer),
    ("phillips_screwdriver", 97.0, || {
        lathe(PHILLIPS_SCREWDRIVER).lying(0.5)
    }),
    ("flat_screwdriver", 98.0, flat_screwdriver),
    ("wrench", 252.0, wrench),
    ("pliers", 280.0, pliers),
    ("clamp", 202.0, clamp),
    ("tape_measure", 310.0, tape_measure),
    ("padlock", 304.0, padlock),
    ("scissors", 82.0, scissors),
    ("power_drill", 895.0, power_drill),
    ("flashlight", 330.0, || lathe(FLASHLIGHT).lying(0.5)),
];

/// Profiles, `[radius, height]`, handle first.
const PHILLIPS_SCREWDRIVER: &[Point] = &[
    [0.0, 0.0],
    [11.0, 1.0],
    [16.0, 8.0],
    [16.0, 75.0],
    [12.0, 88.0],
    [13.5, 98.0],
    [12.0, 103.0],
    [3.5, 104.0],
    [3.5, 205.0],
    [1.0, 214.0],
    [0.0, 214.5],
];
const FLASHLIGHT: &[Point] = &[
    [0.0, 0.0],
    [17.0, 0.0],
    [19.0, 3.0],
    [19.0, 120.0],
    [21.0, 128.0],
    [28.0, 140.0],
    [28.0, 175.0],
    [25.0, 175.0],
    [24.0, 172.0],
    [0.0, 172.0],
];

/// A claw hammer on its side.
fn hammer() -> Solid {
    let handle = rod([-150.0, 0.0, 14.0], [60.0, 0.0, 14.0], [16.0, 14.5]).blended(
        rod([50.0, 0.0, 14.0], [112.0, 0.0, 14.0], [11.0, 11.0]),
        8.0,
    );
    let eye = block([34.0, 40.0, 29.0], 4.0).at(115.0, 0.0, 13.0);
    let poll = cylinder(14.5, 46.0).about_x(90.0).at(115.0, -12.0, 13.5);
    let claw = prism(
        &[
            [-14.0, 0.0],
            [14.0, 0.0],
            [12.0, 28.0],
            [2.0, 58.0],
            [-4.0, 58.0],
        ],
        24.0,
    )
    .at(117.0, 16.0, 0.0);
    let slot = prism(
        &[[-30.0, 62.0], [-30.0, 24.0], [30.0, 24.0], [30.0, 62.0]],
        5.0,
    )
    .at(117.0, 16.0, 10.0);
    handle
        .blended(eye, 5.0)
        .blended(poll, 3.0)
        .and(claw.without(slot))
        .carved(3.0)
}

/// A slotted screwdriver; its blade is spread flat.
fn flat_screwdriver() -> Solid {
    let grip = rod([-88.0, 0.0, 15.0], [-15.0, 0.0, 15.0], [15.5, 15.0]);
    let neck = rod([-15.0, 0.0, 15.0], [12.0, 0.0, 15.0], [12.0, 10.0]);
    let shaft = rod([0.0, 0.0, 15.0], [108.0, 0.0, 15.0], [3.5, 3.5]);
    let blade = block([14.0, 10.0, 3.0], 0.5).at(110.0, 0.0, 15.0);
    grip.blended(neck, 6.0)
        .and(shaft)
        .blended(blade, 3.0)
        .carved(1.75)
}

/// An open-ended wrench lying flat.
fn wrench() -> Solid {
    let jaw = |degrees: f64| degrees.to_radians();
    let mut outline = vec![[-110.0, -11.0], [55.0, -11.0]];
    // The head's round back, then the mouth cut into it at a slant.
    outline.extend(arc([88.0, 0.0], 30.0, jaw(-155.0), jaw(-12.0), 9));
    outline.extend([[96.0, -14.0], [84.0, -8.0], [84.0, 8.0], [96.0, 14.0]]);
    outline.extend(arc([88.0, 0.0], 30.0, jaw(12.0), jaw(155.0), 9));
    outline.extend([[55.0, 11.0], [-110.0, 11.0]]);
    outline.extend(arc([-110.0, 0.0], 11.0, jaw(110.0), jaw(250.0), 6));
    extrude(&outline, 15.0)
}

/// Pliers, a little open.
fn pliers() -> Solid {
    let handle = rod([2.0, 6.0, 8.5], [-60.0, 26.0, 8.5], [9.0, 9.0])
        .blended(
            rod([-60.0, 26.0, 8.5], [-125.0, 21.0, 8.5], [9.0, 8.5]),
            6.0,
        )
        .mirrored();
    let joint = cylinder(17.0, 17.0).at(5.0, 0.0, 0.0);
    let jaws = prism(&[[10.0, 2.0], [58.0, 1.5], [58.0, 8.0], [14.0, 15.0]], 15.0).mirrored();
    handle.blended(joint, 6.0).and(jaws).carved(2.25)
}

/// A spring clamp lying on its side, jaws closed.
fn clamp() -> Solid {
    let arm = rod([-70.0, 34.0, 11.0], [0.0, 12.0, 11.0], [11.0, 12.0])
        .blended(
            rod([0.0, 12.0, 11.0], [40.0, 22.0, 11.0], [12.0, 10.0]),
            6.0,
        )
        .blended(rod([40.0, 22.0, 11.0], [78.0, 8.0, 11.0], [10.0, 8.0]), 6.0)
        .mirrored();
    let spring = cylinder(17.0, 30.0).at(2.0, 0.0, 0.0);
    arm.and(spring).carved(3.0)
}

fn tape_measure() -> Solid {
    let mut side = vec![[-38.0, 0.0], [38.0, 0.0], [38.0, 30.0]];
    side.extend(arc([2.0, 32.0], 36.0, 0.1, 2.4, 10));
    side.push([-38.0, 34.0]);
    extrude(&side, 42.0).raised()
}

/// A padlock lying flat.
fn padlock() -> Solid {
    let body = block([62.0, 54.0, 29.0], 4.0).at(0.0, 0.0, 13.0);
    let bow = torus(18.0, 5.5).at(0.0, 50.0, 13.0);
    let below_bow = block([80.0, 60.0, 40.0], 0.0).at(0.0, 20.0, 13.0);
    let leg = |x: f64| rod([x, 20.0, 13.0], [x, 50.0, 13.0], [5.5, 5.5]);
    bow.without(below_bow)
        .and(leg(-18.0))
        .and(leg(18.0))
        .blended(body, 2.0)
        .carved(1.75)
}

/// Scissors, closed.
fn scissors() -> Solid {
    let loops = torus(19.0, 5.0).at(-62.0, 25.0, 5.0);
    let shank = rod([-48.0, 13.0, 5.0], [0.0, 0.0, 5.0], [5.5, 6.0]);
    let blades = prism(
        &[
            [-10.0, -8.0],
            [15.0, -11.0],
            [102.0, -1.5],
            [102.0, 1.5],
            [15.0, 11.0],
            [-10.0, 8.0],
        ],
        5.0,
    );
    loops
        .blended(shank, 4.0)
        .mirrored()
        .and(blades)
        .and(cylinder(6.0, 10.0))
        .carved(2.0)
}

/// A cordless drill standing on its battery.
fn power_drill() -> Solid {
    let motor = trunk(29.0, 27.0, 105.0).about_y(90.0).at(-50.0, 0.0, 160.0);
    let chuck = trunk(22.0, 11.0, 42.0).about_y(90.0).at(52.0, 0.0, 160.0);
    let bit = rod([90.0, 0.0, 160.0], [118.0, 0.0, 160.0], [4.0, 4.0]);
    let grip = block([42.0, 36.0, 130.0], 12.0)
        .about_y(8.0)
        .at(-22.0, 0.0, 90.0);
    let trigger = rod([4.0, 0.0, 125.0], [8.0, 0.0, 108.0], [8.0, 8.0]);
    let battery = block([112.0, 74.0, 44.0], 7.0).at(-12.0, 0.0, 19.0);
    motor
        .blended(grip, 10.0)
        .and(chuck)
        .and(bit)
        .and(trigger)
        .blended(battery, 8.0)
        .carved(3.5)
}
