//! Cartons and books.

use crate::outline::{arc, rectangle, regular};
use crate::set::Recipe;
use crate::solid::Solid;
use crate::surfaces::extrude;

pub(crate) const RECIPES: &[Recipe] = &[
    ("cracker_box", 411.0, || carton(60.0, 158.0, 210.0)),
    ("cereal_box", 430.0, || carton(55.0, 190.0, 235.0)),
    ("sugar_box", 514.0, || carton(38.0, 89.0, 175.0)),
    ("pudding_box", 187.0, || carton(110.0, 89.0, 35.0)),
    ("gelatin_box", 97.0, || carton(85.0, 73.0, 28.0)),
    ("tissue_box", 210.0, || carton(115.0, 115.0, 120.0)),
    ("medicine_box", 85.0, || carton(125.0, 72.0, 40.0)),
    ("toothpaste_box", 150.0, || carton(195.0, 48.0, 40.0)),
    ("milk_carton", 530.0, || gable_carton(70.0, 125.0, 30.0)),
    ("chocolate_prism", 360.0, || {
        extrude(&regular(3, 62.0), 290.0).laid_down()
    }),
    ("cookie_box", 400.0, || extrude(&regular(6, 150.0), 55.0)),
    ("hardcover_book", 640.0, || book(150.0, 215.0, 30.0)),
    ("paperback_book", 290.0, || carton(110.0, 178.0, 24.0)),
];

fn carton(width: f64, depth: f64, height: f64) -> Solid {
    extrude(&rectangle(width, depth), height)
}

/// A square drinks carton with a gabled top.
fn gable_carton(width: f64, shoulder: f64, roof: f64) -> Solid {
    let side = width / 2.0;
    let ridge = 1.5;
    let profile = [
        [-side, 0.0],
        [side, 0.0],
        [side, shoulder],
        [ridge, shoulder + roof],
        [ridge, shoulder + roof + 12.0],
        [-ridge, shoulder + roof + 12.0],
        [-ridge, shoulder + roof],
        [-side, shoulder],
    ];
    extrude(&profile, width).raised()
}

/// A bound book lying flat: a rounded spine, and pages that stand back from the covers' edges.
fn book(width: f64, height: f64, thickness: f64) -> Solid {
    let cover = 3.0;
    let page_inset = 4.0;
    let front = width / 2.0;
    let mut section = vec![
        [front, 0.0],
        [front, cover],
        [front - page_inset, cover],
        [front - page_inset, thickness - cover],
        [front, thickness - cover],
        [front, thickness],
    ];
    let (from, to) = (120.0_f64.to_radians(), 240.0_f64.to_radians());
    // An arc of 120 degrees over the thickness, bulging towards -x.
    let radius = thickness / 2.0 / from.sin();
    let centre = [-front + radius, thickness / 2.0];
    section.extend(arc(centre, radius, from, to, 6));
    extrude(&section, height).raised()
}
