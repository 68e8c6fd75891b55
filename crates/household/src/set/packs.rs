//! What food and drink come in: cans, jars, bottles, bags.

use crate::field::{block, cylinder, rod, trunk};
use crate::outline::{Point, rounded_rectangle, spline};
use crate::set::Recipe;
use crate::solid::Solid;
use crate::surfaces::{extrude, lathe, lathe_with_sides, loft};

pub(crate) const RECIPES: &[Recipe] = &[
    ("tomato_soup_can", 349.0, || can(66.0, 101.0)),
    ("coffee_can", 414.0, || can(102.0, 139.0)),
    ("tuna_can", 205.0, || can(85.0, 38.0)),
    ("crisps_tube", 205.0, || can(75.0, 235.0)),
    ("soda_can", 350.0, || lathe(SODA_CAN)),
    ("spray_paint_can", 390.0, || lathe(SPRAY_CAN)),
    ("potted_meat_can", 370.0, || tin(97.0, 52.0, 82.0, 14.0)),
    ("sardine_tin", 125.0, || tin(108.0, 62.0, 26.0, 16.0)),
    ("jam_jar", 590.0, || jar(78.0, 92.0, 66.0)),
    ("honey_jar", 680.0, || {
        lathe_with_sides(&jar_profile(92.0, 105.0, 66.0), 6)
    }),
    ("spice_jar", 130.0, || jar(50.0, 105.0, 44.0)),
    ("water_bottle", 520.0, || lathe(WATER_BOTTLE)),
    ("beer_bottle", 620.0, || lathe(BEER_BOTTLE).lying(0.5)),
    ("vitamin_bottle", 180.0, || lathe(VITAMIN_BOTTLE)),
    ("mustard_bottle", 603.0, mustard_bottle),
    ("bleach_bottle", 1131.0, bleach_bottle),
    ("shampoo_bottle", 470.0, shampoo_bottle),
    ("glue_bottle", 225.0, glue_bottle),
    ("spray_bottle", 640.0, spray_bottle),
    ("hand_soap_pump", 420.0, hand_soap_pump),
    ("crisps_bag", 175.0, || pillow_bag(170.0, 240.0, 75.0)),
    ("rice_bag", 1005.0, || pillow_bag(130.0, 215.0, 62.0)),
    ("coffee_bag", 520.0, coffee_bag),
];

/// Outer profiles, `[radius, height]` from the bottom to the top.
const SODA_CAN: &[Point] = &[
    [0.0, 6.0],
    [22.0, 3.0],
    [25.0, 0.0],
    [27.0, 0.0],
    [33.0, 8.0],
    [33.0, 108.0],
    [27.0, 119.0],
    [27.0, 122.0],
    [25.0, 122.0],
    [24.0, 118.0],
    [0.0, 118.0],
];
const SPRAY_CAN: &[Point] = &[
    [0.0, 4.0],
    [28.0, 0.0],
    [32.5, 0.0],
    [32.5, 148.0],
    [27.0, 158.0],
    [26.0, 160.0],
    [26.0, 193.0],
    [24.0, 196.0],
    [0.0, 197.0],
];
const WATER_BOTTLE: &[Point] = &[
    [0.0, 4.0],
    [22.0, 0.0],
    [28.0, 0.0],
    [32.5, 6.0],
    [32.5, 70.0],
    [29.5, 80.0],
    [29.5, 100.0],
    [32.5, 110.0],
    [32.5, 140.0],
    [27.0, 165.0],
    [16.0, 183.0],
    [13.0, 188.0],
    [15.0, 189.0],
    [15.0, 206.0],
    [0.0, 206.0],
];
const BEER_BOTTLE: &[Point] = &[
    [0.0, 5.0],
    [26.0, 0.0],
    [30.5, 4.0],
    [30.5, 120.0],
    [28.0, 134.0],
    [19.0, 160.0],
    [14.5, 180.0],
    [13.0, 215.0],
    [13.5, 222.0],
    [13.5, 228.0],
    [0.0, 229.0],
];
const VITAMIN_BOTTLE: &[Point] = &[
    [0.0, 0.0],
    [30.0, 0.0],
    [32.0, 2.0],
    [32.0, 78.0],
    [28.0, 86.0],
    [22.0, 88.0],
    [25.0, 89.0],
    [25.0, 109.0],
    [0.0, 109.0],
];

/// A food can; lid and bottom sit inside their rims.
fn can(diameter: f64, height: f64) -> Solid {
    let radius = diameter / 2.0;
    let (rim, recess) = (2.0, 3.0);
    lathe(&[
        [0.0, recess],
        [radius - rim, recess],
        [radius - rim, 0.0],
        [radius, 0.0],
        [radius, height],
        [radius - rim, height],
        [radius - rim, height - recess],
        [0.0, height - recess],
    ])
}

/// A pressed tin with round corners.
fn tin(width: f64, depth: f64, height: f64, corner_radius: f64) -> Solid {
    extrude(&rounded_rectangle(width, depth, corner_radius), height)
}

/// A screw-top jar, lid included in the height.
fn jar(diameter: f64, height: f64, lid_diameter: f64) -> Solid {
    lathe(&jar_profile(diameter, height, lid_diameter))
}

fn jar_profile(diameter: f64, height: f64, lid_diameter: f64) -> [Point; 10] {
    let (radius, lid) = (diameter / 2.0, lid_diameter / 2.0);
    let lid_bottom = height - 16.0;
    [
        [0.0, 0.0],
        [radius - 3.0, 0.0],
        [radius, 4.0],
        [radius, lid_bottom - 14.0],
        [lid - 2.0, lid_bottom - 3.0],
        [lid - 2.0, lid_bottom],
        [lid, lid_bottom],
        [lid, height - 1.0],
        [lid - 1.0, height],
        [0.0, height],
    ]
}

fn mustard_bottle() -> Solid {
    loft(&[
        [0.0, 84.0, 50.0, 2.6],
        [5.0, 94.0, 58.0, 2.6],
        [60.0, 95.0, 58.0, 2.6],
        [95.0, 88.0, 52.0, 2.5],
        [125.0, 90.0, 55.0, 2.5],
        [143.0, 74.0, 50.0, 2.3],
        [152.0, 44.0, 40.0, 2.0],
        [154.0, 36.0, 36.0, 2.0],
        [170.0, 34.0, 34.0, 2.0],
        [173.0, 12.0, 12.0, 2.0],
        [191.0, 7.0, 7.0, 2.0],
    ])
}

fn bleach_bottle() -> Solid {
    loft(&[
        [0.0, 94.0, 60.0, 3.5],
        [6.0, 102.0, 68.0, 3.5],
        [130.0, 102.0, 68.0, 3.5],
        [165.0, 96.0, 62.0, 3.0],
        [195.0, 70.0, 48.0, 2.5],
        [212.0, 42.0, 38.0, 2.0],
        [214.0, 38.0, 38.0, 2.0],
        [246.0, 36.0, 36.0, 2.0],
        [250.0, 30.0, 30.0, 2.0],
    ])
}

fn shampoo_bottle() -> Solid {
    loft(&[
        [0.0, 66.0, 40.0, 2.2],
        [8.0, 74.0, 46.0, 2.2],
        [90.0, 78.0, 48.0, 2.2],
        [150.0, 66.0, 42.0, 2.1],
        [162.0, 48.0, 34.0, 2.0],
        [163.0, 50.0, 36.0, 2.0],
        [195.0, 48.0, 34.0, 2.0],
        [198.0, 44.0, 30.0, 2.0],
    ])
}

fn glue_bottle() -> Solid {
    loft(&[
        [0.0, 60.0, 36.0, 3.0],
        [4.0, 66.0, 40.0, 3.0],
        [95.0, 66.0, 40.0, 3.0],
        [112.0, 54.0, 35.0, 2.5],
        [120.0, 28.0, 26.0, 2.0],
        [122.0, 24.0, 24.0, 2.0],
        [130.0, 22.0, 22.0, 2.0],
        [158.0, 8.0, 8.0, 2.0],
        [160.0, 5.0, 5.0, 2.0],
    ])
}

/// A cleaner with a trigger head.
fn spray_bottle() -> Solid {
    let tank = block([98.0, 64.0, 150.0], 14.0).at(0.0, 0.0, 75.0 - 6.0);
    let neck = trunk(30.0, 13.0, 55.0).at(0.0, 0.0, 140.0);
    let collar = cylinder(15.0, 22.0).at(0.0, 0.0, 194.0);
    let head = block([78.0, 24.0, 32.0], 7.0).at(12.0, 0.0, 231.0);
    let nozzle = rod([46.0, 0.0, 236.0], [60.0, 0.0, 236.0], [9.0, 8.0]);
    let trigger = rod([34.0, 0.0, 224.0], [44.0, 0.0, 182.0], [6.0, 4.5]);
    tank.blended(neck, 18.0)
        .and(collar)
        .blended(head, 6.0)
        .and(nozzle)
        .and(trigger)
        .carved(3.5)
}

fn hand_soap_pump() -> Solid {
    let tank = cylinder(35.0, 112.0).blended(trunk(34.0, 15.0, 22.0).at(0.0, 0.0, 108.0), 6.0);
    let collar = cylinder(16.0, 18.0).at(0.0, 0.0, 127.0);
    let stem = cylinder(5.0, 32.0).at(0.0, 0.0, 140.0);
    let spout = rod([-12.0, 0.0, 172.0], [44.0, 0.0, 168.0], [8.0, 5.0]);
    tank.and(collar).and(stem).blended(spout, 4.0).carved(3.0)
}

/// A bag sealed at both ends, lying on its belly.
fn pillow_bag(width: f64, length: f64, thickness: f64) -> Solid {
    let seam = 2.0;
    // Share of the length, share of the thickness, share of the width.
    let stations = [
        (0.0, 0.0, 1.0),
        (0.05, 0.02, 1.0),
        (0.12, 0.42, 0.97),
        (0.22, 0.74, 0.93),
        (0.36, 0.95, 0.9),
        (0.5, 1.0, 0.89),
        (0.64, 0.95, 0.9),
        (0.78, 0.74, 0.93),
        (0.88, 0.42, 0.97),
        (0.95, 0.02, 1.0),
        (1.0, 0.0, 1.0),
    ];
    let sections = stations.map(|(along, bulge, spread)| {
        [
            along * length,
            seam + bulge * (thickness - seam),
            spread * width,
            2.4,
        ]
    });
    loft(&sections).lying(0.05 * thickness)
}

/// A block-bottom bag, folded to a flat seam at the top.
fn coffee_bag() -> Solid {
    let bulge = spline(
        &[
            [62.0, 0.0],
            [70.0, 40.0],
            [66.0, 95.0],
            [34.0, 140.0],
            [4.0, 165.0],
        ],
        3,
    );
    let mut sections: Vec<_> = bulge
        .iter()
        .map(|&[depth, z]| [z, 92.0, depth, 5.0])
        .collect();
    sections.push([182.0, 92.0, 3.0, 5.0]);
    loft(&sections)
}
