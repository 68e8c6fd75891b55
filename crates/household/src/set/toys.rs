//! Toys and balls.

use std::f64::consts::PI;

use crate::field::{Field, ball, block, cylinder, ellipsoid, rod};
use crate::outline::{arc, rectangle};
use crate::set::Recipe;
use crate::solid::Solid;
use crate::surfaces::{extrude, lathe_ring, superellipsoid};

/// How much a hard ball is flattened, in millimetres, so that its rest is a face and not a point.
const BALL_REST: f64 = 0.5;

pub(crate) const RECIPES: &[Recipe] = &[
    ("dice", 6.0, || {
        superellipsoid([16.5; 3], 9.0, 9.0).pressed(0.2)
    }),
    ("toy_brick", 26.0, || brick(4, 2)),
    ("puzzle_cube", 94.0, puzzle_cube),
    ("wood_block", 729.0, || {
        extrude(&rectangle(85.0, 85.0), 200.0)
    }),
    ("arch_block", 260.0, arch_block),
    ("stacking_ring", 65.0, || {
        lathe_ring(&arc([38.0, 18.0], 18.0, 0.0, 2.0 * PI * 15.0 / 16.0, 15)).pressed(BALL_REST)
    }),
    ("toy_car", 240.0, toy_car),
    ("toy_plane", 190.0, toy_plane),
    ("rubber_duck", 60.0, rubber_duck),
    ("tennis_ball", 58.0, || sphere(66.0)),
    ("softball", 185.0, || sphere(97.0)),
    ("mini_football", 140.0, || sphere(140.0)),
];

fn sphere(diameter: f64) -> Solid {
    superellipsoid([diameter; 3], 2.0, 2.0).pressed(BALL_REST)
}

/// A building brick of the large kind, with a stud on every 16 mm square.
fn brick(columns: u32, rows: u32) -> Solid {
    let pitch = 16.0;
    let (width, depth) = (pitch * f64::from(columns), pitch * f64::from(rows));
    let body = block([width, depth, 24.0], 1.0).at(width / 2.0, depth / 2.0, 10.0);
    let places = (0..columns).flat_map(|column| (0..rows).map(move |row| (column, row)));
    let studded = places.fold(body, |brick, (column, row)| {
        let [x, y] = [column, row].map(|place| pitch * (f64::from(place) + 0.5));
        brick.and(cylinder(4.7, 8.0).at(x, y, 18.0))
    });
    studded.carved(1.5)
}

/// A cube of 3 x 3 x 3 coloured pieces with grooves between them.
fn puzzle_cube() -> Solid {
    let cube = block([57.0; 3], 2.5);
    let grooves = [-9.5, 9.5].into_iter().flat_map(|offset| {
        let frame = move || {
            block([62.0, 62.0, 2.4], 0.0)
                .without(block([53.0, 53.0, 4.0], 0.0))
                .at(0.0, 0.0, offset)
        };
        [frame(), frame().about_x(90.0), frame().about_y(90.0)]
    });
    grooves
        .fold(cube, Field::without)
        .at(0.0, 0.0, 28.0)
        .carved(1.5)
}

fn arch_block() -> Solid {
    let mut side = vec![[-70.0, 0.0], [-35.0, 0.0]];
    side.extend(arc([0.0, 8.0], 35.0, PI, 0.0, 12));
    side.extend([[35.0, 0.0], [70.0, 0.0], [70.0, 70.0], [-70.0, 70.0]]);
    extrude(&side, 48.0).raised()
}

fn toy_car() -> Solid {
    let hull = block([140.0, 62.0, 28.0], 8.0).at(0.0, 0.0, 26.0);
    let cabin = block([74.0, 54.0, 34.0], 11.0).at(-8.0, 0.0, 46.0);
    let wheel = |x: f64| cylinder(16.0, 13.0).about_x(90.0).at(x, 36.0, 15.0);
    let wheels = wheel(-42.0).and(wheel(44.0)).mirrored();
    hull.blended(cabin, 8.0).and(wheels).carved(3.0)
}

fn toy_plane() -> Solid {
    let fuselage = rod([-95.0, 0.0, 27.0], [60.0, 0.0, 25.0], [11.0, 25.0]);
    let wings = block([50.0, 210.0, 8.0], 3.0).at(15.0, 0.0, 14.0);
    let tailplane = block([28.0, 80.0, 7.0], 3.0).at(-92.0, 0.0, 30.0);
    let fin = block([30.0, 7.0, 46.0], 3.0)
        .about_y(-15.0)
        .at(-92.0, 0.0, 52.0);
    let wheels = rod([20.0, 42.0, 6.0], [26.0, 42.0, 6.0], [8.0, 8.0]).mirrored();
    let tail_skid = rod([-90.0, 0.0, 6.0], [-90.0, 0.0, 20.0], [7.0, 7.0]);
    let frame = fuselage
        .blended(wings, 8.0)
        .blended(tailplane, 5.0)
        .blended(fin, 5.0);
    frame.and(wheels).and(tail_skid).carved(2.5)
}

fn rubber_duck() -> Solid {
    let body = ellipsoid([96.0, 78.0, 66.0]).at(0.0, 0.0, 26.0);
    let tail = rod([-34.0, 0.0, 36.0], [-54.0, 0.0, 54.0], [16.0, 4.0]);
    let head = ball(25.0).at(24.0, 0.0, 70.0);
    let bill = ellipsoid([30.0, 26.0, 10.0]).at(48.0, 0.0, 66.0);
    let wing = ellipsoid([50.0, 16.0, 32.0])
        .at(-6.0, 36.0, 32.0)
        .mirrored();
    body.blended(head, 12.0)
        .blended(tail, 10.0)
        .blended(bill, 4.0)
        .blended(wing, 4.0)
        .carved(3.0)
}
